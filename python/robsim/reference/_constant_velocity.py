"""The constant-velocity Kalman filter."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robsim._base.checks import Floats
from robsim.reference._estimator import Prior
from robsim.reference._kalman import KalmanFilter
from robsim.reference._noise import MEASUREMENT_NOISE, covariance


class ConstantVelocityKalmanFilter(KalmanFilter):
    """A Kalman filter that knows nothing of the robot but that it has a velocity.

    What the motors do to the velocity is noise to it: an acceleration, constant in each step.

    Parameters
    ----------
    acceleration : sequence of 3 floats
        Standard deviations of the acceleration of x, y and the heading (px/s^2, px/s^2, rad/s^2).
    measurement_noise : sequence of 3 floats
        Standard deviations of a measured pose (px, px, rad). The default is that of 36 drawn
        headings in a frame of 1200 px; with ``headings=None`` it is about
        (0.05, 0.05, 0.002), with ``resolution=(480, 480)`` (0.7, 0.7, 0.05).
    prior : Prior, optional
        What is known before the robot is seen.

    Raises
    ------
    TypeError, ValueError
        If a value is not a number, or negative.

    Notes
    -----
    Source: Bar-Shalom, Li and Kirubarajan, Estimation with Applications to Tracking and
    Navigation, 2001, 6.3.2 (discrete white noise acceleration).

    Examples
    --------
    >>> import robsim.reference
    >>> estimate_state = robsim.reference.ConstantVelocityKalmanFilter()
    >>> sim = robsim.Simulation(measure=True, estimate_state=estimate_state, seed=1)
    >>> trace = sim.run(100)
    """

    def __init__(
        self,
        *,
        acceleration: Sequence[float] = (10.0, 10.0, 1.0),
        measurement_noise: Sequence[float] = MEASUREMENT_NOISE,
        prior: Prior | None = None,
    ) -> None:
        self.Q = covariance("acceleration", acceleration, minimum=0)
        super().__init__(measurement_noise=measurement_noise, prior=prior)

    def predict(self, u: Floats, dt: float) -> None:
        """Go on by one step of dt (s); the input u is not used."""
        T, I, O = dt, np.eye(3), np.zeros((3, 3))  # noqa: E741
        # pose(k) = pose(k-1) + T v(k-1) + T^2/2 acceleration,  v(k) = v(k-1) + T acceleration
        F = np.block([[I, T * I], [O, I]])
        G = np.vstack((T**2 / 2 * I, T * I))
        # x = F x,  P = F P F' + G Q G'
        self._predicted(F @ self.mean, F @ self.P @ F.T + G @ self.Q @ G.T)
