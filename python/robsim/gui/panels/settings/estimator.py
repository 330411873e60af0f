"""The panel's state estimator, tuned to the world."""

from __future__ import annotations

import math
from importlib.util import find_spec
from typing import TYPE_CHECKING

import numpy as np

from robsim.simulation import Experiment, PoseNoise, Simulation, WheelNoise

# Imported at run time where needed, since a course can leave the module out.
if TYPE_CHECKING:
    from robsim.estimation.reference.kalman import ExtendedKalmanFilter

Sigma = tuple[float, float, float]


def why_no_default() -> str | None:
    """Return why the panel has no own state estimator."""
    if find_spec("robsim.estimation.reference") is None:
        return "the module robsim.estimation.reference is not installed here"
    return None


def default_estimator(runner: Simulation | Experiment) -> ExtendedKalmanFilter:
    """Return an extended Kalman filter for a world."""
    from robsim.estimation.reference.estimator import Prior
    from robsim.estimation.reference.kalman import ExtendedKalmanFilter

    width, height = runner.area
    uniform = (width / math.sqrt(12), height / math.sqrt(12), math.pi / math.sqrt(3))
    prior = Prior(pose=(width / 2, height / 2, 0.0), pose_sigma=uniform)
    delay = runner.scenario.motor_delay if isinstance(runner, Simulation) else 0.0
    estimator = ExtendedKalmanFilter(runner.model, motor_delay=delay, prior=prior)
    tune(estimator, runner)
    if (step := runner.last_step).k > 0:
        estimator.motion.steps_in(step.dt)  # raises if its model has another dt than the frames
    return estimator


def tune(estimator: ExtendedKalmanFilter, runner: Simulation | Experiment) -> None:
    """Set a filter's process noise for a simulated world; an experiment's noise is unknown."""
    if isinstance(runner, Simulation):
        estimator.Q = np.diag(np.square(_process_sigma(runner)))


def _process_sigma(simulation: Simulation) -> Sigma:
    """Return standard deviations of the disturbance of a world in a step (px, px, rad)."""
    noise, model = simulation.process_noise, simulation.model
    if isinstance(noise, PoseNoise):
        x, y, heading = noise.sigma
        return float(x), float(y), float(heading)
    if isinstance(noise, WheelNoise):
        along, _, heading = np.sqrt(np.diag(noise.Q(model, 0.0))).tolist()
        return along, along, heading
    from robsim.estimation.reference.estimator import PROCESS_SIGMA

    # Without a disturbance 0 is correct, but a filter with 0 never recovers from a bounce.
    return PROCESS_SIGMA
