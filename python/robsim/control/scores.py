"""Scores of driven paths and of parking, for users who compare controllers."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from robsim._core import wrap_angle
from robsim.base.checks import Floats, check_float
from robsim.base.report import Quantity, Report
from robsim.control.path_following import as_pose, as_waypoints, nearest_on_segment
from robsim.trace import Trace
from robsim.trace.trace import check_trace
from robsim.trace.units import length_format

_FEW_STEPS = 5  # that a robot may be within tolerances while it drives through them


@dataclass(frozen=True, kw_only=True)
class PathScore(Report):
    """A robot's accuracy along a path: the result of `score_path`.

    Attributes
    ----------
    source : str
        The scored path: ``"truth"``, or ``"measurement"`` if the truth is not known.
    waypoints : int
        Number of waypoints.
    reached : int
        Number of reached waypoints, in their order.
    completed_step : int or None
        The step at which the last waypoint was reached; None = never.
    rmse, max_error : float
        Root mean square and maximum of the cross-track error (in `unit`).
    final_distance : float
        Distance from the last waypoint at the end of the run (in `unit`).
    effort : float
        Root mean square of the voltages of both motors (V); NaN = not known.
    unit : str
        The unit of lengths, as in the trace.

    Examples
    --------
    >>> path = [(700, 600), (700, 700)]
    >>> sim = robsim.Simulation(control=robsim.FollowPath(path), measure=True, seed=1)
    >>> score = robsim.score_path(sim.run(150), path)
    >>> score.reached, score.waypoints
    (2, 2)
    """

    source: str
    waypoints: int
    reached: int
    completed_step: int | None
    rmse: float
    max_error: float
    final_distance: float
    effort: float
    unit: str = "px"

    @property
    def title(self) -> str:
        """The subject of the report: the path."""
        return "Path through the waypoints"

    @property
    def verdict(self) -> str:
        """Return ``"completed"`` or ``"incomplete"``."""
        return "incomplete" if self.completed_step is None else "completed"

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """Waypoints, cross-track error and effort."""
        unit, length = self.unit, length_format(self.unit, 1)
        final = "distance from the last one at the end"
        return (
            Quantity("waypoints", "waypoints", self.waypoints),
            Quantity("reached", "reached", self.reached),
            Quantity("completed_step", "reached the last one at step", self.completed_step),
            Quantity("rmse", "cross-track error, rmse", self.rmse, unit, length),
            Quantity("max_error", "cross-track error, maximum", self.max_error, unit, length),
            Quantity("final_distance", final, self.final_distance, unit, length),
            Quantity("effort", "rms voltage", self.effort, "V", ".2f"),
            Quantity("source", "poses from", self.source),
        )

    @property
    def remarks(self) -> tuple[str, ...]:
        """The part of the path to which the errors refer."""
        if self.completed_step is not None:
            return ()
        return ("the cross-track errors are of the driven path: a robot at rest has errors of 0",)


def score_path(trace: Trace, waypoints: ArrayLike, *, waypoint_radius: float = 25.0) -> PathScore:
    """Score a run against the path from its first pose through the waypoints.

    Parameters
    ----------
    trace : Trace
        The run; its true path is scored, or the measured one without the truth.
    waypoints : array (N, 2)
        Positions (x, y) in work-area px, as for the controller, in the order of travel.
    waypoint_radius : float
        Distance at which a waypoint counts as reached (work-area px).

    Returns
    -------
    PathScore
        Cross-track error, reached waypoints, effort.

    Raises
    ------
    NotRecordedError
        If the trace has neither true nor measured poses.
    TypeError, ValueError
        If an argument has the wrong type or shape.

    Notes
    -----
    The path is p(0) -> p(1) -> ... -> p(N), from the first pose through the waypoints. With j
    waypoints reached at step k, only the segment p(j) -> p(j+1) counts; after the last waypoint it
    is the point p(N)::

        error(k) = distance of (x(k), y(k)) from the nearest point of p(j) -> p(j+1)

    The other segments do not count, so a short cut to a later segment is an error. There is one
    exception, since a waypoint counts as reached before the robot arrives. While the robot is
    within `waypoint_radius` of p(j), the segment p(j-1) -> p(j) counts, too; and so on backwards if
    waypoints lie close together.

    Examples
    --------
    >>> line = [(400, 600), (800, 600)]
    >>> sim = robsim.Simulation(measure=True, control=robsim.FollowPath(line), seed=1)
    >>> score = robsim.score_path(sim.run(200), line)
    >>> score.reached, score.completed_step
    (2, 140)
    """
    check_trace(trace)
    px = trace.info.px_length
    points = as_waypoints(waypoints) * px
    radius = check_float("waypoint_radius", waypoint_radius, "px", minimum=0) * px
    source, poses = known_poses(trace)
    rows = np.flatnonzero(np.isfinite(poses[:, :2]).all(axis=1))
    positions = poses[rows, :2]
    errors, reached_rows = _cross_track_errors(positions, points, radius)
    is_completed = len(reached_rows) == len(points)
    return PathScore(
        source=source,
        waypoints=len(points),
        reached=len(reached_rows),
        completed_step=int(trace.k[rows[reached_rows[-1]]]) if is_completed else None,
        rmse=float(np.sqrt(np.mean(np.square(errors)))),
        max_error=float(errors.max()),
        final_distance=float(np.hypot(*(positions[-1] - points[-1]))),
        effort=rms_voltage(trace),
        unit=trace.info.unit,
    )


def rms_voltage(trace: Trace) -> float:
    """Return the root mean square of the voltages of both motors (V); NaN = not known."""
    voltages = trace.u[np.isfinite(trace.u)]
    return float(np.sqrt(np.mean(np.square(voltages)))) if len(voltages) else math.nan


def known_poses(trace: Trace) -> tuple[str, Floats]:
    """Return the source of the poses, and the poses: the true ones if available."""
    if np.isfinite(trace.pose_true[:, :2]).any():
        return "truth", trace.pose_true
    if not np.isfinite(trace.pose_measured[:, :2]).any():
        trace.require("pose_measured")
    return "measurement", trace.pose_measured


def _cross_track_errors(
    positions: Floats, points: Floats, radius: float
) -> tuple[Floats, list[int]]:
    """Return the error at each position, and the rows at which the waypoints were reached."""
    path = np.vstack((positions[:1], points, points[-1:]))
    errors = np.empty(len(positions))
    reached_rows: list[int] = []
    for row, position in enumerate(positions):
        j = len(reached_rows)
        while j < len(points) and math.dist(position, points[j]) <= radius:
            reached_rows.append(row)
            j += 1
        errors[row] = _distance(position, path[j : j + 2])
        while j > 0 and math.dist(position, path[j]) <= radius:
            j -= 1
            errors[row] = min(errors[row], _distance(position, path[j : j + 2]))
    return errors, reached_rows


def _distance(position: Floats, segment: Floats) -> float:
    return math.dist(position, nearest_on_segment(position, segment[0], segment[1]))


@dataclass(frozen=True, kw_only=True)
class PoseScore(Report):
    """A robot's accuracy in parking: the result of `score_pose`.

    Attributes
    ----------
    source : str
        The scored path: ``"truth"``, or ``"measurement"`` if the truth is not known.
    final_distance : float
        Distance from the position at the end of the run (in `unit`).
    final_heading_error : float
        Heading minus the wanted one at the end, within -pi..pi (rad).
    settled_step : int or None
        The first step from which on the robot stays within both tolerances; None = at the end it is
        outside of them.
    settling_time : float or None
        Time until this step (s).
    held : int
        Number of steps with a pose from this step on.
    overshoot : float or None
        Largest distance beyond the position tolerance after the robot was first within it (in
        `unit`); None = it never was within.
    effort : float
        Root mean square of the voltages of both motors (V); NaN = not known.
    unit : str
        The unit of lengths, as in the trace.

    Examples
    --------
    >>> sim = robsim.Simulation(control=robsim.GoToPoint(700, 500), measure=True, seed=1)
    >>> score = robsim.control.score_pose(sim.run(150), (700, 500, 0))
    >>> round(score.final_distance, 1)
    2.5
    """

    source: str
    final_distance: float
    final_heading_error: float
    settled_step: int | None
    settling_time: float | None
    held: int
    overshoot: float | None
    effort: float
    unit: str = "px"

    @property
    def title(self) -> str:
        """The subject of the report: the parking."""
        return "Parking at a pose"

    @property
    def verdict(self) -> str:
        """Return ``"settled"`` or ``"not settled"``."""
        return "not settled" if self.settled_step is None else "settled"

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """Errors at the end, settling and effort."""
        unit, length = self.unit, length_format(self.unit, 1)
        heading = "heading error at the end"
        return (
            Quantity("final_distance", "distance at the end", self.final_distance, unit, length),
            Quantity("final_heading_error", heading, self.final_heading_error, "rad", ".3f"),
            Quantity("settled_step", "settled from step", self.settled_step),
            Quantity("settling_time", "settled after", self.settling_time, "s", ".1f"),
            Quantity("held", "steps since then", self.held),
            Quantity("overshoot", "overshoot", self.overshoot, unit, length),
            Quantity("effort", "rms voltage", self.effort, "V", ".2f"),
            Quantity("source", "poses from", self.source),
        )

    @property
    def remarks(self) -> tuple[str, ...]:
        """The warning if only a few steps decide the verdict."""
        if not 0 < self.held < _FEW_STEPS:
            return ()
        return (f"settled by the last {self.held} of the poses: the robot may only drive through",)


def score_pose(
    trace: Trace,
    pose: ArrayLike,
    *,
    position_tolerance: float = 25.0,
    heading_tolerance: float = 0.2,
) -> PoseScore:
    """Score how well a run reaches a pose and stays there.

    Parameters
    ----------
    trace : Trace
        The run; its true poses are scored, or the measured ones without the truth.
    pose : array (3,)
        The wanted x, y (work-area px) and heading (rad).
    position_tolerance : float
        Largest distance at which the robot counts as at the position (work-area px).
    heading_tolerance : float
        Largest heading error at which the robot counts as aligned (rad).

    Returns
    -------
    PoseScore
        Errors at the end, settling step and time, overshoot, and effort.

    Raises
    ------
    NotRecordedError
        If the trace has neither true nor measured poses.
    TypeError, ValueError
        If an argument has the wrong type or shape, or is out of range.

    Notes
    -----
    A step without a pose means neither that the robot has left the pose nor that it has settled.
    The overshoot is the largest distance after the first step within the position tolerance, less
    that tolerance, or 0.

    Examples
    --------
    The robot stops at the position, but with another heading:

    >>> sim = robsim.Simulation(measure=True, control=robsim.GoToPoint(600, 300), seed=1)
    >>> score = robsim.control.score_pose(sim.run(200), (600, 300, 0))
    >>> round(score.final_distance), round(score.final_heading_error, 2), score.settled_step
    (2, -2.12, None)
    """
    check_trace(trace)
    px = trace.info.px_length
    wanted = as_pose(pose) * (px, px, 1)
    near = check_float("position_tolerance", position_tolerance, "px", minimum=0) * px
    turned = check_float("heading_tolerance", heading_tolerance, "rad", minimum=0, maximum=math.pi)
    source, poses = known_poses(trace)
    rows = np.flatnonzero(np.isfinite(poses).all(axis=1))
    errors = poses[rows] - wanted
    distances = np.array([math.hypot(x, y) for x, y in errors[:, :2].tolist()])
    headings = np.asarray(wrap_angle(errors[:, 2]))
    is_away = (distances > near) | (np.abs(headings) > turned)
    first = int(np.flatnonzero(is_away)[-1]) + 1 if is_away.any() else 0
    settled = rows[first] if first < len(rows) else None
    after = distances[np.argmax(distances <= near) :] if (distances <= near).any() else None
    return PoseScore(
        source=source,
        final_distance=float(distances[-1]),
        final_heading_error=float(headings[-1]),
        settled_step=None if settled is None else int(trace.k[settled]),
        settling_time=None if settled is None else float(trace.t[settled] - trace.t[0]),
        held=len(rows) - first,
        overshoot=None if after is None else max(0.0, float(after.max()) - near),
        effort=rms_voltage(trace),
        unit=trace.info.unit,
    )
