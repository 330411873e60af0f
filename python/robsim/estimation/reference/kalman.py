"""Kalman filters: with constant velocity, extended and unscented."""

from __future__ import annotations

import copy
from collections.abc import Iterable, Sequence
from itertools import repeat
from typing import Any, Self

import numpy as np

from robsim._core import Estimate, RobotModel, Step, check_mean_interval, wrap_angle
from robsim.base.checks import Floats, as_float_array, check_float, check_kind
from robsim.estimation.reference.estimator import (
    PROCESS_SIGMA,
    Prior,
    RobotMotion,
    StateEstimator,
    check_process_sigma,
    covariance,
    root,
)
from robsim.trace.timing import check_delay, delayed

#: The measurement is the pose, the first half of the state: z = H x + noise.
H = np.eye(3, 6)


def innovation_of(z: Floats, poses: Floats) -> Floats:
    """Return the innovations of a measured pose z, (3,), at poses (3,) or (N, 3); wrapped."""
    z = as_float_array("z", z)
    if z.shape != (3,):
        raise ValueError(f"z must be a pose (x, y, heading), got the shape {z.shape}")
    # innovation = z - H x
    innovation = z - poses
    innovation[..., 2] = wrap_angle(innovation[..., 2])
    return innovation


def kalman_update(
    mean: Floats, P: Floats, z: Floats, R: Floats
) -> tuple[Floats, Floats, Floats, Floats]:
    """Return the updated mean and P, the innovation and its covariance S."""
    innovation = innovation_of(z, mean[:3])
    # S = H P H' + R
    S = H @ P @ H.T + R
    # K = P H' S^-1
    K = np.linalg.solve(S, H @ P).T
    # x = x + K innovation
    mean = mean + K @ innovation
    mean[2] = wrap_angle(mean[2])
    # P = (I - K H) P (I - K H)' + K R K'  (Joseph form: stays symmetric positive definite)
    I_KH = np.eye(6) - K @ H
    return mean, I_KH @ P @ I_KH.T + K @ R @ K.T, innovation, S


class KalmanFilter(StateEstimator):
    """A filter with a normally distributed state; the subclasses differ in the prediction.

    The `innovation` (3,) is the measured minus the predicted pose, `S` (3, 3) its covariance. Both
    are None if the robot was not seen.
    """

    innovation: Floats | None
    S: Floats | None

    def reset(self) -> None:
        """Return to the prior."""
        super().reset()
        self.innovation = self.S = None

    def _set_prediction(self, mean: Floats, P: Floats) -> None:
        """Keep the predicted mean and covariance."""
        mean[2] = wrap_angle(mean[2])
        self.mean, self.P = mean, P
        self.innovation = self.S = None

    def update(self, z: Floats) -> None:
        """Update the state with a measured pose z, (3,), whose covariance is `R`."""
        self.mean, self.P, self.innovation, self.S = kalman_update(self.mean, self.P, z, self.R)


