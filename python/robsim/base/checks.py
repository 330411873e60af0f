"""Checks of single arguments, used by every public function: numbers, arrays, choices, sizes."""

from __future__ import annotations

import math
import unicodedata
from collections.abc import Iterable
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from robsim.base.spelling import suggestion, with_article
from robsim.base.text import quoted

Floats = NDArray[np.float64]
_Text = TypeVar("_Text", bound=str)
#: Longest name of a colour or a robot (characters).
LONGEST_NAME = 40


def check_float(
    name: str,
    value: Any,
    unit: str = "",
    *,
    minimum: float = -math.inf,
    exclusive_minimum: float = -math.inf,
    maximum: float = math.inf,
) -> float:
    """Return `value` as a finite float within limits; else raise TypeError or ValueError."""
    unit = f" ({unit})" if unit else ""
    if isinstance(value, bool) or not isinstance(value, (int, float, np.integer, np.floating)):
        raise TypeError(f"{name} must be a number{unit}, got {quoted(value)}")
    try:
        result = float(value)
    except OverflowError:
        result = math.inf
    if not (math.isfinite(result) and minimum <= result <= maximum and exclusive_minimum < result):
        limits = _limits(minimum, exclusive_minimum, maximum)
        raise ValueError(f"{name} must {limits}{unit}, got {quoted(value)}")
    return result


def _limits(minimum: float, exclusive_minimum: float, maximum: float) -> str:
    if math.isfinite(maximum) and math.isfinite(exclusive_minimum):
        return f"be above {exclusive_minimum:g} and at most {maximum:g}"
    if math.isfinite(maximum):
        return f"lie within {minimum:g}..{maximum:g}"
    if math.isfinite(exclusive_minimum):
        return f"be finite and above {exclusive_minimum:g}"
    return "be finite" + (f" and at least {minimum:g}" if math.isfinite(minimum) else "")


def check_kind(name: str, value: Any, kind: type, *, or_none: bool = False) -> Any:
    """Return `value` if it is of a kind, or None where that is allowed; else raise TypeError."""
    if not (isinstance(value, kind) or (or_none and value is None)):
        expected = with_article(kind.__name__) + (" or None" if or_none else "")
        raise TypeError(f"{name} must be {expected}, got {quoted(value)}")
    return value


def check_heading(name: str, heading: float) -> None:
    """Raise ValueError if a pose's heading is beyond -2 pi..2 pi, as headings in degrees are."""
    if abs(heading) > 2 * math.pi:
        raise ValueError(
            f"{name} must have a heading in rad within -2 pi..2 pi, got {heading:g}; for a "
            f"heading in degrees, use numpy.radians({heading:g}) = {math.radians(heading):.4g} rad"
        )


def check_kinds(name: str, values: Any, kind: type) -> tuple[Any, ...]:
    """Return `values` as a tuple if all are of a kind; else raise TypeError."""
    expected = f"{name} must be a sequence of {kind.__name__}"
    if not isinstance(values, Iterable):
        raise TypeError(f"{expected}, got {quoted(values)}")
    entries = tuple(values)
    for entry in entries:
        if not isinstance(entry, kind):
            raise TypeError(f"{expected}, got one of {quoted(entry)}")
    return entries


def is_int(value: Any) -> bool:
    return isinstance(value, (int, np.integer)) and not isinstance(value, bool)


def check_int(name: str, value: Any, *, minimum: int, maximum: int) -> int:
    """Return `value` as an int within limits; else raise TypeError or ValueError."""
    if not is_int(value):
        raise TypeError(f"{name} must be an int, got {quoted(value)}")
    if not minimum <= value <= maximum:
        raise ValueError(f"{name} must lie within {minimum}..{maximum}, got {quoted(value)}")
    return int(value)


def as_float_array(name: str, values: Any) -> Floats:
    """Return `values` as a float array of any shape; NaN and infinity are allowed."""
    try:
        given = np.asarray(values)
        # No text, dates or complex numbers. None in an array is NaN: not known.
        if given.dtype.kind not in "biufO" or values is None:
            raise TypeError(given.dtype)
        return given.astype(np.float64, copy=False)
    except (TypeError, ValueError, OverflowError):  # rows of different lengths, too
        message = f"{name} must be an array of numbers, got {quoted(values)}"
        raise TypeError(message) from None


def check_bool(name: str, value: Any) -> bool:
    """Return `value` if it is True or False; else raise TypeError."""
    if not isinstance(value, (bool, np.bool_)):
        raise TypeError(f"{name} must be True or False, got {quoted(value)}")
    return bool(value)


def check_callable(name: str, value: Any) -> None:
    """Raise TypeError unless the argument is None, or can be called."""
    if value is not None and not callable(value):
        raise TypeError(f"{name} must be callable, got {quoted(value)}")


def check_text(name: str, value: Any) -> str:
    """Return `value` if it is text; else raise TypeError."""
    if not isinstance(value, str):
        raise TypeError(f"{name} must be text, got {quoted(value)}")
    return value


def check_name(argument: str, name: Any) -> str:
    """Return a name of 1 to 40 printable characters; else raise TypeError or ValueError."""
    text = check_text(argument, name)
    if not (0 < len(text) <= LONGEST_NAME and text.isprintable()):
        raise ValueError(
            f"{argument} must be 1 to {LONGEST_NAME} printable characters, got {quoted(text)}"
        )
    return text


def check_words(argument: str, name: Any) -> str:
    """Return a colour name that files and shells read unchanged.

    Raises TypeError or ValueError unless the name has 1 to 40 letters, digits, spaces, - and _. The
    first must be a letter or a digit.
    """
    text = check_text(argument, name)
    if not is_plain(text, "-_ "):
        raise ValueError(
            f"{argument} must be 1 to {LONGEST_NAME} letters, digits, spaces, - and _, starting "
            f"with a letter or a digit, got {quoted(text)}"
        )
    return text


def is_plain(name: str, others: str) -> bool:
    """Whether a name consists of letters, with their marks, digits, and some others within it."""
    if not 0 < len(name) <= LONGEST_NAME:
        return False
    kinds = [unicodedata.category(character) for character in name]  # L letter, M mark, N number
    is_plain = (k[0] in "LM" or k == "Nd" or c in others for k, c in zip(kinds, name, strict=True))
    return kinds[0][0] in "LN" and all(is_plain)


def check_choice(name: str, value: Any, choices: tuple[_Text, ...]) -> _Text:
    """Return `value` if it is one of `choices`; else raise TypeError or ValueError."""
    expected = f"{name} must be one of {', '.join(map(repr, choices))}, got {quoted(value)}"
    if not isinstance(value, str):
        raise TypeError(expected)
    if value not in choices:
        raise ValueError(expected + suggestion(value, choices))
    return choices[choices.index(value)]


def check_mm_per_px(value: Any, name: str = "mm_per_px") -> float:
    """Return the length of a px of the work area on the floor (mm)."""
    return check_float(name, value, "mm", minimum=1e-3, maximum=1e4)


def check_size(name: str, value: Any) -> tuple[int, int]:
    """Return a size (width, height), two ints within 16..16384 px."""
    try:
        width, height = value
    except (TypeError, ValueError):
        raise TypeError(f"{name} must be (width, height) in px, got {quoted(value)}") from None
    for size in (width, height):
        if not is_int(size):
            raise TypeError(f"{name} must be (width, height), two ints in px, got {quoted(value)}")
        if not 16 <= size <= 16384:
            raise ValueError(f"{name} must lie within 16..16384 px, got {quoted(value)}")
    return int(width), int(height)
