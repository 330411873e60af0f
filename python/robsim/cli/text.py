"""Text into sizes, regions and points."""

from __future__ import annotations

import re

Points = list[tuple[float, float]]


def size(option: str, text: str | None) -> tuple[int, int] | None:
    """Return width and height from text such as 640x480."""
    if text is None:
        return None
    width, _, height = text.lower().partition("x")
    if not (width.isdecimal() and height.isdecimal()):
        raise ValueError(f"{option} must be a size such as 640x480, got {text!r}")
    return int(width), int(height)


def region(option: str, text: str) -> tuple[int, int, int, int]:
    """Return left, top, right, bottom from text such as 573,609,599,634."""
    parts = [part.strip() for part in text.split(",")]
    if len(parts) != 4 or not all(re.fullmatch(r"\d{1,5}", part) for part in parts):
        raise ValueError(
            f"{option} must be left,top,right,bottom in px, such as 573,609,599,634, got {text!r}"
        )
    left, top, right, bottom = map(int, parts)
    return left, top, right, bottom


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
