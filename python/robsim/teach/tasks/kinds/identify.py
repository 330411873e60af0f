"""The task to identify: the robot's parameters, from measurements, while it drives."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from robsim._core import DriveAround, RobotModel
from robsim.base.checks import check_float, check_int
from robsim.estimation.identification.regressions import regression_of
from robsim.simulation import ParameterMismatch, PoseNoise, Scenario
from robsim.teach.tasks.definition import MASKED, MOST_STEPS, Task
from robsim.teach.tasks.kinds.driving import DT, rms, rms_of_poses, small_world
from robsim.teach.tasks.score import Score, scores_of
from robsim.trace import Trace
from robsim.trace.trace import check_trace

#: The part of a run after which the early estimate is scored.
_EARLY = 0.4

#: Inputs that excite all parameters of a robot that is fast compared with its noises (V, steps).
_EXCITATION = DriveAround(low=-1.0, high=3.0, hold=6)


@dataclass(frozen=True, kw_only=True)
class IdentifyTask(Task):
    """Identify the parameters of a robot recursively, from the poses that a camera measures.

    The scores measure the prediction of the next pose from the true previous poses. The prediction
    error due to the parameters is e = phi (theta - theta_true), over all samples of the run. So a
    parameter counts to the extent that the run determines it, in the unit of a pose.

    Parameters
    ----------
    noise : float
        Gaussian noise of the camera (%).
    mismatch : float
        Relative standard deviation of the true gains and frictions around the given ones.
    slip : float
        Standard deviation of the process noise of the position in a step (px).
    turn : float
        Standard deviation of the process noise of the heading in a step (rad).
    steps, runs : int
        See `Task`.

    Raises
    ------
    TypeError, ValueError
        If a parameter has the wrong type or is out of range; the message names it.
    """

    name: ClassVar[str] = "identify"
    title: ClassVar[str] = "identify the robot's parameters while it drives"
    masked: ClassVar[tuple[str, ...]] = (
        *(*MASKED, "robsim.RecursiveLeastSquares", "robsim.batch_estimate"),
        *("robsim.estimation.least_squares", "robsim.estimation.output_error"),
        "robsim.estimation.instrumental_variables",
    )
    slots: ClassVar[tuple[str, ...]] = ("init_parameter_estimator", "estimate_parameters")
    given: ClassVar[str] = "pose"
    scores: ClassVar[tuple[Score, ...]] = scores_of(
        ("position", "rms error of the predicted position, by the last parameters",
         "px", 0.4, 1e-4, 100.0),
        ("heading", "rms error of the predicted heading, by the last parameters",
         "deg", 0.3, 1e-4, 100.0),
        ("early", "rms error of the predicted position, by the parameters at 40 % of the run",
         "px", 0.3, 1e-4, 100.0),
    )  # fmt: skip

    steps: int = 150
    noise: float = 0.0
    mismatch: float = 0.3
    slip: float = 0.1
    turn: float = 0.003

    def __post_init__(self) -> None:
        super().__post_init__()
        check_int("steps", self.steps, minimum=20, maximum=MOST_STEPS)
        check_float("noise", self.noise, "%", minimum=0, maximum=25)
        check_float("mismatch", self.mismatch, exclusive_minimum=0, maximum=0.3)
        check_float("slip", self.slip, "px", minimum=0, maximum=20)
        check_float("turn", self.turn, "rad", minimum=0, maximum=0.5)

    @property
    def scenario(self) -> Scenario:
        """The world of the runs: each run has another robot, which drives around and slips."""
        return small_world(
            noise=self.noise,
            boundary="unlimited",
            headings=None,
            process_noise=PoseNoise.from_sigma(self.slip, self.slip, self.turn),
            mismatch=ParameterMismatch(self.mismatch),
            control=_EXCITATION,
            identify_from="measurement",
        )

    @property
    def values(self) -> Mapping[str, Any]:
        """The given parameters of a new robot, and their possible relative error."""
        return {
            "DT": DT,
            "THETA": tuple(map(tuple, RobotModel().theta.tolist())),
            "MISMATCH": self.mismatch,
        }

    def score(self, trace: Trace) -> dict[str, float]:
        """Return the rms prediction errors of the last parameters and of early parameters."""
        check_trace(trace, "pose_true")
        phi = regression_of(trace, identify_from="truth").phi
        error = trace.parameters - np.asarray(trace.info.theta_true, dtype=np.float64)
        # e = sum(phi (theta - theta_true))
        steps = (-1, round(_EARLY * len(trace)))
        last, early = (np.sum(phi * error[k], axis=2) for k in steps)
        return {**rms_of_poses(last), "early": rms(early[:, :2])}
