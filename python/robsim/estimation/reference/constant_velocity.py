"""The constant-velocity Kalman filter, which needs no model of the robot."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robsim.base.checks import Floats, check_float
from robsim.estimation.reference._kalman import KalmanFilter
from robsim.estimation.reference.estimator import Prior
from robsim.estimation.reference.noise import covariance


class ConstantVelocityKalmanFilter(KalmanFilter):
    """A Kalman filter with a constant-velocity model, without the inputs.

    What the motors do to the velocity is process noise: an acceleration, constant in each step.

    Parameters
    ----------
    acceleration_sigma : sequence of 3 floats
        Standard deviations of the acceleration of x, y and the heading (px/s^2, px/s^2, rad/s^2).
    measurement_sigma : sequence of 3 floats, optional
        Standard deviations of a measured pose (px, px, rad), for all measurements, whatever their
        covariances say. Default: of each measurement, what its covariance says; of one without,
        (0.3, 0.3, 0.05), those of a simulation with 36 drawn headings in a frame of 1200 px.
    prior : Prior, optional
        What is known before the robot is first seen.

    Raises
    ------
    TypeError, ValueError
        If a value is not a number, or negative; if a measurement sigma is 0.

    Notes
    -----
    Source: Bar-Shalom, Li and Kirubarajan, Estimation with Applications to Tracking and
    Navigation, 2001, 6.3.2 (discrete white noise acceleration).

    Examples
    --------
    >>> import robsim.estimation.reference
    >>> estimate_state = robsim.estimation.reference.ConstantVelocityKalmanFilter()
    >>> sim = robsim.Simulation(measure=True, estimate_state=estimate_state, seed=1)
    >>> trace = sim.run(100)
    """

    def __init__(
        self,
        *,
        acceleration_sigma: Sequence[float] = (10.0, 10.0, 1.0),
        measurement_sigma: Sequence[float] | None = None,
        prior: Prior | None = None,
    ) -> None:
        self.Q = covariance("acceleration_sigma", acceleration_sigma, minimum=0)
        super().__init__(measurement_sigma=measurement_sigma, prior=prior)

    def predict(self, u: Floats, dt: float) -> None:
        """Predict the state one step of dt (s) ahead; the input u is not used."""
        T = check_float("dt", dt, "s", exclusive_minimum=0)
        I, O = np.eye(3), np.zeros((3, 3))  # noqa: E741
        # pose(k) = pose(k-1) + T v(k-1) + T^2/2 acceleration,  v(k) = v(k-1) + T acceleration
        F = np.block([[I, T * I], [O, I]])
        G = np.vstack((T**2 / 2 * I, T * I))
        # x = F x,  P = F P F' + G Q G'
        self._set_prediction(F @ self.mean, F @ self.P @ F.T + G @ self.Q @ G.T)
