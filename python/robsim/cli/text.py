"""Parsers of option texts (sizes, regions, points, noise, dropouts), for the commands."""

from __future__ import annotations

import re

from robsim.imaging import GaussianNoise, UniformNoise
from robsim.simulation import Dropout

Points = list[tuple[float, float]]


def parse_size(option: str, text: str | None) -> tuple[int, int] | None:
    """Return width and height from text such as 640x480."""
    if text is None:
        return None
    width, _, height = text.lower().partition("x")
    if not (width.isdecimal() and height.isdecimal()):
        raise ValueError(f"{option} must be a size such as 640x480, got {text!r}")
    return int(width), int(height)


def parse_noise(option: str, text: str | None) -> GaussianNoise | UniformNoise | None:
    """Return the noise from text such as gaussian:10."""
    if text is None:
        return None
    kind, _, percent = text.lower().partition(":")
    kinds: dict[str, type[GaussianNoise | UniformNoise]] = {
        "gaussian": GaussianNoise,
        "uniform": UniformNoise,
    }
    if kind not in kinds or not _is_number(percent):
        raise ValueError(
            f"{option} must be a noise such as gaussian:10 or uniform:10, got {text!r}"
        )
    return kinds[kind](float(percent))


def parse_dropout(option: str, text: str | None) -> Dropout | None:
    """Return the dropout from text such as 0.2, or 0.2:5 for 5 steps at a time."""
    if text is None:
        return None
    probability, colon, steps = text.partition(":")
    if not _is_number(probability) or (colon and not steps.isdecimal()):
        raise ValueError(
            f"{option} must be a probability such as 0.2, or 0.2:5 for 5 steps, got {text!r}"
        )
    return Dropout(float(probability), int(steps) if colon else 1)


def parse_headings(option: str, text: str) -> int | None:
    """Return the number of headings from text such as 36; None for continuous."""
    if text == "continuous":
        return None
    if not text.isdecimal():
        raise ValueError(f"{option} must be a number such as 36, or continuous, got {text!r}")
    return int(text)


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def parse_region(option: str, text: str) -> tuple[int, int, int, int]:
    """Return left, top, right, bottom from text such as 573,609,599,634."""
    parts = [part.strip() for part in text.split(",")]
    if len(parts) != 4 or not all(re.fullmatch(r"\d{1,5}", part) for part in parts):
        raise ValueError(
            f"{option} must be left,top,right,bottom in px, such as 573,609,599,634, got {text!r}"
        )
    left, top, right, bottom = map(int, parts)
    return left, top, right, bottom


def parse_points(option: str, text: str | None, *, minimum: int = 3) -> Points | None:
    """Return points from text such as "120,40 180,40 180,90"; one if the minimum is 1."""
    if text is None:
        return None
    try:
        found = [(float(x), float(y)) for x, y in (pair.split(",") for pair in text.split())]
    except ValueError:
        found = []
    if len(found) < minimum or (minimum == 1 and len(found) > 1):
        example, number = _EXAMPLES[minimum]
        raise ValueError(f"{option} must be {number} such as '{example}', got {text!r}")
    return found


_EXAMPLES = {
    3: ("120,40 180,40 180,90", "at least three points right,down"),
    1: ("240,250", "one point right,down"),
    4: ("0,0 9,0 9,9 0,9", "at least four points"),
}


def parse_point(option: str, text: str | None) -> tuple[float, float] | None:
    """Return a point from text such as 240,250."""
    found = parse_points(option, text, minimum=1)
    return found[0] if found else None
