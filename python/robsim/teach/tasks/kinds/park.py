"""The task to park: a controller that brings the robot to a pose and stops it there."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from robsim.base.checks import Floats
from robsim.control import score_pose
from robsim.control.path_following import as_pose
from robsim.teach.tasks.definition import MASKED
from robsim.teach.tasks.kinds.driving import DT, MAXIMUM_VOLTAGE, DrivingTask, check_inside
from robsim.teach.tasks.score import Score, scores_of
from robsim.trace import Trace
from robsim.trace.trace import check_trace

#: Within these tolerances the robot is parked (px, rad).
_POSITION_TOLERANCE, _HEADING_TOLERANCE = 20.0, 0.15


@dataclass(frozen=True, kw_only=True)
class ParkTask(DrivingTask):
    """Drive to a pose (position and heading), and stay there.

    Parameters
    ----------
    goal : tuple of three floats
        The pose: x, y (px), heading (rad).
    noise : float
        Gaussian noise of the camera (%).
    dropout : float
        Probability that the robot is hidden, 0..1, in each of the segments of 3 steps.
    mismatch : float
        Relative standard deviation of the gains of the motors and of the friction, 0..0.3.
    steps, runs : int
        See `Task`.

    Raises
    ------
    TypeError, ValueError
        If a parameter has the wrong type or is out of range; the message names it.
    """

    name: ClassVar[str] = "park"
    title: ClassVar[str] = "park the robot at a pose"
    scores: ClassVar[tuple[Score, ...]] = scores_of(
        ("settling", "settling time at the pose", "s", 0.4, 0.2, 60.0),
        ("distance", "distance from the goal at the end", "px", 0.15, 4.0, 400.0),
        ("heading", "heading error at the end", "deg", 0.25, 2.0, 90.0),
        ("overshoot", "overshoot after arrival", "px", 0.2, 2.0, 200.0),
    )
    masked: ClassVar[tuple[str, ...]] = (*MASKED, "robsim.GoToPoint")

    steps: int = 150
    goal: Sequence[float] = (380.0, 300.0, 3.14)
    noise: float = 10.0
    dropout: float = 0.15
    mismatch: float = 0.1

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "goal", tuple(as_pose(self.goal, "goal").tolist()))
        check_inside("goal", [self.goal[:2]])

    @property
    def values(self) -> Mapping[str, Any]:
        """The pose, its tolerances, the largest voltage (V), and the sample time (s)."""
        return {
            "GOAL": self.goal,
            "POSITION_TOLERANCE": _POSITION_TOLERANCE,
            "HEADING_TOLERANCE": _HEADING_TOLERANCE,
            "MAXIMUM_VOLTAGE": MAXIMUM_VOLTAGE,
            "DT": DT,
        }

    @property
    def goals(self) -> Floats:
        """The pose, (3,)."""
        return np.array(self.goal)

    def score(self, trace: Trace) -> dict[str, float]:
        """Return settling time, errors at the end and overshoot."""
        check_trace(trace, "pose_true")
        if self.broken_rule(trace) is not None:
            return dict.fromkeys((score.name for score in self.scores), np.nan)
        score = score_pose(
            trace,
            self.goal,
            position_tolerance=_POSITION_TOLERANCE,
            heading_tolerance=_HEADING_TOLERANCE,
        )
        return {
            "settling": np.nan if score.settling_time is None else score.settling_time,
            "distance": score.final_distance,
            "heading": abs(float(np.rad2deg(score.final_heading_error))),
            "overshoot": np.nan if score.overshoot is None else score.overshoot,
        }
