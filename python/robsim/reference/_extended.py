"""The extended Kalman filter."""

from __future__ import annotations

from collections.abc import Sequence

from robsim._base.checks import Floats
from robsim._core import RobotModel
from robsim.reference._estimator import Prior
from robsim.reference._kalman import KalmanFilter
from robsim.reference._motion import RobotMotion
from robsim.reference._noise import MEASUREMENT_NOISE, PROCESS_NOISE, covariance


class ExtendedKalmanFilter(KalmanFilter):
    """A Kalman filter on the robot model, made linear at each step where the estimate is.

    Parameters
    ----------
    model : RobotModel, optional
        How the robot moves: ``sim.model``, or one from `RobotParameters`. Default: the default
        robot's.
    process_noise : sequence of 3 floats
        Standard deviations of what the model does not say of the next pose (px, px, rad). It
        knows no walls: without any, the filter would not get over the first bounce.
    measurement_noise : sequence of 3 floats
        Standard deviations of a measured pose (px, px, rad). The default is that of 36 drawn
        headings in a frame of 1200 px; with ``headings=None`` it is about
        (0.05, 0.05, 0.002), with ``resolution=(480, 480)`` (0.7, 0.7, 0.05).
    prior : Prior, optional
        What is known before the robot is seen.

    Raises
    ------
    TypeError, ValueError
        If a value is not a number, or negative; in a run, if the steps are not those of the model.

    Notes
    -----
    Source: Bar-Shalom, Li and Kirubarajan, Estimation with Applications to Tracking and
    Navigation, 2001, 10.3 (the first-order filter).

    Examples
    --------
    >>> import robsim.reference
    >>> sim = robsim.Simulation(measure=True, seed=1)
    >>> sim.estimate_state = robsim.reference.ExtendedKalmanFilter(sim.model)
    >>> trace = sim.run(100)
    """

    def __init__(
        self,
        model: RobotModel | None = None,
        *,
        process_noise: Sequence[float] = PROCESS_NOISE,
        measurement_noise: Sequence[float] = MEASUREMENT_NOISE,
        prior: Prior | None = None,
    ) -> None:
        self.motion = RobotMotion(model)
        self.Q = covariance("process_noise", process_noise, minimum=0)
        super().__init__(measurement_noise=measurement_noise, prior=prior)

    def predict(self, u: Floats, dt: float) -> None:
        """Go on by dt (s), a step of the model or several, with the input u (V)."""
        G = self.motion.G
        for _ in range(self.motion.steps_in(dt)):
            # F = df/dx at the estimate
            F = self.motion.jacobian(self.mean, u)
            # x = f(x, u),  P = F P F' + G Q G'
            self._predicted(self.motion.move(self.mean, u), F @ self.P @ F.T + G @ self.Q @ G.T)
