"""Type, shape and range checks of points and polygons, for robot definitions."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robsim.base.checks import Floats
from robsim.base.text import quoted
from robsim.vision.robots.polygons import area_and_centroid, crossing, depths, samples

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
            f"{name} must be a polygon within +-{_MAXIMUM_COORDINATE:g} px, got {quoted(value)}"
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


_TOLERANCE = 1.0  # image px
_MAXIMUM_LISTED = 3  # points in a sentence


def geometry_problems(
    *, width: int, height: int, centre: Floats, outline: Floats, markers: Mapping[str, Floats]
) -> list[str]:
    """Return problems of a robot's geometry (image px), a sentence each; empty if it is valid.

    `centre` (2,), `outline` (N, 2); `markers` are two polygons (N, 2) by their names in the
    sentences.
    """
    polygons = {"outline": outline, **markers}
    crossings = [_crossing(name, polygon) for name, polygon in polygons.items()]
    problems = [sentence for sentence in crossings if sentence]
    problems += _outside_image(outline, width, height)
    if problems:
        return problems
    for name, points in {"centre": centre[np.newaxis], **markers}.items():
        problems += _outside_outline(name, points, outline)
    return problems + _overlap(markers)


def _crossing(name: str, polygon: Floats) -> str | None:
    pair = crossing(polygon)
    if pair is None:
        return None
    sides = [_listed(polygon[[i, (i + 1) % len(polygon)]], " to ") for i in pair]
    return f"{name} must not intersect itself: the side {sides[0]} meets the side {sides[1]}"


def _outside_image(outline: Floats, width: int, height: int) -> list[str]:
    beyond = np.maximum(-0.5 - outline, outline - (width - 0.5, height - 0.5)).max(axis=1)
    out = beyond > _TOLERANCE
    if not out.any():
        return []
    return [
        f"outline must lie within the image of {width} x {height} px: outside is "
        f"{_listed(outline[out])}, by up to {beyond.max():.1f} px"
    ]


def _outside_outline(name: str, points: Floats, outline: Floats) -> list[str]:
    """Return the sentence for a point (1, 2), or a polygon (N, 2), outside the outline."""
    positions = points if len(points) == 1 else samples(points)
    depth = depths(outline, positions)
    if depth.min() >= -_TOLERANCE:
        return []
    corners = points[depths(outline, points) < -_TOLERANCE]
    shown = corners if len(corners) else positions[[depth.argmin()]]
    return [
        f"{name} must lie inside the outline: outside is {_listed(shown)}, "
        f"by up to {-depth.min():.1f} px"
    ]


def _overlap(markers: Mapping[str, Floats]) -> list[str]:
    """Return the sentence for markers that overlap; a common edge is not an overlap."""
    first, second = markers.values()
    maximum_depth, position = _TOLERANCE, None
    for inner, outer in ((first, second), (second, first)):
        points = samples(inner)
        _, centroid = area_and_centroid(inner)
        if depths(inner, centroid[np.newaxis]) > 0:
            points = np.vstack((points, centroid))
        depth = depths(outer, points)
        if depth.max() > maximum_depth:
            maximum_depth, position = float(depth.max()), points[[depth.argmax()]]
    if position is None:
        return []
    return [f"{' and '.join(markers)} must not overlap: they do around {_listed(position)}"]


def _listed(points: Floats, between: str = ", ") -> str:
    text = between.join(f"({x:.5g}, {y:.5g})" for x, y in points[:_MAXIMUM_LISTED])
    more = len(points) - _MAXIMUM_LISTED
    return f"{text} and {more} more" if more > 0 else text
