"""The base class of all reference filters, and the prior that they start from."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from robsim._core import Estimate, Step
from robsim.base.checks import Floats, as_float_array
from robsim.base.text import quoted
from robsim.estimation.reference.noise import MEASUREMENT_SIGMA, check_vector3, covariance


@dataclass(frozen=True, kw_only=True)
class Prior:
    """The prior distribution of the robot's state, before it is first seen.

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
    """A filter as the simulation calls it: ``estimate_state(step) -> Estimate``.

    The state is the pose (x, y, heading) and its velocity, in px, rad and s; the heading is
    wrapped.

    A filter resets at step 0, and at any later step that does not follow the last one. It keeps
    the state of one run: create one for each simulation. The same step twice is a RuntimeError,
    as when two simulations share a filter.

    Attributes
    ----------
    mean : array (6,)
        The estimated state.
    P : array (6, 6)
        Its covariance.
    """

    mean: Floats
    P: Floats

    def __init__(self, measurement_sigma: Sequence[float] | None, prior: Prior | None) -> None:
        known = MEASUREMENT_SIGMA if measurement_sigma is None else measurement_sigma
        self._R = self._usual_R = covariance("measurement_sigma", known, exclusive_minimum=0)
        self._has_own_R = measurement_sigma is not None
        if prior is not None and not isinstance(prior, Prior):
            raise TypeError(f"prior must be a Prior, got {quoted(prior)}")
        self.prior = Prior() if prior is None else prior
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

        Once it is set, it holds for all measurements.
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
                f"step {step.k} came twice: create a filter for each simulation, or reset() it"
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
        """Return the input that acted since the step before; called once a step."""
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
