"""Checked points and polygons."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from robsim._base.checks import Floats

_MOST_POINTS = 1000
_FARTHEST = 1e6  # image px, beyond any image


def numbers(name: str, value: Any, shape: tuple[int, ...]) -> Floats:
    """Return finite numbers of a shape; -1 = any size."""
    try:
        result = np.asarray(value)
    except (TypeError, ValueError):
        result = np.empty(0, dtype=object)
    if not _fits(result, shape):
        raise ValueError(f"{name} must be finite numbers of shape {shape}, got {value!r}")
    return result.astype(np.float64)


def _fits(array: NDArray[Any], shape: tuple[int, ...]) -> bool:
    if array.dtype.kind not in "iuf" or array.ndim != len(shape):
        return False
    if any(size not in (-1, got) for size, got in zip(shape, array.shape, strict=True)):
        return False
    return bool(np.isfinite(array).all())


def polygon(name: str, value: Any) -> Floats:
    """Return a polygon (N, 2) with an area; points that come twice in a row count once."""
    points = numbers(name, value, (-1, 2))
    if abs(points).max(initial=0) > _FARTHEST:
        raise ValueError(f"{name} must be a polygon within {_FARTHEST:g} px, got {value!r}")
    if len(points) > 1:
        points = np.asarray(points[(points != np.roll(points, -1, axis=0)).any(axis=1)])
    if not 3 <= len(points) <= _MOST_POINTS:
        raise ValueError(
            f"{name} must be a polygon of 3 to {_MOST_POINTS} different points, got "
            f"{len(np.unique(points, axis=0))}"
        )
    if np.linalg.matrix_rank(points - points[0], tol=1e-6) < 2:
        raise ValueError(f"{name} must be a polygon with an area, got points on a line")
    return points
