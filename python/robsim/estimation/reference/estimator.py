"""The base class of all reference filters, their noise, motion model and prior."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from robsim._core import Estimate, RobotModel, Step
from robsim.base.checks import Floats, as_float_array, check_float, check_kind
from robsim.base.text import quoted

#: Of a pose measured from frames of 1200 px with 36 drawn headings: px, px, rad. Measured: 0.28,
#: 0.28, 0.050.
MEASUREMENT_SIGMA = (0.3, 0.3, 0.05)
#: Of the process noise of the pose in each step: px, px, rad. With it the filters are consistent
#: in a world with ``process_noise=PoseNoise.from_sigma(0.1, 0.1, 0.005)``, and conservative in one
#: without disturbances, where 0 is right.
PROCESS_SIGMA = (0.1, 0.1, 0.005)


def check_vector3(
    name: str,
    values: Sequence[float],
    *,
    minimum: float = -math.inf,
    exclusive_minimum: float = -math.inf,
) -> Floats:
    """Return checked numbers for x, y and the heading, an array (3,)."""
    try:
        entries = [*values]
    except TypeError:
        entries = []
    if len(entries) != 3:
        raise ValueError(
            f"{name} must be 3 numbers, for x, y and the heading, got {quoted(values)}"
        )
    return np.array(
        [
            check_float(name, entry, minimum=minimum, exclusive_minimum=exclusive_minimum)
            for entry in entries
        ]
    )


def check_process_sigma(sigma: Sequence[float]) -> Floats:
    """Return the checked option ``process_sigma``, an array (3,)."""
    if isinstance(sigma, (tuple, list)) and len(sigma) == 2:
        raise ValueError(
            "process_sigma must be 3 numbers, for x, y and the heading, "
            f"got {quoted(sigma)}. The two values of a WheelNoise are voltages; "
            "noise.Q(model, heading) returns the covariance of the resulting pose"
        )
    return check_vector3("process_sigma", sigma, minimum=0)


def covariance(
    name: str,
    sigma: Sequence[float],
    *,
    minimum: float = -math.inf,
    exclusive_minimum: float = -math.inf,
) -> Floats:
    """Return the covariance (3, 3) of independent noises of these standard deviations."""
    return np.diag(
        check_vector3(name, sigma, minimum=minimum, exclusive_minimum=exclusive_minimum) ** 2
    )


def root(P: Floats) -> Floats:
    """Return L with L L' = P, the same on every processor.

    Eigenvectors differ between kernels: for equal eigenvalues any basis is valid.
    """
    try:
        return np.asarray(np.linalg.cholesky(P), dtype=np.float64)
    except np.linalg.LinAlgError:  # P is singular but for rounding, as without process noise
        # P^(1/2) = V sqrt(D) V' is unique, for any V
        eigenvalues, V = np.linalg.eigh(P)
        return np.asarray((V * np.sqrt(np.maximum(eigenvalues, 0))) @ V.T, dtype=np.float64)


@dataclass(frozen=True, kw_only=True)
class Prior:
    """The prior distribution of the robot's state, ahead of the first measurement.

    Default: somewhere in the work area, with any heading and a low speed.

    Parameters
    ----------
    pose : sequence of 3 floats
        Mean of the pose: x, y (px), heading (rad).
    pose_sigma : sequence of 3 floats
        Standard deviations of the pose (px, px, rad).
    velocity_sigma : sequence of 3 floats
        Standard deviations of the velocity, whose mean is 0 (px/s, px/s, rad/s).

    Raises
    ------
    TypeError, ValueError
        If a value is not a finite number, or a standard deviation is not above 0.

    Examples
    --------
    >>> robsim.estimation.reference.Prior(pose_sigma=(50, 50, 0.5)).P.diagonal()
    array([2.50e+03, 2.50e+03, 2.50e-01, 2.25e+02, 2.25e+02, 9.00e-02])
    """

    pose: Sequence[float] = (600.0, 600.0, 0.0)
    pose_sigma: Sequence[float] = (600.0, 600.0, 1.8)
    velocity_sigma: Sequence[float] = (15.0, 15.0, 0.3)

    def __post_init__(self) -> None:
        check_vector3("pose", self.pose)
        check_vector3("pose_sigma", self.pose_sigma, exclusive_minimum=0)
        check_vector3("velocity_sigma", self.velocity_sigma, exclusive_minimum=0)

    @property
    def mean(self) -> Floats:
        """Mean of the state, (6,): the pose and its velocity."""
        return np.array([*self.pose, 0.0, 0.0, 0.0], dtype=np.float64)

    @property
    def P(self) -> Floats:
        """Covariance of the state, (6, 6)."""
        return np.diag(np.square([*self.pose_sigma, *self.velocity_sigma]))


class StateEstimator(ABC):
    """A filter for the simulation: ``estimate_state(step) -> Estimate``.

    The state, `mean` (6,) with covariance `P` (6, 6), is the pose (x, y, wrapped heading) and its
    velocity (px, rad, s). A filter resets at step 0, and at a later step that does not follow the
    last one. It serves one run: the same step twice raises RuntimeError, because two simulations
    share a filter.
    """

    mean: Floats
    P: Floats

    def __init__(self, measurement_sigma: Sequence[float] | None, prior: Prior | None) -> None:
        known = MEASUREMENT_SIGMA if measurement_sigma is None else measurement_sigma
        self._R = self._usual_R = covariance("measurement_sigma", known, exclusive_minimum=0)
        self._has_own_R = measurement_sigma is not None
        self.prior: Prior = check_kind("prior", Prior() if prior is None else prior, Prior)
        self.reset()

    def __repr__(self) -> str:
        x, y, heading = self.mean[:3]
        sd_x, sd_y, sd_heading = np.sqrt(np.diag(self.P)[:3])
        return (
            f"<{type(self).__name__}: ({x:.1f}, {y:.1f}) px, {np.rad2deg(heading):.1f} deg, "
            f"standard deviations {sd_x:.3g}, {sd_y:.3g} px, {np.rad2deg(sd_heading):.3g} deg>"
        )

    @property
    def R(self) -> Floats:
        """Covariance (3, 3) of the measurement: of the newest one, or from `measurement_sigma`.

        After an assignment, the value holds for all measurements.
        """
        return self._R

    @R.setter
    def R(self, value: Floats) -> None:
        matrix = as_float_array("R", value)
        if matrix.shape != (3, 3) or not np.isfinite(matrix).all():
            raise ValueError(f"R must be 3 x 3 finite numbers, got {quoted(value)}")
        self._R, self._has_own_R = matrix, True

    def reset(self) -> None:
        """Return to the prior."""
        self.mean, self.P = self.prior.mean, self.prior.P
        if not self._has_own_R:
            self._R = self._usual_R
        self._has_seen = False
        self._last_step = -1

    def __call__(self, step: Step) -> Estimate:
        """Return the pose of a step, its covariance, and the velocity as further state."""
        if step.k == self._last_step > 0:
            raise RuntimeError(
                f"step {step.k} came twice: create a filter for each simulation, or call reset()"
            )
        if step.k == 0 or step.k != self._last_step + 1:
            self.reset()
        u = self._input_since(step)
        # No prediction before the robot is seen: with an unknown heading an input says nothing.
        if self._has_seen:
            self.predict(u, step.dt)
        if step.measurement is not None:
            if not self._has_own_R:
                reported = step.measurement.covariance
                self._R = self._usual_R if reported is None else reported
            self.update(step.measurement.pose)
            self._has_seen = True
        self._last_step = step.k
        return self._estimate()

    def _estimate(self) -> Estimate:
        return Estimate(self.mean[:3], self.P[:3, :3], self.mean[3:])

    def _input_since(self, step: Step) -> Floats:
        """Return the input that acted since the previous step; called once a step."""
        return np.asarray(step.last_u)

    @abstractmethod
    def predict(self, u: Floats, dt: float) -> None:
        """Predict the state of the next step.

        Parameters
        ----------
        u : array (2,)
            The input since the last step (V).
        dt : float
            The time since the last step (s).
        """

    @abstractmethod
    def update(self, z: Floats) -> None:
        """Update the state with a measured pose z, (3,), whose covariance is `R`."""


class RobotMotion:
    """The state transition of the robot model, for the state (pose, velocity).

    The model needs the last two poses. The state has the last one and the velocity v(k) = (pose(k)
    - pose(k-1)) / T, so pose(k-2) = pose(k-1) - T v(k-1). Headings are not wrapped, so that they do
    not jump.

    Parameters
    ----------
    model : RobotModel, optional
        The model. Default: the default robot's.

    Raises
    ------
    TypeError
        If `model` is not a RobotModel.

    Examples
    --------
    Without an input, a robot at rest stays where it is:

    >>> motion = robsim.estimation.reference.RobotMotion()
    >>> motion.move(np.array([600.0, 600, 0, 0, 0, 0]), np.zeros(2)).round(3)
    array([600., 600.,   0.,   0.,   0.,   0.])
    """

    def __init__(self, model: RobotModel | None = None) -> None:
        known = RobotModel() if model is None else model
        self.model: RobotModel = check_kind("model", known, RobotModel)
        self.T = self.model.dt

    def _poses(self, name: str, states: Floats) -> tuple[Floats, Floats]:
        """Return the last two poses of each state; the errors name the argument."""
        states = as_float_array(name, states)
        if states.shape[-1:] != (6,):
            raise ValueError(f"{name} must be of shape (..., 6), got {states.shape}")
        pose_1, velocity = states[..., :3], states[..., 3:]
        # pose(k-2) = pose(k-1) - T v(k-1)
        return pose_1, pose_1 - self.T * velocity

    def move(self, states: Floats, u: Floats) -> Floats:
        """Return the states of the next step.

        Parameters
        ----------
        states : array (6,) or (N, 6)
            States of step k-1.
        u : array (2,)
            Input of step k-1 (V).
        """
        pose_1, pose_2 = self._poses("states", states)
        pose = self.model.predict(pose_1, pose_2, u, unwrapped=True)
        # v(k) = (pose(k) - pose(k-1)) / T
        return np.concatenate((pose, (pose - pose_1) / self.T), axis=-1)

    def jacobian(self, state: Floats, u: Floats) -> Floats:
        """Return F, (6, 6): the derivative of the next state by a state, (6,)."""
        J = self.model.jacobian(*self._poses("state", state), u)
        # d pose(k) = (J_1 + J_2) d pose(k-1) - T J_2 d v(k-1)
        by_pose, by_velocity = J[:, :3] + J[:, 3:], -self.T * J[:, 3:]
        # d v(k) = (d pose(k) - d pose(k-1)) / T
        return np.block(
            [[by_pose, by_velocity], [(by_pose - np.eye(3)) / self.T, by_velocity / self.T]]
        )

    @property
    def G(self) -> Floats:
        """The gain of the process noise, (6, 3): noise w of the pose also changes the velocity."""
        # pose(k) = ... + w,  v(k) = ... + w / T
        return np.vstack((np.eye(3), np.eye(3) / self.T))

    def steps_in(self, dt: float) -> int:
        """Return the number of model steps in a time (s): several if frames were lost."""
        return self.model.steps_in(dt)