class ConstantVelocityKalmanFilter(KalmanFilter):
    """A Kalman filter with a constant-velocity model, without the inputs.

    Changes of the velocity by the motors are process noise: an acceleration, constant in each step.

    Parameters
    ----------
    acceleration_sigma : sequence of 3 floats
        Standard deviations of the acceleration of x, y and the heading (px/s^2, px/s^2, rad/s^2).
    measurement_sigma : sequence of 3 floats, optional
        Standard deviations of a measured pose (px, px, rad), for all measurements instead of their
        covariances. Default: the covariance of each measurement; without one (0.3, 0.3, 0.05), as
        in a simulation with 36 drawn headings in a frame of 1200 px.
    prior : Prior, optional
        The knowledge before the robot is first seen.

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
    Root mean square error of the heading (rad), measured and estimated:

    >>> sim = robsim.Simulation(measure=True, control=robsim.DriveAround(), seed=1)
    >>> sim.estimate_state = robsim.estimation.reference.ConstantVelocityKalmanFilter()
    >>> trace = sim.run(100)
    >>> kinds = "measurement", "estimate"
    >>> [robsim.pose_errors(trace, of=one).rmse[2].round(2).item() for one in kinds]
    [0.05, 0.04]
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


class _StepAhead:
    """A step with another estimate. Not a copy, because copying would draw the frame."""

    def __init__(self, step: Step, estimate: Estimate) -> None:
        self._step, self.estimate = step, estimate

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):  # copies and pickles read them before __init__
            raise AttributeError(name)
        return getattr(self._step, name)

    def __repr__(self) -> str:
        return f"{self._step!r} with the estimate {self.estimate!r}"


class ModelFilter(StateEstimator):
    """A filter that predicts with the robot model, `motion`, and the inputs."""

    def __init__(self, model: RobotModel | None, *, motor_delay: float, **options: Any) -> None:
        self.motion = RobotMotion(model)
        self._motor_delay = check_delay("motor_delay", motor_delay)
        super().__init__(**options)

    @property
    def motor_delay(self) -> float:
        """Delay of the inputs (steps of the model)."""
        return self._motor_delay

    def reset(self) -> None:
        """Return to the prior."""
        super().reset()
        self._time, self._n_steps = 0.0, 0
        # the inputs of the last steps of the model, as many as do not act to their end yet
        self._sent = np.zeros((int(np.ceil(self.motor_delay)), 2))

    def _input_since(self, step: Step) -> Floats:
        last_u = np.asarray(step.last_u)
        if not self.motor_delay or step.k == 0:
            return last_u
        # Of lost frames the input of the step before holds for several steps of the model.
        n_steps = self.motion.steps_in(step.dt)
        sent = np.vstack((self._sent, *repeat(last_u, n_steps)))
        self._sent = sent[n_steps:]
        return delayed(sent, self.motor_delay)[-n_steps:]

    def _inputs(self, u: Floats, dt: float) -> Iterable[Floats]:
        """Return the input of each model step in a time (s); ValueError for a wrong shape."""
        n_steps = self.motion.steps_in(dt)
        self._time += dt
        self._n_steps += n_steps
        check_mean_interval(self._time, self._n_steps, self.motion.T)
        return u if np.ndim(u) == 2 else repeat(u, n_steps)

    def predicted(self) -> Estimate:
        """Return the estimate for the time at which an input sent now begins to act.

        It starts from the newest estimate and applies the inputs that are sent but not yet visible
        in a frame. Before the robot is seen, and without a delay, it is the newest estimate itself.
        Between two steps of the model state and covariance are interpolated linearly.

        Returns
        -------
        Estimate
            Pose, covariance and velocity `motor_delay` steps after the newest step.
        """
        if not (self.motor_delay and self._has_seen):
            return self._estimate()
        whole = int(self.motor_delay)
        fraction = self.motor_delay - whole
        ahead = self._copy()
        # The inputs for the coming steps are known, except those sent from now on.
        to_come = delayed(np.vstack((self._sent, np.zeros((whole, 2)))), self.motor_delay)
        for u in to_come[len(self._sent) :]:
            ahead.predict(u, self.motion.T)
        if fraction:
            before = ahead._copy()
            ahead.predict(self._sent[-1], self.motion.T)
            ahead._interpolate(before, fraction)
        return ahead._estimate()

    def ahead(self, step: Step) -> Any:
        """Return the step for a controller whose inputs act late: with `predicted`.

        A controller that drives by ``step.estimate``, as `GoToPoint` and `FollowPath` do, then
        compensates the delay: it receives the pose at which its input begins to act. The result of
        `estimate_state`, and the trace, still belong to the newest frame.

        Parameters
        ----------
        step : Step
            The step that this filter, as ``estimate_state``, has estimated.

        Returns
        -------
        object
            All attributes of the step, with another ``estimate``.

        Raises
        ------
        TypeError
            If `step` is not a Step.
        RuntimeError
            If this filter has not estimated the step.

        Examples
        --------
        >>> sim = robsim.Simulation(measure=True, motor_delay=2.4, seed=1)
        >>> from robsim.estimation.reference import ExtendedKalmanFilter
        >>> kalman_filter = ExtendedKalmanFilter(sim.model, motor_delay=2.4)
        >>> go = robsim.GoToPoint(900, 300)
        >>> sim.estimate_state = kalman_filter
        >>> sim.control = lambda step: go(kalman_filter.ahead(step))
        >>> trace = sim.run(200)
        """
        check_kind("step", step, Step)
        if step.k != self._last_step:
            raise RuntimeError(
                f"the filter has not estimated step {step.k}: also pass the filter as "
                "estimate_state"
            )
        return _StepAhead(step, self.predicted())

    def _copy(self) -> Self:
        """Return an independent copy of the filter."""
        return copy.copy(self)

    def _interpolate(self, before: Self, fraction: float) -> None:
        """Set the state between `before` (fraction 0) and the present state (fraction 1)."""
        change = self.mean - before.mean
        change[2] = wrap_angle(change[2])
        self.mean = before.mean + fraction * change
        self.mean[2] = wrap_angle(self.mean[2])
        self.P = (1 - fraction) * before.P + fraction * self.P


class ExtendedKalmanFilter(ModelFilter, KalmanFilter):
    """A Kalman filter on the robot model, linearised at each estimate.

    Parameters
    ----------
    model : RobotModel, optional
        The motion model: ``sim.model``, or one from `RobotParameters`. Default: the default
        robot's.
    process_sigma : sequence of 3 floats
        Standard deviations of the process noise of the pose in each step (px, px, rad): motion of
        the robot outside the model. In a simulation with ``process_noise=noise``, a `PoseNoise`,
        give ``noise.sigma``. Without disturbances the model is exact, and 0 is optimal as long as
        there are no walls, which the model ignores. After a bounce a filter with 0 would not
        recover. The default suits a `PoseNoise` of these standard deviations, or parameters that
        are off by about 5 %. Without disturbances `pose_consistency` rightly calls it conservative.
    measurement_sigma : sequence of 3 floats, optional
        Standard deviations of a measured pose (px, px, rad), for all measurements instead of their
        covariances. Default: the covariance of each measurement; without one (0.3, 0.3, 0.05), as
        in a simulation with 36 drawn headings in a frame of 1200 px.
    motor_delay : float
        Delay of the inputs, in steps of the model, 0..1000: the `motor_delay` of a simulated world,
        the ``trace.timing().motor_delay`` of a live one. `ahead` then compensates it. It counts
        from ``step.last_u``: if the frames report the motors' inputs, only the later delay.
    prior : Prior, optional
        The knowledge before the robot is first seen.

    Attributes
    ----------
    Q : array (3, 3)
        Covariance of the process noise of the pose in a step, from `process_sigma`. It can be set
        between steps: to ``noise.Q`` of a `PoseNoise` whose components are correlated, or to the
        ``noise.Q(model, heading)`` of a `WheelNoise` at the estimated heading.

    Raises
    ------
    TypeError, ValueError
        If a value is not a number, or negative, or if a measurement sigma is 0; in a run, if the
        time between two steps is not a multiple of the model's dt.

    Notes
    -----
    Source: Bar-Shalom, Li and Kirubarajan, Estimation with Applications to Tracking and
    Navigation, 2001, 10.3 (the first-order filter).

    Examples
    --------
    Root mean square error of the heading (rad), measured and estimated:

    >>> noise = robsim.PoseNoise.from_sigma(0.3, 0.3, 0.01)
    >>> control = robsim.DriveAround()
    >>> sim = robsim.Simulation(measure=True, process_noise=noise, control=control, seed=1)
    >>> sim.estimate_state = robsim.estimation.reference.ExtendedKalmanFilter(
    ...     sim.model, process_sigma=noise.sigma
    ... )
    >>> trace = sim.run(100)
    >>> kinds = "measurement", "estimate"
    >>> [robsim.pose_errors(trace, of=one).rmse[2].round(2).item() for one in kinds]
    [0.05, 0.03]
    """

    def __init__(
        self,
        model: RobotModel | None = None,
        *,
        process_sigma: Sequence[float] = PROCESS_SIGMA,
        measurement_sigma: Sequence[float] | None = None,
        motor_delay: float = 0.0,
        prior: Prior | None = None,
    ) -> None:
        self.Q = np.diag(check_process_sigma(process_sigma) ** 2)
        super().__init__(
            model, motor_delay=motor_delay, measurement_sigma=measurement_sigma, prior=prior
        )

    def predict(self, u: Floats, dt: float) -> None:
        """Predict the state dt (s) ahead, one or more steps of the model.

        Parameters
        ----------
        u : array (2,) or (n, 2)
            The input that acts (V), or the inputs of each step of the model.
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


