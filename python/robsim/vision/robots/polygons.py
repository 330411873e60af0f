"""Geometry of polygons, such as robot outlines and markers.

A polygon is an array (N, 2) of corners; the last corner is joined to the first.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from robsim.base.checks import Floats
from robsim.vision.markers.training import square_within

_MAXIMUM_SAMPLES = 2000
_THINNEST = 1e-9  # distance of a point from the line of a side
_FARTHEST = 6.0  # standard deviations
_MINIMUM_INSIDE = 0.8  # fraction of a box that must lie in the polygon


def area_and_centroid(polygon: Floats) -> tuple[float, Floats]:
    """Return area and centroid (2,) by the shoelace formula; without area, the corners' mean."""
    a = polygon - polygon[0]
    b = np.roll(a, -1, axis=0)
    cross = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    if cross.sum() == 0:
        return 0.0, polygon.mean(axis=0)
    centroid: Floats = polygon[0] + cross @ (a + b) / (3 * cross.sum())
    return abs(float(cross.sum())) / 2, centroid


def placed(points: Floats, pose: Any) -> Floats:
    """Return points (N, 2), given as forward and right of a pose, in the axes of that pose."""
    x, y, heading = pose
    # Right is forward rotated by +90 degrees, clockwise in the image.
    forward = np.array((np.cos(heading), np.sin(heading)))
    right = np.array((-forward[1], forward[0]))
    found: Floats = np.array((x, y)) + points[:, :1] * forward + points[:, 1:] * right
    return found


def fitted(polygon: Floats, area: float, centroid: Floats) -> Floats:
    """Return the polygon moved to the centroid and scaled to the area."""
    own_area, own_centroid = area_and_centroid(polygon)
    moved: Floats = centroid + (polygon - own_centroid) * np.sqrt(area / own_area)
    return moved


def contains(polygon: Floats, points: Floats) -> NDArray[np.bool_]:
    """Return which points (M, 2) lie inside: a ray to the right crosses an odd number of sides."""
    a, b = polygon, np.roll(polygon, -1, axis=0)
    x, y = points[:, :1], points[:, 1:]
    crosses = (a[:, 1] > y) != (b[:, 1] > y)
    rise = b[:, 1] - a[:, 1]
    slope = (b[:, 0] - a[:, 0]) / np.where(rise == 0, 1.0, rise)
    is_right = x < a[:, 0] + (y - a[:, 1]) * slope
    inside: NDArray[np.bool_] = (crosses & is_right).sum(axis=1) % 2 == 1
    return inside


def distances(polygon: Floats, points: Floats) -> Floats:
    """Return the distances (M,) of points (M, 2) from the sides of a polygon."""
    side = np.roll(polygon, -1, axis=0) - polygon
    offset = points[:, np.newaxis] - polygon
    along = np.clip((offset * side).sum(axis=2) / (side**2).sum(axis=1), 0.0, 1.0)
    nearest: Floats = np.linalg.norm(offset - along[..., np.newaxis] * side, axis=2).min(axis=1)
    return nearest


def depths(polygon: Floats, points: Floats) -> Floats:
    """Return the signed distances (M,) of points (M, 2) from the sides; positive inside."""
    distance = distances(polygon, points)
    return np.where(contains(polygon, points), distance, -distance)


def blurred(polygon: Floats, points: Floats, width: float) -> Floats:
    """Return the share (M,) of a normal distribution around each point that lies inside.

    `width` is its standard deviation. A side lies h w from a point, between the angles a and b.
    With Owen's T the triangle of both has

        (b - a) / (2 pi) - T(h, tan b) + T(h, tan a)
    """
    from scipy.special import owens_t

    side = np.roll(polygon, -1, axis=0) - polygon
    length = np.linalg.norm(side, axis=1)
    x, y = (points[:, np.newaxis] - polygon).transpose(2, 0, 1)
    along, beside = side.T / length
    away = along * y - beside * x
    start = -(along * x + beside * y)
    # On the line of a side itself nothing lies in the triangle.
    away = np.where(np.abs(away) < _THINNEST, _THINNEST, away)
    near = np.abs(away) < _FARTHEST * width  # T is 0 elsewhere
    covered = np.zeros(len(points))
    for sign, end in ((1, start + length), (-1, start)):
        slope = end / away
        part = np.arctan(slope) / (2 * np.pi)
        part[near] -= owens_t(away[near] / width, slope[near])
        covered += sign * part.sum(axis=1)
    cross = polygon[:, 0] * side[:, 1] - polygon[:, 1] * side[:, 0]
    return np.asarray(covered * np.sign(cross.sum()), np.float64)


