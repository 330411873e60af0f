"""The extended Kalman filter on the robot model."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robsim._core import RobotModel
from robsim.base.checks import Floats
from robsim.estimation.reference._kalman import KalmanFilter
from robsim.estimation.reference._model_filter import ModelFilter
from robsim.estimation.reference.estimator import Prior
from robsim.estimation.reference.noise import PROCESS_SIGMA, check_process_sigma


class ExtendedKalmanFilter(ModelFilter, KalmanFilter):
    """A Kalman filter on the robot model, linearised at each estimate.

    Parameters
    ----------
    model : RobotModel, optional
        The motion model: ``sim.model``, or one from `RobotParameters`. Default: that of the
        default robot.
    process_sigma : sequence of 3 floats
        Standard deviations of the process noise of the pose in each step (px, px, rad): what the
        model does not know of the robot's motion. In a simulation with ``process_noise=noise``, a
        `PoseNoise`, give ``noise.sigma``; without disturbances the model is exact, and 0 is
        optimal as long as there are no walls, of which the model knows nothing: after a bounce a
        filter with 0 would not recover. The default suits a `PoseNoise` of these standard
        deviations, or parameters that are off by about 5 %; without disturbances `pose_consistency`
        rightly calls it conservative.
    measurement_sigma : sequence of 3 floats, optional
        Standard deviations of a measured pose (px, px, rad), for all measurements, whatever their
        covariances say. Default: of each measurement, what its covariance says; of one without,
        (0.3, 0.3, 0.05), those of a simulation with 36 drawn headings in a frame of 1200 px.
    input_delay : float
        How late the inputs act, in steps of the model, 0..1000: the `motor_delay` of a simulated
        world, the ``trace.timing().input_delay`` of a live one. `ahead` then compensates it. It
        counts from ``step.last_u``: if the frames say what the motors got, only what comes after.
    prior : Prior, optional
        What is known before the robot is first seen.

    Attributes
    ----------
    Q : array (3, 3)
        Covariance of the process noise of the pose in a step, from `process_sigma`. It can be set
        between steps: to ``noise.Q`` of a `PoseNoise` whose components are correlated, or to the
        ``noise.Q(model, heading)`` of a `WheelNoise` at the estimated heading.

    Raises
    ------
    TypeError, ValueError
        If a value is not a number, or negative; if a measurement sigma is 0; in a run, if the time
        between two steps is not a multiple of the model's dt.

    Notes
    -----
    Source: Bar-Shalom, Li and Kirubarajan, Estimation with Applications to Tracking and
    Navigation, 2001, 10.3 (the first-order filter).

    Examples
    --------
    >>> import robsim.estimation.reference
    >>> noise = robsim.PoseNoise.from_sigma(0.3, 0.3, 0.01)
    >>> sim = robsim.Simulation(measure=True, process_noise=noise, seed=1)
    >>> sim.estimate_state = robsim.estimation.reference.ExtendedKalmanFilter(
    ...     sim.model, process_sigma=noise.sigma
    ... )
    >>> trace = sim.run(100)
    """

    def __init__(
        self,
        model: RobotModel | None = None,
        *,
        process_sigma: Sequence[float] = PROCESS_SIGMA,
        measurement_sigma: Sequence[float] | None = None,
        input_delay: float = 0.0,
        prior: Prior | None = None,
    ) -> None:
        self.Q = np.diag(check_process_sigma(process_sigma) ** 2)
        super().__init__(
            model, input_delay=input_delay, measurement_sigma=measurement_sigma, prior=prior
        )

    def predict(self, u: Floats, dt: float) -> None:
        """Predict the state dt (s) ahead, one or more steps of the model.

        Parameters
        ----------
        u : array (2,) or (n, 2)
            The input that acts (V), or that of each step of the model.
        dt : float
            The time (s).
        """
        G = self.motion.G
        for acting in self._inputs(u, dt):
            # F = df/dx at the estimate
            F = self.motion.jacobian(self.mean, acting)
            # x = f(x, u),  P = F P F' + G Q G'
            self._set_prediction(
                self.motion.move(self.mean, acting), F @ self.P @ F.T + G @ self.Q @ G.T
            )