class UnscentedKalmanFilter(ModelFilter, KalmanFilter):
    """A Kalman filter that propagates sigma points through the robot model, without a Jacobian.

    The sigma points have the mean and the covariance of the estimate; after the model they give the
    prediction's. The measurement is linear in the state, so its update needs no sigma points: they
    would give the Kalman update exactly.

    Parameters
    ----------
    model, process_sigma, measurement_sigma, motor_delay, prior
        As for `ExtendedKalmanFilter`: by default R is the covariance of each measurement.
    kappa : float
        Spread of the sigma points: sqrt(6 + kappa) standard deviations. At least 0, so that no
        weight is negative.

    Attributes
    ----------
    Q : array (3, 3)
        As for `ExtendedKalmanFilter`.

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
    Root mean square error of the heading (rad), measured and estimated:

    >>> sim = robsim.Simulation(measure=True, control=robsim.DriveAround(), seed=1)
    >>> sim.estimate_state = robsim.estimation.reference.UnscentedKalmanFilter(sim.model)
    >>> trace = sim.run(100)
    >>> kinds = "measurement", "estimate"
    >>> [robsim.pose_errors(trace, of=one).rmse[2].round(2).item() for one in kinds]
    [0.05, 0.02]
    """

    def __init__(
        self,
        model: RobotModel | None = None,
        *,
        process_sigma: Sequence[float] = PROCESS_SIGMA,
        measurement_sigma: Sequence[float] | None = None,
        kappa: float = 0.0,
        motor_delay: float = 0.0,
        prior: Prior | None = None,
    ) -> None:
        self.Q = np.diag(check_process_sigma(process_sigma) ** 2)
        self.kappa = check_float("kappa", kappa, minimum=0)
        super().__init__(
            model, motor_delay=motor_delay, measurement_sigma=measurement_sigma, prior=prior
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
        """Predict the state dt (s) ahead, like `ExtendedKalmanFilter.predict`."""
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
