"""Score of a driven path."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from robsim._base.checks import Floats, check_float
from robsim.control._waypoints import as_waypoints, nearest_on_segment
from robsim.trace import Trace


@dataclass(frozen=True, kw_only=True)
class PathScore:
    """How well a robot followed a path: what `score_path` found.

    Attributes
    ----------
    source : str
        The path that was scored: ``"truth"``, or ``"measurement"`` where the truth is not known.
    waypoints : int
        Number of waypoints.
    reached : int
        How many of them were reached, one after the other.
    completed_step : int or None
        The step at which the last waypoint was reached; None = it was not.
    rms_error, max_error : float
        Root mean square and largest value of the cross-track error (work-area px).
    final_distance : float
        From the last waypoint at the end (work-area px).
    effort : float
        Root mean square of the voltages of both motors (V); NaN = not known.
    """

    source: str
    waypoints: int
    reached: int
    completed_step: int | None
    rms_error: float
    max_error: float
    final_distance: float
    effort: float

    def __str__(self) -> str:
        reached = f"{self.reached} of {self.waypoints} waypoints reached"
        if self.completed_step is not None:
            reached += f", the last at step {self.completed_step}"
        path = {"truth": "true", "measurement": "measured"}[self.source]
        effort = "" if math.isnan(self.effort) else f"; rms voltage {self.effort:.2f} V"
        return (
            f"path: {reached}\n"
            f"      {path} path beside the line: rms {self.rms_error:.1f} px, "
            f"at most {self.max_error:.1f} px\n"
            f"      at the end {self.final_distance:.1f} px from the last waypoint{effort}"
        )

    def to_dict(self) -> dict[str, Any]:
        """Return name -> value; None = not known."""
        return {name: None if value != value else value for name, value in asdict(self).items()}


def score_path(trace: Trace, waypoints: ArrayLike, *, reach: float = 25.0) -> PathScore:
    """Score a run against the path from its first pose through the waypoints.

    Parameters
    ----------
    trace : Trace
        The run; its true path is scored, or the measured one if it has no truth.
    waypoints : array (N, 2)
        Places (x, y) in work-area px, in the order in which they are to be reached.
    reach : float
        A waypoint is reached when the robot comes so near (work-area px).

    Returns
    -------
    PathScore
        Errors, waypoints reached, effort.

    Raises
    ------
    TypeError, ValueError
        If the waypoints or the reach are not of this kind, or if the trace has no poses.

    Notes
    -----
    The path is p(0) -> p(1) -> ... -> p(N), from the first pose through the waypoints. With j
    waypoints reached at step k, the robot is on its way along the segment p(j) -> p(j+1), and only
    that counts; at the end it is the point p(N):

        error(k) = distance of (x(k), y(k)) from the nearest point of p(j) -> p(j+1)

    The rest of the path does not count, so a short cut to a later part of it is an error. There is
    one exception, since a waypoint is reached before the robot is there: as long as the robot is
    within reach of p(j), the segment p(j-1) -> p(j) that it comes from counts, too; and so on
    backwards where waypoints lie close together.
    """
    if not isinstance(trace, Trace):
        raise TypeError(f"trace must be a Trace, got {trace!r}")
    points = as_waypoints(waypoints)
    reach = check_float("reach", reach, "px", minimum=0)
    source, poses = _known_poses(trace)
    rows = np.flatnonzero(np.isfinite(poses[:, :2]).all(axis=1))
    if not len(rows):
        raise ValueError(f"trace must have a true or a measured pose to score, got {trace!r}")
    places = poses[rows, :2]
    errors, reached_in = _along(places, points, reach)
    is_completed = len(reached_in) == len(points)
    voltages = trace.u[np.isfinite(trace.u)]
    return PathScore(
        source=source,
        waypoints=len(points),
        reached=len(reached_in),
        completed_step=int(trace.k[rows[reached_in[-1]]]) if is_completed else None,
        rms_error=float(np.sqrt(np.mean(np.square(errors)))),
        max_error=float(errors.max()),
        final_distance=float(np.hypot(*(places[-1] - points[-1]))),
        effort=float(np.sqrt(np.mean(np.square(voltages)))) if len(voltages) else math.nan,
    )


def _known_poses(trace: Trace) -> tuple[str, Floats]:
    if np.isfinite(trace.pose_true[:, :2]).any():
        return "truth", trace.pose_true
    return "measurement", trace.pose_measured


def _along(places: Floats, points: Floats, reach: float) -> tuple[Floats, list[int]]:
    """Return the error at each place, and the rows in which the waypoints were reached."""
    path = np.vstack((places[:1], points, points[-1:]))
    errors = np.empty(len(places))
    reached_in: list[int] = []
    for row, place in enumerate(places):
        while len(reached_in) < len(points) and math.dist(place, points[len(reached_in)]) <= reach:
            reached_in.append(row)
        j = len(reached_in)
        errors[row] = _distance(place, path[j : j + 2])
        while j > 0 and math.dist(place, path[j]) <= reach:
            j -= 1
            errors[row] = min(errors[row], _distance(place, path[j : j + 2]))
    return errors, reached_in


def _distance(place: Floats, segment: Floats) -> float:
    return math.dist(place, nearest_on_segment(place, segment[0], segment[1]))
