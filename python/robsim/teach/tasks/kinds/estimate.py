"""The task to estimate: the robot's pose through noise and dropouts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from robsim._core import DriveAround, RobotModel
from robsim.base.checks import Floats, check_float, check_int
from robsim.estimation.evaluation.consistency import nees
from robsim.estimation.evaluation.errors import wrapped_error
from robsim.simulation import PoseNoise, Scenario
from robsim.simulation.world.scene import HEADINGS
from robsim.teach.tasks.definition import MOST_STEPS, Task
from robsim.teach.tasks.kinds.driving import AREA, DT, RESOLUTION, rms_of_poses, small_world
from robsim.teach.tasks.score import Score, scores_of
from robsim.trace import Trace
from robsim.trace.trace import check_trace

#: The error of a measured pose due to camera noise of 1 % (px, px, rad), found by simulation.
_BY_NOISE = (0.0155, 0.0155, 0.00065)

#: Steps for which an input is held; longer ones would hide a late input.
_HOLD = 4


@dataclass(frozen=True, kw_only=True)
class EstimateTask(Task):
    """Estimate the pose of a slipping robot from noisy and sometimes missing measurements.

    Parameters
    ----------
    noise : float
        Gaussian noise of the camera (%).
    dropout : float
        Probability that the robot is hidden, 0..1, in each of the segments of 3 steps.
    slip : float
        Standard deviation of the process noise of the position in a step (px).
    turn : float
        Standard deviation of the process noise of the heading in a step (rad).
    steps, runs : int
        See `Task`; the first 10 steps are not scored.

    Raises
    ------
    TypeError, ValueError
        If a parameter has the wrong type or is out of range; the message names it.
    """

    name: ClassVar[str] = "estimate"
    title: ClassVar[str] = "estimate the robot's pose through noise and dropouts"
    slots: ClassVar[tuple[str, ...]] = ("estimate_state",)
    given: ClassVar[str] = "pose"
    unscored: ClassVar[int] = 10  # in which the robot is seen for the first time
    scores: ClassVar[tuple[Score, ...]] = scores_of(
        ("position", "rms error of the position", "px", 0.35, 0.01, 1000.0),
        ("heading", "rms error of the heading", "deg", 0.35, 0.01, 180.0),
        ("consistency", "mean NEES of the pose / 3", "", 0.3, 1e-3, 1e3, "consistency"),
    )

    noise: float = 0.0
    dropout: float = 0.2
    slip: float = 0.3
    turn: float = 0.01

    def __post_init__(self) -> None:
        super().__post_init__()
        check_int("steps", self.steps, minimum=2 * self.unscored, maximum=MOST_STEPS)
        check_float("noise", self.noise, "%", minimum=0, maximum=25)
        check_float("dropout", self.dropout, minimum=0, maximum=0.9)
        check_float("slip", self.slip, "px", minimum=0, maximum=20)
        check_float("turn", self.turn, "rad", minimum=0, maximum=0.5)

    @property
    def scenario(self) -> Scenario:
        """The world of the runs: a robot that drives around and slips."""
        return small_world(
            noise=self.noise,
            boundary="unlimited",
            dropout=self.dropout,
            process_noise=PoseNoise.from_sigma(self.slip, self.slip, self.turn),
            control=DriveAround(hold=_HOLD),
        )

    @property
    def values(self) -> Mapping[str, Any]:
        """The model, and the standard deviations of measurement and process noise (px, px, rad)."""
        return {
            "DT": DT,
            "AREA": AREA,
            "THETA": tuple(map(tuple, RobotModel().theta.tolist())),
            "MEASUREMENT_SIGMA": tuple(_measured(self.noise).round(4).tolist()),
            "PROCESS_SIGMA": (self.slip, self.slip, self.turn),
        }

    def score(self, trace: Trace) -> dict[str, float]:
        """Return the rms errors of position and heading, and the mean NEES divided by 3."""
        check_trace(trace, "pose_true")
        error = wrapped_error(trace.pose_estimated, trace.pose_true)[self.unscored :]
        return {
            **rms_of_poses(error),
            "consistency": _mean_nees(error, trace.covariance[self.unscored :]) / 3,
        }


def _measured(noise: float) -> Floats:
    """Return the standard deviations of a measured pose (px, px, rad).

    The robot is drawn at whole pixels of the frame, in the nearest of some headings. These errors
    are uniform, of variance (step size)^2 / 12, and white, because the robot moves.
    """
    step_size = np.array([AREA[0] / RESOLUTION[0], AREA[1] / RESOLUTION[1], 2 * np.pi / HEADINGS])
    sigma: Floats = np.sqrt(step_size**2 / 12 + np.square(_BY_NOISE) * noise**2)
    return sigma


def _mean_nees(error: Floats, covariance: Floats) -> float:
    try:
        return float(np.mean(nees(error, covariance)))
    except ValueError:  # the returned matrix is no covariance
        return float("nan")