def samples(polygon: Floats) -> Floats:
    """Return points (M, 2) along the sides, including the corners, about 1 px apart."""
    side = np.roll(polygon, -1, axis=0) - polygon
    length = np.linalg.norm(side, axis=1)
    spacing = max(1.0, float(length.sum()) / _MAXIMUM_SAMPLES)
    count = np.ceil(length / spacing).astype(int)
    i = np.repeat(np.arange(len(polygon)), count)
    fraction = (np.arange(count.sum()) - (np.cumsum(count) - count)[i]) / count[i]
    points: Floats = polygon[i] + fraction[:, np.newaxis] * side[i]
    return points


def crossing(polygon: Floats) -> tuple[int, int] | None:
    """Return indices of two sides that cross or touch, or None; side i begins at corner i."""
    a, b = polygon, np.roll(polygon, -1, axis=0)
    # [i, j] > 0 or < 0: on which side of the line through side i an end of side j lies.
    start, end = _turns(a, b, a), _turns(a, b, b)
    apart = start * end > 0
    boxes_meet = np.ones_like(apart)
    for axis in (0, 1):
        low, high = np.minimum(a, b)[:, axis], np.maximum(a, b)[:, axis]
        boxes_meet &= (low[:, np.newaxis] <= high) & (low <= high[:, np.newaxis])
    meet = ~apart & ~apart.T & boxes_meet
    i, j = np.nonzero(np.triu(meet, 2))
    is_pair = j - i < len(polygon) - 1  # the last side is adjacent to the first
    pairs = zip(i[is_pair].tolist(), j[is_pair].tolist(), strict=True)
    return next(pairs, None)


def _turns(a: Floats, b: Floats, points: Floats) -> Floats:
    """Return the cross products (b_i - a_i) x (points_j - a_i)."""
    side = b - a
    offset = points[np.newaxis] - a[:, np.newaxis]
    cross: Floats = side[:, :1] * offset[..., 1] - side[:, 1:] * offset[..., 0]
    return cross


def mask(polygon: Floats, width: int, height: int) -> NDArray[np.bool_]:
    """Return the mask (height, width) of the pixels whose centre lies in the polygon."""
    covered = np.zeros((height, width), dtype=bool)
    a, b = polygon, np.roll(polygon, -1, axis=0)
    top, bottom = np.clip((a[:, 1].min(), a[:, 1].max()), 0, height - 1).astype(int)
    for down in range(top, bottom + 1):
        crosses = (a[:, 1] > down) != (b[:, 1] > down)
        (x0, y0), (x1, y1) = a[crosses].T, b[crosses].T
        sides = np.sort(x0 + (down - y0) * (x1 - x0) / (y1 - y0))
        # Even-odd rule: inside between an odd crossing and the next one.
        covered[down] = np.searchsorted(sides, np.arange(width)) % 2 == 1
    return covered


def inner_box(polygon: Floats, width: int, height: int) -> tuple[int, int, int, int] | None:
    """Return (left, top, right, bottom) within a polygon of an image (px); None if it sticks out.

    It is 70 % as wide as a square of the same area, so that it lies inside a round marker, too.
    """
    left, top, right, bottom = square_within(*area_and_centroid(polygon))
    is_inside = mask(polygon, width, height)[max(top, 0) : bottom + 1, max(left, 0) : right + 1]
    is_good = is_inside.size and is_inside.mean() >= _MINIMUM_INSIDE
    return (left, top, right, bottom) if is_good else None
