"""Checks of a simulation's options."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from robsim._base.checks import check_float, check_int, is_int
from robsim._core import VisualNoise

_FARTHEST_START = 1e6


def size(name: str, value: Any) -> tuple[int, int]:
    """Return a size (width, height), two ints within 16..16384 px."""
    try:
        width, height = value
    except (TypeError, ValueError):
        raise TypeError(f"{name} must be (width, height) in px, got {value!r}") from None
    for size in (width, height):
        if not is_int(size):
            raise TypeError(f"{name} must be (width, height), two ints in px, got {value!r}")
        if not 16 <= size <= 16384:
            raise ValueError(f"{name} must lie within 16..16384 px, got {value!r}")
    return int(width), int(height)


def step_count(steps: Any) -> int:
    """Return a number of steps, at least 0."""
    if not is_int(steps):
        raise TypeError(f"steps must be an int, got {steps!r}")
    if not 0 <= steps < 2**62:
        raise ValueError(f"steps must be at least 0 and below 2**62, got {steps}")
    return int(steps)


def choice(name: str, value: Any, choices: tuple[str, ...]) -> str:
    """Return the value if it is one of the choices."""
    if not isinstance(value, str):
        raise TypeError(f"{name} must be one of {', '.join(map(repr, choices))}, got {value!r}")
    if value not in choices:
        raise ValueError(f"{name} must be one of {', '.join(map(repr, choices))}, got {value!r}")
    return value


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


def phase_count(rotation: str, phases: int) -> int:
    """Return the number of phases that a rotation is shown in; 0 = any heading."""
    phases = check_int("phases", phases, minimum=1, maximum=360)
    is_turned = choice("rotation", rotation, ("phases", "continuous")) == "continuous"
    return 0 if is_turned else phases


def visual_noise(kind: str, percent: float | None) -> VisualNoise:
    """Return the noise of the camera of a kind and a level."""
    choice("noise", kind, ("none", "uniform", "gaussian"))
    if percent is not None:
        percent = check_float("noise_percent", percent, "%", minimum=0)
    if kind != "none" and percent is None:
        raise ValueError(f"noise={kind!r} needs a level: give noise_percent=..., such as 40")
    if kind == "none" and percent:
        raise ValueError(
            f"noise_percent={percent} needs a kind: give noise='uniform' or noise='gaussian'"
        )
    return VisualNoise(kind, min(percent or 0.0, 1e9))
