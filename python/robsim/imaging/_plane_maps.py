"""A plane map from four points."""

from __future__ import annotations

from itertools import combinations

import numpy as np
from numpy.typing import ArrayLike

from robsim._base.checks import Floats
from robsim._core import PlaneMap

FLATTEST_TRIANGLE = 1e-3  # its area as a share of the largest one of the four points


def plane_map_from_points(pixels: ArrayLike, places: ArrayLike) -> PlaneMap:
    """Return the plane map of a camera that looks at the work area from any direction.

    Parameters
    ----------
    pixels : array_like (4, 2)
        Pixels (u, v) of four points on the floor, no three of them on a line.
    places : array_like (4, 2)
        Where these points lie on the work area, in the same order: (x, y) in work-area px.

    Returns
    -------
    PlaneMap
        The only homography that takes each pixel to its place.

    Raises
    ------
    ValueError
        If the shapes are others, three points lie on a line, or the places go round in another
        order than the pixels.

    Examples
    --------
    >>> seen = [(102, 80), (541, 77), (630, 455), (12, 460)]
    >>> corners = [(0, 0), (1199, 0), (1199, 1199), (0, 1199)]
    >>> plane_map = robsim.plane_map_from_points(seen, corners)
    """
    seen, real = _four_points("pixels", pixels), _four_points("places", places)
    if np.any(_turns("pixels", seen) != _turns("places", real)):
        raise ValueError(
            "pixels and places must have the four points in the same order: the first pixel "
            "belongs to the first place; these go round in another order"
        )
    return PlaneMap(_from_corners(real) @ np.linalg.inv(_from_corners(seen)))


def _four_points(name: str, points: ArrayLike) -> Floats:
    try:
        array = np.asarray(points, dtype=np.float64)
    except (TypeError, ValueError):
        raise ValueError(f"{name} must be four points, numbers (4, 2), got {points!r}") from None
    if array.shape != (4, 2) or not np.isfinite(array).all():
        raise ValueError(f"{name} must be four points, finite numbers (4, 2), got {points!r}")
    return array


def _turns(name: str, points: Floats) -> Floats:
    """Return for each three of the points whether they turn right, +1, or left, -1."""
    three = np.array(list(combinations(points, 3)))
    areas = np.linalg.det(np.dstack((three, np.ones((4, 3)))))
    if np.abs(areas).min() <= FLATTEST_TRIANGLE * np.abs(areas).max():
        raise ValueError(f"{name} must not have three points on a line, got {points.tolist()}")
    signs: Floats = np.sign(areas)
    return signs


def _from_corners(points: Floats) -> Floats:
    """Return the homography that takes (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 1) to the points.

    Its columns are the first three points, each times the number that makes their sum the fourth.
    """
    columns = np.vstack((points.T, np.ones(4)))
    return columns[:, :3] * np.linalg.solve(columns[:, :3], columns[:, 3])
