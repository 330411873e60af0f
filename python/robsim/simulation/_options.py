"""Checks of arguments that only `Simulation` takes: steps, start pose, number of headings."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from robsim._base.checks import check_int, is_int

_MAXIMUM_START = 1e6  # work-area px


def step_count(steps: Any) -> int:
    """Return `steps` as an int of at least 0; else raise TypeError or ValueError."""
    if not is_int(steps):
        raise TypeError(f"steps must be an int, got {steps!r}")
    if not 0 <= steps < 2**62:
        raise ValueError(f"steps must be at least 0 and below 2**62, got {steps}")
    return int(steps)


def start_within(start: ArrayLike, area: tuple[int, int] | None) -> ArrayLike:
    """Return a start pose after a check of its position; the C++ core checks the rest."""
    try:
        numbers = np.asarray(start)
    except ValueError:
        return start
    if numbers.shape != (3,) or numbers.dtype.kind not in "iuf":
        return start
    x, y, _ = numbers.astype(float)
    if area and not (0 <= x <= area[0] - 1 and 0 <= y <= area[1] - 1):
        raise ValueError(
            f"start must lie within the area of {area[0]} x {area[1]} px, got {start!r}"
        )
    if max(abs(x), abs(y)) > _MAXIMUM_START:
        raise ValueError(f"start must lie within {_MAXIMUM_START:g} px, got {start!r}")
    return start


def heading_count(headings: int | None) -> int:
    """Return the number of headings that the robot is drawn in; 0 for None (continuous)."""
    return 0 if headings is None else check_int("headings", headings, minimum=1, maximum=360)
