"""Checks of what only a simulation takes: steps, start pose, headings shown."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from robsim._base.checks import check_int, is_int

_FARTHEST_START = 1e6


def step_count(steps: Any) -> int:
    """Return a number of steps, at least 0."""
    if not is_int(steps):
        raise TypeError(f"steps must be an int, got {steps!r}")
    if not 0 <= steps < 2**62:
        raise ValueError(f"steps must be at least 0 and below 2**62, got {steps}")
    return int(steps)


def start_within(start: ArrayLike, area: tuple[int, int] | None) -> ArrayLike:
    """Return a start pose after a look at its place; the core looks at the rest."""
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
    if max(abs(x), abs(y)) > _FARTHEST_START:
        raise ValueError(f"start must lie within {_FARTHEST_START:g} px, got {start!r}")
    return start


def heading_count(headings: int | None) -> int:
    """Return the number of headings that the robot is shown in; 0 = any, for None."""
    return 0 if headings is None else check_int("headings", headings, minimum=1, maximum=360)
