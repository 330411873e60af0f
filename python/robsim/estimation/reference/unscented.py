"""The unscented Kalman filter on the robot model."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robsim._core import RobotModel
from robsim.base.checks import Floats, check_float
from robsim.estimation.reference._kalman import KalmanFilter
from robsim.estimation.reference._model_filter import ModelFilter
from robsim.estimation.reference.estimator import Prior
from robsim.estimation.reference.noise import PROCESS_SIGMA, check_process_sigma, root


class UnscentedKalmanFilter(ModelFilter, KalmanFilter):
    """A Kalman filter that propagates sigma points through the robot model, without a Jacobian.

    The sigma points have the mean and the covariance of the estimate; the propagated ones have
    those of the prediction. The measurement is linear in the state, so its update needs no sigma
    points: they would give the Kalman update exactly.

    Parameters
    ----------
    model, process_sigma, measurement_sigma, input_delay, prior
        As for `ExtendedKalmanFilter`: by default R is the covariance of each measurement.
    kappa : float
        Spread of the sigma points: sqrt(6 + kappa) standard deviations. At least 0, so that no
        weight is negative.

    Attributes
    ----------
    Q : array (3, 3)
        As of `ExtendedKalmanFilter`.

    Raises
    ------
    TypeError, ValueError
        As for `ExtendedKalmanFilter`.

    Notes
    -----
    Source: Julier and Uhlmann, A New Extension of the Kalman Filter to Nonlinear Systems, Proc.
    SPIE 3068, 1997, section 3.

    Examples
    --------
    >>> import robsim.estimation.reference
    >>> sim = robsim.Simulation(measure=True, seed=1)
    >>> sim.estimate_state = robsim.estimation.reference.UnscentedKalmanFilter(sim.model)
    >>> trace = sim.run(100)
    """

    def __init__(
        self,
        model: RobotModel | None = None,
        *,
        process_sigma: Sequence[float] = PROCESS_SIGMA,
        measurement_sigma: Sequence[float] | None = None,
        kappa: float = 0.0,
        input_delay: float = 0.0,
        prior: Prior | None = None,
    ) -> None:
        self.Q = np.diag(check_process_sigma(process_sigma) ** 2)
        self.kappa = check_float("kappa", kappa, minimum=0)
        super().__init__(
            model, input_delay=input_delay, measurement_sigma=measurement_sigma, prior=prior
        )

    def sigma_points(self) -> tuple[Floats, Floats]:
        """Return the sigma points, (13, 6), and their weights, (13,)."""
        n, kappa = 6, self.kappa
        # columns of L with L L' = (n + kappa) P
        L = root((n + kappa) * self.P)
        # x_0 = x,  x_i = x + L_i,  x_n+i = x - L_i
        points = self.mean + np.vstack((np.zeros(n), L.T, -L.T))
        # W_0 = kappa / (n + kappa),  W_i = 1 / (2 (n + kappa))
        weights = np.array([kappa, *[0.5] * (2 * n)]) / (n + kappa)
        return points, weights

    def predict(self, u: Floats, dt: float) -> None:
        """Predict the state dt (s) ahead, as `ExtendedKalmanFilter.predict`."""
        G = self.motion.G
        for acting in self._inputs(u, dt):
            points, weights = self.sigma_points()
            # The headings of the sigma points are unwrapped: their plain mean is correct.
            points = self.motion.move(points, acting)
            # x = sum W_i x_i,  P = sum W_i (x_i - x)(x_i - x)' + G Q G'
            mean = weights @ points
            deviation = points - mean
            P = (weights * deviation.T) @ deviation + G @ self.Q @ G.T
            self._set_prediction(mean, P)
