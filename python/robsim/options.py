"""Checks of a simulation's options."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

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


def is_int(value: Any) -> bool:
    """Return whether it is an int, and no bool."""
    return isinstance(value, (int, np.integer)) and not isinstance(value, bool)


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
    if not is_int(phases):
        raise TypeError(f"phases must be an int, got {phases!r}")
    if not 1 <= phases <= 360:
        raise ValueError(f"phases must lie within 1..360, got {phases}")
    is_turned = choice("rotation", rotation, ("phases", "continuous")) == "continuous"
    return 0 if is_turned else int(phases)


def share(name: str, value: Any) -> float:
    """Return a number within 0..1."""
    if isinstance(value, bool) or not isinstance(value, (int, float, np.integer, np.floating)):
        raise TypeError(f"{name} must be a number within 0..1, got {value!r}")
    if not 0 <= value <= 1:
        raise ValueError(f"{name} must lie within 0..1, got {value!r}")
    return float(value)


def count(name: str, value: Any) -> int:
    """Return an int of at least 1."""
    if not is_int(value):
        raise TypeError(f"{name} must be an int, got {value!r}")
    if not 1 <= value < 2**31:
        raise ValueError(f"{name} must be at least 1 and below 2**31, got {value}")
    return int(value)


def visual_noise(kind: str, percent: float | None) -> VisualNoise:
    """Return the noise of the camera of a kind and a level."""
    choice("noise", kind, ("none", "uniform", "gaussian"))
    if percent is not None:
        if isinstance(percent, bool) or not isinstance(percent, (int, float, np.number)):
            raise TypeError(f"noise_percent must be a number, got {percent!r}")
        if not (np.isrealobj(percent) and 0 <= percent < np.inf):
            raise ValueError(f"noise_percent must be at least 0 and finite, got {percent!r}")
    if kind != "none" and percent is None:
        raise ValueError(f"noise={kind!r} needs a level: give noise_percent=..., such as 40")
    if kind == "none" and percent:
        raise ValueError(
            f"noise_percent={percent} needs a kind: give noise='uniform' or noise='gaussian'"
        )
    return VisualNoise(kind, min(float(percent or 0), 1e9))
