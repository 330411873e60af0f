"""Checked waypoints and the segments between them, for `FollowPath` and `score_path`."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from robsim.base.checks import Floats, as_float_array
from robsim.base.text import quoted

MAXIMUM_COORDINATE = 1e6  # px


def dot(a: Floats, b: Floats) -> float:
    """Return a . b for vectors (2,): numpy's product differs in the last bit between processors."""
    return float(a[0] * b[0] + a[1] * b[1])


def nearest_on_segment(position: Floats, start: Floats, end: Floats) -> Floats:
    """Return the point (2,) of the segment start -> end that is nearest to a position (2,)."""
    along = end - start
    square = dot(along, along)
    # fraction = (position - start) . (end - start) / |end - start|^2, within 0..1
    fraction = dot(position - start, along) / square if square else 0.0
    return np.asarray(start + min(max(fraction, 0.0), 1.0) * along)


def as_waypoints(waypoints: ArrayLike) -> Floats:
    """Return waypoints as a read-only copy, an array (N, 2)."""
    expected = "waypoints must be an array (N, 2) of positions x, y in px, N at least 1"
    try:
        points = np.array(waypoints)
    except ValueError:
        raise ValueError(f"{expected}, got {quoted(waypoints)}") from None
    if points.dtype.kind not in "iuf":
        raise TypeError(f"{expected}, got {quoted(waypoints)}")
    if points.ndim != 2 or points.shape[1] != 2 or not len(points):
        hint = ": for a single one write [(x, y)]" if points.shape == (2,) else ""
        raise ValueError(f"{expected}, got shape {points.shape}{hint}")
    if not (np.abs(points) <= MAXIMUM_COORDINATE).all():  # NaN fails, too
        raise ValueError(
            f"waypoints must be finite, within {MAXIMUM_COORDINATE:g} px, got {quoted(waypoints)}"
        )
    points = points.astype(np.float64)
    points.setflags(write=False)
    return points


def as_pose(pose: ArrayLike, name: str = "pose") -> Floats:
    """Return a pose x, y (px), heading (rad) as an array (3,)."""
    expected = f"{name} must be an array (3,): x, y in px, heading in rad"
    try:
        values = np.array(pose)
    except ValueError:
        raise ValueError(f"{expected}, got {quoted(pose)}") from None
    if values.dtype.kind not in "iuf":
        raise TypeError(f"{expected}, got {quoted(pose)}")
    if values.shape != (3,):
        raise ValueError(f"{expected}, got shape {values.shape}")
    if not (np.abs(values) <= MAXIMUM_COORDINATE).all():  # NaN fails, too
        raise ValueError(
            f"{name} must be finite, within {MAXIMUM_COORDINATE:g} px, got {quoted(pose)}"
        )
    return values.astype(np.float64)


def as_goals(goals: ArrayLike) -> Floats:
    """Return where a robot is to go: a position (2,), a pose (3,) or waypoints (N, 2)."""
    expected = "goals must be a position (2,), a pose (3,) or waypoints (N, 2), finite, in px"
    points = as_float_array("goals", goals)
    is_one, is_path = points.shape in ((2,), (3,)), points.ndim == 2 and points.shape[1] == 2
    if not (is_one or is_path) or not len(points) or not np.isfinite(points).all():
        raise ValueError(f"{expected}, got {quoted(goals)}")
    return points
