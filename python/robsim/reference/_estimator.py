"""What every filter shares."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from robsim._base.checks import Floats
from robsim._core import Estimate, Step
from robsim.reference._noise import check_vector3


@dataclass(frozen=True, kw_only=True)
class Prior:
    """What is known of the robot before it is seen for the first time.

    The default: it is somewhere in the work area, faces anywhere, and is not fast.

    Parameters
    ----------
    pose : sequence of 3 floats
        The most likely pose: x, y (px), heading (rad).
    pose_deviation : sequence of 3 floats
        Its standard deviations (px, px, rad).
    velocity_deviation : sequence of 3 floats
        Those of the velocity, which is 0 on average (px/s, px/s, rad/s).
    """

    pose: Sequence[float] = (600.0, 600.0, 0.0)
    pose_deviation: Sequence[float] = (600.0, 600.0, 1.8)
    velocity_deviation: Sequence[float] = (15.0, 15.0, 0.3)

    def __post_init__(self) -> None:
        check_vector3("pose", self.pose)
        check_vector3("pose_deviation", self.pose_deviation, exclusive_minimum=0)
        check_vector3("velocity_deviation", self.velocity_deviation, exclusive_minimum=0)

    @property
    def mean(self) -> Floats:
        """Mean of the state, (6,): the pose and its velocity."""
        return np.array([*self.pose, 0.0, 0.0, 0.0], dtype=np.float64)

    @property
    def P(self) -> Floats:
        """Covariance of the state, (6, 6)."""
        return np.diag(np.square([*self.pose_deviation, *self.velocity_deviation]))


class StateEstimator(ABC):
    """A filter as the loop calls it: ``estimate_state(step) -> Estimate``.

    The state is (x, y, heading, and their velocities) in px, rad and s, its heading wrapped.

    A filter begins anew at step 0, and at any later step that does not follow the one before. It
    remembers a run: make one for each simulation. A step that comes a second time is a
    RuntimeError, as when two simulations share a filter.

    Attributes
    ----------
    mean : array (6,)
        The estimated state.
    P : array (6, 6)
        Its covariance.
    """

    mean: Floats
    P: Floats

    def __init__(self, prior: Prior | None) -> None:
        if prior is not None and not isinstance(prior, Prior):
            raise TypeError(f"prior must be a Prior, got {prior!r}")
        self.prior = Prior() if prior is None else prior
        self.reset()

    def reset(self) -> None:
        """Forget the run: what is known is the prior."""
        self.mean, self.P = self.prior.mean, self.prior.P
        self._has_seen = False
        self._last_step = -1

    def __call__(self, step: Step) -> Estimate:
        """Return the pose of a step, its covariance, and as further state its velocity."""
        if step.k == self._last_step > 0:
            raise RuntimeError(
                f"step {step.k} came twice: make a filter for each simulation, or reset() it"
            )
        if step.k == 0 or step.k != self._last_step + 1:
            self.reset()
        # The prior holds until the robot is seen: where it faces decides where an input drives it.
        if self._has_seen:
            self.predict(step.last_u, step.dt)
        if step.measurement is not None:
            self.update(step.measurement.pose)
            self._has_seen = True
        self._last_step = step.k
        return Estimate(self.mean[:3], self.P[:3, :3], self.mean[3:])

    @abstractmethod
    def predict(self, u: Floats, dt: float) -> None:
        """Go on by one step.

        Parameters
        ----------
        u : array (2,)
            The input since the step before (V).
        dt : float
            The time since then (s).
        """

    @abstractmethod
    def update(self, z: Floats) -> None:
        """Take in a measured pose, (3,)."""
