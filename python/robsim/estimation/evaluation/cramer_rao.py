"""Cramér-Rao bounds of parameter and state estimates, to compare estimators with."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robsim._core import RobotModel, regression
from robsim.base.checks import Floats, as_float_array
from robsim.base.text import quoted
from robsim.estimation.identification.fits.linear import decompose
from robsim.trace import Trace
from robsim.trace.trace import check_trace


def cramer_rao_bound(phi: ArrayLike, sigma: ArrayLike) -> Floats:
    """Return the minimum standard errors of an unbiased estimate from the samples up to each row.

    Parameters
    ----------
    phi : array (N, ..., n)
        Regressors, one sample per row; a row with NaN is skipped.
    sigma : float or array (...)
        Standard deviation of the additive output noise.

    Returns
    -------
    array (N, ..., n)
        Row k: the bound from the samples 0..k; inf = they do not determine the parameter.

    Raises
    ------
    ValueError
        If the shapes do not match, or sigma is negative.

    Notes
    -----
    For white Gaussian output noise the Fisher information is J = Phi' Phi/sigma^2, and the bound

        sqrt(diag(J^-1)) = sigma sqrt(diag((Phi' Phi)^-1))

    The bound is computed from the triangular factor R of a QR decomposition of Phi, R' R = Phi'
    Phi. Source: Kay, Fundamentals of Statistical Signal Processing: Estimation Theory, 4.3, 1993.
    With noise in the regressors, too, the true bound is larger.

    Examples
    --------
    The standard error of a mean falls with the square root of the number of samples:

    >>> robsim.estimation.cramer_rao_bound(np.ones((4, 1)), 1.0).ravel().round(3)
    array([1.   , 0.707, 0.577, 0.5  ])
    """
    rows = as_float_array("phi", phi)
    noise = as_float_array("sigma", sigma)
    if rows.ndim < 2 or np.broadcast_shapes(noise.shape, rows.shape[1:-1]) != rows.shape[1:-1]:
        raise ValueError(
            f"phi must be of shape (N, ..., n), and sigma must broadcast to the shape (...), got "
            f"{rows.shape} and {noise.shape}"
        )
    if not (noise >= 0).all():
        raise ValueError(f"sigma must be at least 0, got {quoted(sigma)}")
    rows = np.where(np.isnan(rows).any(axis=-1, keepdims=True), 0.0, rows)
    triangles = np.empty((*rows.shape, rows.shape[-1]))
    R = np.zeros(triangles.shape[1:])
    for k, row in enumerate(rows):
        stacked = np.concatenate((R, row[..., np.newaxis, :]), axis=-2)
        triangles[k] = R = _triangle(stacked)
    return noise[..., np.newaxis] * _inverse_lengths(triangles)


def _triangle(rows: Floats) -> Floats:
    triangle: Any = np.linalg.qr(rows, mode="r")
    return np.asarray(triangle)


def _inverse_lengths(R: Floats) -> Floats:
    """Return sqrt(diag((R' R)^-1)); inf where R' R does not determine the parameter."""
    parts = decompose(R)
    # (R' R)^-1 = V s^-2 V'
    errors = np.sqrt(np.sum(np.square(parts.inverse), axis=-1)) / parts.lengths
    return np.where(parts.is_determined, errors, np.inf)


def parameter_bounds(trace: Trace, *, sigma: ArrayLike) -> Floats:
    """Return the Cramér-Rao bound of the model's parameters over a run, as standard errors.

    Parameters
    ----------
    trace : Trace
        The run: its true poses and inputs are the regressors. Samples across a bounce are omitted.
    sigma : array (3,)
        Standard deviation of the process noise of x, y (in the unit of the trace) and heading (rad)
        in each step.

    Returns
    -------
    array (N, 3, 5)
        Row k: the bound from the samples up to step k; inf = no excitation yet. Draw it with
        ``robsim.plot_parameters(trace, standard_errors=...)``.

    Raises
    ------
    TypeError, ValueError
        If the trace has no true poses, or sigma has the wrong type or shape.

    Notes
    -----
    For measurement noise, this is no bound: given the sigma of one-step prediction errors, it is
    only the smallest error that least squares can reach. Output error may be 100 times as exact.

    Examples
    --------
    >>> trace = robsim.Simulation(seed=1, control=robsim.DriveAround()).run(300)
    >>> bounds = robsim.estimation.parameter_bounds(trace, sigma=(0.1, 0.1, 0.001))
    >>> bounds[-1, 2].round(4)
    array([0.0007, 0.0007, 0.0001, 0.0001, 0.0001])
    """
    _check_truth(trace)
    noise = as_float_array("sigma", sigma)
    if noise.shape != (3,):
        raise ValueError(f"sigma must be 3 numbers (px, px, rad), got {quoted(sigma)}")
    phi = np.full((len(trace), 3, 5), np.nan)
    if len(trace) > 2:
        phi[2:], _ = regression(trace.pose_true, trace.u)
        phi[2:][trace.bounced[2:] | trace.bounced[1:-1]] = np.nan
    return cramer_rao_bound(phi, noise)


def posterior_cramer_rao_bound(
    F: ArrayLike,
    H: ArrayLike,
    *,
    Q: ArrayLike,
    R: ArrayLike,
    P0: ArrayLike,
    seen: ArrayLike | None = None,
) -> Floats:
    """Return the minimum covariance of any estimate of a state from its measurements.

    Parameters
    ----------
    F : array (N - 1, n, n) or (n, n)
        Jacobian of the state transition from step k - 1 to step k, at the true trajectory.
    H : array (m, n) or (N, m, n)
        Jacobian of the measurement.
    Q : array (n, n)
        Covariance of the process noise of each step; may be singular or 0.
    R : array (m, m)
        Covariance of the measurement noise.
    P0 : array (n, n)
        Covariance of the first state before its measurement.
    seen : array (N,) of bool, optional
        The steps with a measurement. Default: all. Needed if F is (n, n).

    Returns
    -------
    array (N, n, n)
        The bound of step k, from the measurements of the steps 0..k.

    Raises
    ------
    ValueError
        If the shapes do not match.

    Notes
    -----
    The recursion for the information J comes from Tichavsky, Muravchik and Nehorai, Posterior
    Cramér-Rao bounds for discrete-time nonlinear filtering, IEEE Trans. Signal Processing 46(5),
    1998, for additive Gaussian noise, with the expectations replaced by the values along one
    trajectory::

        J(k) = (Q + F J(k-1)^-1 F')^-1 + H' R^-1 H

    The recursion computes P = J^-1 instead of J, so that Q may be singular. For a linear system, P
    is the covariance of the Kalman filter. For other systems the result is an approximation, not a
    strict bound. Average over runs if the trajectories differ much.

    Examples
    --------
    A constant with four measurements:

    >>> one = np.eye(1)
    >>> bound = robsim.estimation.posterior_cramer_rao_bound(
    ...     one, one, Q=0 * one, R=one, P0=1e6 * one, seen=[True] * 4
    ... )
    >>> bound.ravel().round(3)
    array([1.   , 0.5  , 0.333, 0.25 ])
    """
    F, H, Q, R, P = map(as_float_array, ("F", "H", "Q", "R", "P0"), (F, H, Q, R, P0))
    has_measurement = _seen_steps(F, seen)
    steps, n, m = (
        len(has_measurement),
        P.shape[-1] if P.ndim else 0,
        H.shape[-2] if H.ndim > 1 else 0,
    )
    F = _shaped("F", F, (steps - 1, n, n))
    H = _shaped("H", H, (steps, m, n))
    Q, R, P = _shaped("Q", Q, (n, n)), _shaped("R", R, (m, m)), _shaped("P0", P, (n, n))
    bounds = np.empty((steps, n, n))
    for k in range(steps):
        if k > 0:
            # P = F P F' + Q
            P = F[k - 1] @ P @ F[k - 1].T + Q
        if has_measurement[k]:
            P = _with_measurement(P, H[k], R)
        bounds[k] = P
    return bounds


def _with_measurement(P: Floats, H: Floats, R: Floats) -> Floats:
    # (P^-1 + H' R^-1 H)^-1 = (I - K H) P (I - K H)' + K R K' with K = P H' (H P H' + R)^-1
    try:
        K = np.linalg.solve(H @ P @ H.T + R, H @ P).T
    except np.linalg.LinAlgError:
        raise ValueError(
            f"R must make H P H' + R invertible in every step, got {quoted(R.tolist())}"
        ) from None
    I_KH = np.eye(len(P)) - K @ H
    bound: Floats = I_KH @ P @ I_KH.T + K @ R @ K.T
    return bound


def _seen_steps(F: Floats, seen: ArrayLike | None) -> NDArray[np.bool_]:
    if seen is None and F.ndim == 3:
        return np.ones(len(F) + 1, dtype=bool)
    steps = np.asarray(seen)
    if steps.ndim != 1 or steps.dtype != bool or not len(steps):
        raise ValueError(
            f"seen must be a bool array of shape (N,) if F has the shape (n, n), got {quoted(seen)}"
        )
    return steps


def _shaped(name: str, matrix: Floats, shape: tuple[int, ...]) -> Floats:
    """Return matrices of this shape; one may stand for all steps."""
    if matrix.shape not in (shape, shape[-2:]):
        raise ValueError(f"{name} must be of shape {shape}, got {matrix.shape}")
    return np.broadcast_to(matrix, shape)


def pose_bounds(trace: Trace, *, Q: ArrayLike, R: ArrayLike, P0: ArrayLike) -> Floats:
    """Return the posterior Cramér-Rao bound of the robot's pose along the true path of a run.

    Parameters
    ----------
    trace : Trace
        The run, without a bounce. If the run measured the pose, the bound uses the
        steps with a measurement; otherwise it uses all steps.
    Q : array (3, 3)
        Covariance of the process noise of the pose in each step; 0 for a run without process noise.
    R : array (3, 3)
        Covariance of the noise of a measured pose.
    P0 : array (3, 3) or (6, 6)
        Covariance of the first pose ahead of its measurement, for a robot at rest; or of the first
        pose together with the previous pose.

    Returns
    -------
    array (N, 3, 3)
        Minimum covariance of the pose in each step; ``sqrt`` of its diagonal is the minimum root
        mean square error. Draw it with ``robsim.plot_errors(report, bound=...)``.

    Raises
    ------
    TypeError, ValueError
        If the trace has no truth or has a bounce, or if the shapes do not match.

    Notes
    -----
    The state is (pose(k), pose(k-1)), and the model is `RobotModel` with the true parameters; see
    `posterior_cramer_rao_bound`. The model is nonlinear, so the bound holds only along this path.

    Examples
    --------
    >>> trace = robsim.Simulation(seed=1, control=robsim.DriveAround()).run(50)
    >>> Q, R, P0 = np.zeros((3, 3)), np.diag([1, 1, 0.01]), np.diag([100, 100, 1])
    >>> bounds = robsim.estimation.pose_bounds(trace, Q=Q, R=R, P0=P0)
    >>> np.sqrt(np.diagonal(bounds[[0, -1]], axis1=1, axis2=2)).round(2)
    array([[1.  , 1.  , 0.1 ],
           [0.28, 0.25, 0.01]])
    """
    _check_truth(trace)
    if trace.bounced[1:].any():
        step = int(trace.k[1:][trace.bounced[1:]][0])
        raise ValueError(
            f"trace must have no bounce, because the model has no walls, got a bounce at step "
            f'{step}: use a part, trace[a:b], or run with boundary="unlimited"'
        )
    start = as_float_array("P0", P0)
    if start.shape == (3, 3):
        start = np.tile(start, (2, 2))
    noise = np.zeros((6, 6))
    noise[:3, :3] = _shaped("Q", as_float_array("Q", Q), (3, 3))
    bounds = posterior_cramer_rao_bound(
        _model_derivatives(trace),
        np.eye(3, 6),
        Q=noise,
        R=R,
        P0=_shaped("P0", start, (6, 6)),
        seen=trace.seen if trace.is_tracked else None,
    )
    return bounds[:, :3, :3]


def _model_derivatives(trace: Trace) -> Floats:
    """Return the Jacobians of (pose(k), pose(k-1)) by (pose(k-1), pose(k-2)), k = 1..N-1."""
    model = RobotModel.from_theta(trace.info.theta_true, dt=trace.info.dt)
    pose_1 = trace.pose_true[:-1]
    # The robot stands still before the first step.
    pose_2 = np.vstack((trace.pose_true[:1], pose_1))[: len(pose_1)]
    F = np.zeros((len(pose_1), 6, 6))
    F[:, :3] = model.jacobian(pose_1, pose_2, trace.u[:-1])
    F[:, 3:, :3] = np.eye(3)
    return F


def _check_truth(trace: Trace) -> None:
    check_trace(trace)
    trace.require("pose_true", "theta_true")
    if not np.isfinite(trace.pose_true).all():
        raise ValueError("the trace must have a true pose in every step")
