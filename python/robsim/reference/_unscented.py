"""The unscented Kalman filter."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robsim._base.checks import Floats, check_float
from robsim._core import RobotModel
from robsim.reference._estimator import Prior
from robsim.reference._kalman import KalmanFilter
from robsim.reference._motion import RobotMotion
from robsim.reference._noise import MEASUREMENT_NOISE, PROCESS_NOISE, covariance


class UnscentedKalmanFilter(KalmanFilter):
    """A Kalman filter that sends points through the robot model instead of a Jacobian.

    The points have the mean and the covariance of the belief; where they arrive has those of the
    prediction. The measurement is linear in the state, so its update needs no points: they would
    give the Kalman update exactly.

    Parameters
    ----------
    model, process_noise, measurement_noise, prior
        As of `ExtendedKalmanFilter`.
    kappa : float
        How far out the points are: sqrt(6 + kappa) standard deviations. Not negative, so that no
        weight is.

    Raises
    ------
    TypeError, ValueError
        As of `ExtendedKalmanFilter`.

    Notes
    -----
    Source: Julier and Uhlmann, A New Extension of the Kalman Filter to Nonlinear Systems, Proc.
    SPIE 3068, 1997, section 3.

    Examples
    --------
    >>> import robsim.reference
    >>> sim = robsim.Simulation(measure=True, seed=1)
    >>> sim.estimate_state = robsim.reference.UnscentedKalmanFilter(sim.model)
    >>> trace = sim.run(100)
    """

    def __init__(
        self,
        model: RobotModel | None = None,
        *,
        process_noise: Sequence[float] = PROCESS_NOISE,
        measurement_noise: Sequence[float] = MEASUREMENT_NOISE,
        kappa: float = 0.0,
        prior: Prior | None = None,
    ) -> None:
        self.motion = RobotMotion(model)
        self.Q = covariance("process_noise", process_noise, minimum=0)
        self.kappa = check_float("kappa", kappa, minimum=0)
        super().__init__(measurement_noise=measurement_noise, prior=prior)

    def sigma_points(self) -> tuple[Floats, Floats]:
        """Return the points, (13, 6), and their weights, (13,)."""
        n, kappa = 6, self.kappa
        # columns of L with L L' = (n + kappa) P
        L = np.linalg.cholesky((n + kappa) * self.P)
        # x_0 = x,  x_i = x + L_i,  x_n+i = x - L_i
        points = self.mean + np.vstack((np.zeros(n), L.T, -L.T))
        # W_0 = kappa / (n + kappa),  W_i = 1 / (2 (n + kappa))
        weights = np.array([kappa, *[0.5] * (2 * n)]) / (n + kappa)
        return points, weights

    def predict(self, u: Floats, dt: float) -> None:
        """Go on by dt (s), a step of the model or several, with the input u (V)."""
        G = self.motion.G
        for _ in range(self.motion.steps_in(dt)):
            points, weights = self.sigma_points()
            # The headings of the points run on unwrapped around their mean: it is the plain one.
            points = self.motion.move(points, u)
            # x = sum W_i x_i,  P = sum W_i (x_i - x)(x_i - x)' + G Q G'
            mean = weights @ points
            deviation = points - mean
            P = (weights * deviation.T) @ deviation + G @ self.Q @ G.T
            self._predicted(mean, P)
