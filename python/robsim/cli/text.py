"""Parsers of option texts (sizes, regions, points, noise, controllers, ...), for the commands."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from robsim.base.checks import check_choice
from robsim.base.spelling import suggestion
from robsim.base.text import quoted
from robsim.cli import errors
from robsim.control.by_name import NAMES, POINTS, controller_named
from robsim.simulation import Dropout
from robsim.vision.imaging.noise import NOISES, Noise

Points = list[tuple[float, float]]
Region = tuple[int, int, int, int]


@contextmanager
def about(option: str, *names: str) -> Iterator[None]:
    """Begin the message of an error inside the context with its option.

    The option replaces the name of an argument if the message begins with one of `names`.
    """
    with errors.names(dict.fromkeys(names, option)):
        try:
            yield
        except (TypeError, ValueError) as error:
            message = errors.in_shell_words(str(error))
            is_named = message.startswith("--")
            raise ValueError(message if is_named else f"{option}: {message}") from error


def parse_size(option: str, text: str | None) -> tuple[int, int] | None:
    """Return width and height from text such as 640x480."""
    if text is None:
        return None
    width, _, height = text.lower().partition("x")
    if not (width.isdecimal() and height.isdecimal()):
        raise ValueError(f"{option} must be a size such as 640x480, got {quoted(text)}")
    return int(width), int(height)


def parse_noise(option: str, text: str | None) -> Noise | None:
    """Return the noise from text such as gaussian:10."""
    if text is None:
        return None
    kind, _, percent = text.lower().partition(":")
    if kind not in NOISES or not _is_number(percent):
        raise ValueError(
            f"{option} must be a noise such as gaussian:10 or uniform:10, got {quoted(text)}"
            + ("" if kind in NOISES else suggestion(kind, NOISES))
        )
    with about(option):
        return NOISES[kind](float(percent))


def parse_dropout(option: str, text: str) -> Dropout:
    """Return the dropout from text such as 0.2, or 0.2:5 for 5 steps at a time."""
    probability, colon, steps = text.partition(":")
    if not _is_number(probability) or (colon and not steps.isdecimal()):
        raise ValueError(
            f"{option} must be a probability such as 0.2, or 0.2:5 for 5 steps, got {quoted(text)}"
        )
    with errors.names({"steps": f"{option}: steps"}), about(option):
        return Dropout(float(probability), int(steps) if colon else 1)


def parse_headings(option: str, text: str) -> int | None:
    """Return the number of headings from text such as 36; None for continuous."""
    if text == "continuous":
        return None
    if not text.isdecimal():
        raise ValueError(f"{option} must be a number such as 36, or continuous, got {quoted(text)}")
    return int(text)


def parse_speed(option: str, text: str | None) -> float | None:
    """Return the multiple of real time from text such as 2; inf from max."""
    if text is None:
        return None
    if text == "max":
        return math.inf
    if not _is_number(text):
        raise ValueError(f"{option} must be a number such as 2, or max, got {quoted(text)}")
    if not 0 < (speed := float(text)) < math.inf:
        raise ValueError(f"{option} must be above 0, or max, got {text}")
    return speed


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def parse_control(option: str, text: str | None) -> Callable[..., Any] | None:
    """Return the controller from text such as drive-around or go-to-point:900,300."""
    if text is None:
        return None
    name, colon, points = text.partition(":")
    check_choice(option, name, NAMES)
    if name not in POINTS:
        if colon:
            raise ValueError(f"{option} {name} takes no points, got {quoted(text)}")
        return controller_named(name)
    found = parse_points(option, points, count=POINTS[name], minimum=1, prefix=f"{name}:")
    with about(option):
        return controller_named(name, found or ())


def parse_start(option: str, text: str) -> tuple[float, float, float] | str:
    """Return the pose from text such as 300,300,90, in px, px and degrees; or "random"."""
    if text == "random":
        return text
    parts = text.split(",")
    numbers = [float(part) for part in parts if _is_number(part)]
    if len(parts) != 3 or len(numbers) != 3 or not all(map(math.isfinite, numbers)):
        raise ValueError(
            f"{option} must be x,y,heading in px, px and degrees, such as 300,300,90, or random, "
            f"got {quoted(text)}"
        )
    x, y, degrees = numbers
    return x, y, math.radians(math.remainder(degrees, 360))


def parse_region(option: str, text: str) -> Region:
    """Return left, top, right, bottom from text such as 573,609,599,634."""
    parts = [part.strip() for part in text.split(",")]
    if len(parts) != 4 or not all(re.fullmatch(r"\d{1,5}", part) for part in parts):
        raise ValueError(
            f"{option} must be left,top,right,bottom in px, such as 573,609,599,634, "
            f"got {quoted(text)}"
        )
    left, top, right, bottom = map(int, parts)
    return left, top, right, bottom


def parse_points(
    option: str, text: str | None, *, count: int | None = None, minimum: int = 3, prefix: str = ""
) -> Points | None:
    """Return points from text such as "120,40 180,40 180,90": `count`, or at least `minimum`.

    An error shows the text with its `prefix`.
    """
    if text is None:
        return None
    try:
        found = [(float(x), float(y)) for x, y in (pair.split(",") for pair in text.split())]
    except ValueError:
        found = []
    if len(found) != count and (count or len(found) < minimum):
        example, points = _EXAMPLES[count or -minimum]
        which = f"{prefix} and {points}" if prefix else points
        raise ValueError(
            f"{option} must be {which} such as '{prefix}{example}', got '{prefix}{text}'"
        )
    return found


# Keys: the number of points; -n means n or more.
_EXAMPLES = {
    -3: ("120,40 180,40 180,90", "at least three points X,Y"),
    -1: ("400,400 800,400", "one or more points X,Y"),
    1: ("240,250", "one point X,Y"),
    -4: ("0,0 9,0 9,9 0,9", "at least four points X,Y"),
}


def parse_point(option: str, text: str | None) -> tuple[float, float] | None:
    """Return a point from text such as 240,250."""
    found = parse_points(option, text, count=1)
    return found[0] if found else None
