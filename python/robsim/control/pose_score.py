"""How a robot comes to a pose and stays there, for users who compare parking controllers."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from robsim._core import wrap_angle
from robsim.base.checks import check_float
from robsim.base.report import Quantity, Report
from robsim.control.path_score import known_poses, rms_voltage
from robsim.control.waypoints import as_pose
from robsim.trace import Trace
from robsim.trace.columns import POSES
from robsim.trace.trace import check_trace
from robsim.trace.units import length_format


@dataclass(frozen=True, kw_only=True)
class PoseScore(Report):
    """How well a robot parked: the result of `score_pose`.

    Attributes
    ----------
    source : str
        The path that was scored: ``"truth"``, or ``"measurement"`` where the truth is not known.
    final_distance : float
        Distance from the position at the end of the run (in `unit`).
    final_heading_error : float
        Heading minus the wanted one at the end, within -pi..pi (rad).
    settled_step : int or None
        The first step from which on the robot stays within both tolerances; None = at the end it
        is not within them.
    settling_time : float or None
        How long that took (s).
    overshoot : float or None
        How far beyond the position tolerance it was again after it had once been within (in
        `unit`); None = it never was.
    effort : float
        Root mean square of the voltages of both motors (V); NaN = not known.
    unit : str
        The unit of lengths: that of the trace.
    """

    source: str
    final_distance: float
    final_heading_error: float
    settled_step: int | None
    settling_time: float | None
    overshoot: float | None
    effort: float
    unit: str = "px"

    @property
    def title(self) -> str:
        """What was scored."""
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
            Quantity("overshoot", "overshoot", self.overshoot, unit, length),
            Quantity("effort", "rms voltage", self.effort, "V", ".2f"),
            Quantity("source", "poses from", self.source),
        )


def score_pose(
    trace: Trace,
    pose: ArrayLike,
    *,
    position_tolerance: float = 25.0,
    heading_tolerance: float = 0.2,
) -> PoseScore:
    """Score how a run came to a pose and stayed there.

    Parameters
    ----------
    trace : Trace
        The run; its true poses are scored, or the measured ones if it has no truth.
    pose : array (3,)
        The wanted x, y (work-area px) and heading (rad).
    position_tolerance : float
        Distance up to which the robot is at the position (work-area px).
    heading_tolerance : float
        Heading error up to which it has the heading (rad).

    Returns
    -------
    PoseScore
        Errors at the end, settling step and time, overshoot, effort.

    Raises
    ------
    NotRecordedError
        If the trace has neither true nor measured poses.
    TypeError, ValueError
        If an argument has the wrong type or shape, or is out of range.

    Notes
    -----
    Steps without a pose do not count: neither as left nor as settled. The overshoot is the largest
    distance after the first step within the position tolerance, less that tolerance, or 0.
    """
    check_trace(trace)
    px = trace.info.px_length
    wanted = as_pose(pose) * (px, px, 1)
    near = check_float("position_tolerance", position_tolerance, "px", minimum=0) * px
    turned = check_float("heading_tolerance", heading_tolerance, "rad", minimum=0)
    source, poses = known_poses(trace)
    rows = np.flatnonzero(np.isfinite(poses).all(axis=1))
    if not len(rows):
        trace.require(POSES[source])
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
        overshoot=None if after is None else max(0.0, float(after.max()) - near),
        effort=rms_voltage(trace),
        unit=trace.info.unit,
    )
