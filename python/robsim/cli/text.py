"""Text into sizes and points."""

from __future__ import annotations

Points = list[tuple[float, float]]


def size(option: str, text: str | None) -> tuple[int, int] | None:
    """Return width and height from text such as 640x480."""
    if text is None:
        return None
    width, _, height = text.lower().partition("x")
    if not (width.isdecimal() and height.isdecimal()):
        raise ValueError(f"{option} must be a size such as 640x480, got {text!r}")
    return int(width), int(height)


def points(option: str, text: str | None, *, count: int | None = None) -> Points | None:
    """Return points from text such as "120,40 180,40 180,90": so many, or at least three."""
    if text is None:
        return None
    try:
        found = [(float(x), float(y)) for x, y in (pair.split(",") for pair in text.split())]
    except ValueError:
        found = []
    if len(found) != count and (count or len(found) < 3):
        example, number = _EXAMPLES[count]
        raise ValueError(f"{option} must be {number} such as '{example}', got {text!r}")
    return found


_EXAMPLES = {
    None: ("120,40 180,40 180,90", "at least three points right,down"),
    1: ("240,250", "one point right,down"),
    4: ("0,0 9,0 9,9 0,9", "four points"),
}


def point(option: str, text: str | None) -> tuple[float, float] | None:
    """Return a point from text such as 240,250."""
    found = points(option, text, count=1)
    return found[0] if found else None
