"""Numbers as people read them, and as plain values for files."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from robsim.base.checks import check_float, check_int

#: A format specification such as ``".4g"``, or a function of the value that returns its text.
Format = str | Callable[[Any], str]

# What people read in place of a unit, and how many of it are one.
_READ = {"rad": ("deg", math.degrees(1.0))}


def percent(fraction: float, decimals: int = 1) -> str:
    """Return a fraction as a text such as ``"75.0 %"``.

    Only nothing is 0 %, and only all is 100 %: what is nearly so gets more decimals.

    Parameters
    ----------
    fraction : float
        The fraction, at least 0: 1 is 100 %.
    decimals : int
        Number of decimals, if they are enough, within 0..3.
    """
    if not (isinstance(fraction, float) and fraction == math.inf):
        check_float("fraction", fraction, minimum=0)
    check_int("decimals", decimals, minimum=0, maximum=3)
    if fraction in (0.0, 1.0):
        return f"{100 * fraction:.0f} %"
    if fraction > 10.0:
        return "> 1000 %"
    for more in range(decimals, 4):
        text = f"{100 * fraction:.{more}f}"
        if float(text) not in (0.0, 100.0):
            return f"{text} %"
    if fraction > 1.0:
        return "> 100 %"
    return "< 0.001 %" if fraction < 0.5 else "> 99.999 %"


def count(part: int, whole: int) -> str:
    return f"{part} ({percent(part / whole)})" if whole else f"{part}"


def interval(limits: Any) -> str:
    """Return two limits as a text such as ``"2.79 to 3.22"``."""
    low, high = limits
    return f"{low:.3g} to {high:.3g}"


def shown_unit(unit: str) -> str:
    """Return the unit that people read: degrees in place of rad."""
    return _READ[unit][0] if unit in _READ else unit


def shown(value: Any, unit: str, format_: Format, missing: str) -> str:
    """Return a value in `shown_unit` as people read it; `missing` for None and NaN."""
    if value is None or (isinstance(value, (float, np.floating)) and math.isnan(value)):
        return missing
    if unit in _READ:
        value = value * _READ[unit][1]
    if callable(format_):
        return format_(value)
    is_float = isinstance(value, (float, np.floating))
    return format(value, format_) if is_float else str(value)


def plain(value: Any) -> Any:
    """Return a value without types of numpy, as JSON has it: None for NaN and infinity."""
    if isinstance(value, (np.generic, np.ndarray)):
        value = value.tolist()
    if isinstance(value, Mapping):
        return {str(key): plain(entry) for key, entry in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(entry) for entry in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
