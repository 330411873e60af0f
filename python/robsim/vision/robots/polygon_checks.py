"""Type, shape and range checks of points and polygons, for robot definitions."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from robsim.base.checks import Floats
from robsim.base.text import quoted

_MAXIMUM_POINTS = 1000
_MAXIMUM_COORDINATE = 1e6  # image px, beyond any image


def finite_array(name: str, value: Any, shape: tuple[int, ...]) -> Floats:
    """Return `value` as a float array of finite numbers with this shape; -1 = any size."""
    try:
        result = np.asarray(value)
    except (TypeError, ValueError):
        result = np.empty(0, dtype=object)
    if not _fits(result, shape):
        raise ValueError(f"{name} must be finite numbers of shape {shape}, got {quoted(value)}")
    return result.astype(np.float64)


def _fits(array: NDArray[Any], shape: tuple[int, ...]) -> bool:
    if array.dtype.kind not in "iuf" or array.ndim != len(shape):
        return False
    if any(size not in (-1, got) for size, got in zip(shape, array.shape, strict=True)):
        return False
    return bool(np.isfinite(array).all())


def polygon(name: str, value: Any) -> Floats:
    """Return `value` as a polygon (N, 2) of nonzero area, without consecutive duplicates."""
    points = finite_array(name, value, (-1, 2))
    if abs(points).max(initial=0) > _MAXIMUM_COORDINATE:
        raise ValueError(
            f"{name} must be a polygon within {_MAXIMUM_COORDINATE:g} px, got {quoted(value)}"
        )
    if len(points) > 1:
        points = np.asarray(points[(points != np.roll(points, -1, axis=0)).any(axis=1)])
    if not 3 <= len(points) <= _MAXIMUM_POINTS:
        raise ValueError(
            f"{name} must be a polygon of 3 to {_MAXIMUM_POINTS} different points, got "
            f"{len(np.unique(points, axis=0))}"
        )
    if np.linalg.matrix_rank(points - points[0], tol=1e-6) < 2:
        raise ValueError(f"{name} must be a polygon of nonzero area, got points on a line")
    return points
