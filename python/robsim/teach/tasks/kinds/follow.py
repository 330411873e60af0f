"""The task to follow a path: a controller that brings the robot along waypoints."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from robsim.base.checks import Floats
from robsim.control import score_path
from robsim.control.path_following import as_waypoints
from robsim.teach.tasks.definition import MASKED
from robsim.teach.tasks.kinds.driving import DT, MAXIMUM_VOLTAGE, DrivingTask, check_inside
from robsim.teach.tasks.score import Score, scores_of
from robsim.trace import Trace
from robsim.trace.trace import check_trace

#: Within this distance a waypoint is reached (px).
_RADIUS = 25.0


@dataclass(frozen=True, kw_only=True)
class FollowTask(DrivingTask):
    """Drive along a path, from waypoint to waypoint.

    Parameters
    ----------
    waypoints : sequence of (x, y)
        The waypoints in their order (px).
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

    name: ClassVar[str] = "follow"
    title: ClassVar[str] = "follow a path with the robot"
    scores: ClassVar[tuple[Score, ...]] = (
        *scores_of(
            ("error", "distance from the path, rms", "px", 0.4, 1.0, 200.0),
            ("time", "time until the last waypoint", "s", 0.4, 0.2, 120.0),
        ),
        Score(
            name="left",
            title="missed waypoints",
            unit="%",
            share=0.2,
            floor=5.0,
            worst=100.0,
        ),
    )
    masked: ClassVar[tuple[str, ...]] = (*MASKED, "robsim.FollowPath", "robsim.GoToPoint")

    steps: int = 320
    waypoints: Sequence[Sequence[float]] = ((430.0, 220.0), (210.0, 220.0), (210.0, 400.0))
    noise: float = 10.0
    dropout: float = 0.15
    mismatch: float = 0.1

    def __post_init__(self) -> None:
        super().__post_init__()
        points = tuple(map(tuple, as_waypoints(self.waypoints).tolist()))
        object.__setattr__(self, "waypoints", points)
        check_inside("waypoints", points)

    @property
    def values(self) -> Mapping[str, Any]:
        """The waypoints, the distance at which they count as reached, and the voltage limit (V)."""
        return {
            "WAYPOINTS": self.waypoints,
            "WAYPOINT_RADIUS": _RADIUS,
            "MAXIMUM_VOLTAGE": MAXIMUM_VOLTAGE,
            "DT": DT,
        }

    @property
    def goals(self) -> Floats:
        """The waypoints, (N, 2)."""
        return np.array(self.waypoints)

    def score(self, trace: Trace) -> dict[str, float]:
        """Return error, time and missed waypoints; an incomplete path has no error and no time.

        Without this rule, a robot that does not move would have an error of 0.
        """
        check_trace(trace, "pose_true")
        if self.broken_rule(trace) is not None:
            return dict.fromkeys((score.name for score in self.scores), np.nan)
        score = score_path(trace, self.waypoints, waypoint_radius=_RADIUS)
        last = score.completed_step
        return {
            "error": np.nan if last is None else score.rmse,
            "time": np.nan if last is None else last * DT,
            "left": 100 * (1 - score.reached / score.waypoints),
        }
