"""Parameter estimation by refined instrumental variables, made for measurement noise alone."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from robsim._core import regression, second_order_recursion
from robsim.base.checks import Floats
from robsim.estimation.identification.fits.coloured_noise import Noise, by_driving
from robsim.estimation.identification.fits.linear import axis_with_pole, initial_estimate, solve
from robsim.estimation.identification.fits.model_fit import (
    ModelFit,
    with_noise,
    with_undetermined,
)
from robsim.estimation.identification.fits.output_error import Fits
from robsim.estimation.identification.fits.segments import Segment, as_record, split
from robsim.estimation.identification.fits.unknowns import HEADING, X, Y
from robsim.trace.timing import check_delay

_ITERATIONS = 30
# An axis has converged when no parameter changes by more than this fraction of its standard error.
_TOLERANCE = 1e-3
_ROUNDING = 1e-10
_MAXIMUM_POLE = 0.999
# A run of n consecutive poses gives n - 4 degrees of freedom.
_MINIMUM_POSES = 5
_MINIMUM_SAMPLES = 8


def instrumental_variables(
    poses: ArrayLike,
    u: ArrayLike,
    *,
    breaks: ArrayLike | None = None,
    motor_delay: float = 0.0,
) -> ModelFit:
    """Estimate the parameters of the robot model from measured poses by instruments.

    Least squares is biased by the noise in its regressors. Here the instrument of each regressor is
    the same quantity, simulated from the inputs with the current estimate. This instrument is
    uncorrelated with the noise. Samples and instruments are filtered so that the noise becomes
    white, and the estimation is iterated. The fit uses the constraint a1 + a2 = 1, which holds for
    every robot. Without this constraint, a parameter could fit noise, such as a drift of the
    measured path. Gaps cost samples, since only consecutive poses are used; `output_error` bridges
    them.

    With measurement noise alone there is asymptotically no bias. Process noise increases the errors
    of the estimate. The residuals of `output_error` show the process noise, and the standard errors
    include it. If process noise dominates, least squares is the better method.

    Parameters
    ----------
    poses : array (N, 3)
        Measured x, y (work-area px), heading (rad), wrapped or not; NaN = not seen.
    u : array (N, 2)
        The inputs given at these steps (V).
    breaks : array (N,) of bool, optional
        Steps that do not follow from the previous one, such as bounces.
    motor_delay : float
        Delay of the inputs (steps), 0..1000; inputs ahead of the first are 0. `output_error` can
        also estimate it.

    Returns
    -------
    ModelFit
        Parameters and standard errors; `residual_rms` refers to the filtered samples.

    Raises
    ------
    TypeError, ValueError
        If an argument has the wrong type or shape, or if there are too few consecutive poses.

    Notes
    -----
    Source: Young and Jakeman, Refined instrumental variable methods of recursive time-series
    analysis, part I, Int. J. Control 29(1), 1979. The transient from the noise of a run's first two
    poses does not decay in the filter 1/A, which has a pole at 1; it is projected out.

    Examples
    --------
    >>> noise, control = robsim.GaussianNoise(10), robsim.control.PseudoRandomBinary()
    >>> trace = robsim.Simulation(seed=1, control=control, measure=True, noise=noise).run(300)
    >>> fit = robsim.estimation.instrumental_variables(trace.pose_measured, trace.u)
    >>> fit.theta[:, 0].round(1)
    array([1.9, 1.9, 1.8])
    """
    delay = check_delay("motor_delay", motor_delay)
    record = as_record(poses, u, breaks).with_delay(delay)
    runs = split(record, maximum_gap=0, minimum=_MINIMUM_POSES)
    n_samples = sum(len(run.u) - 4 for run in runs)
    if n_samples < _MINIMUM_SAMPLES:
        raise ValueError(
            f"instrumental variables need at least {_MINIMUM_SAMPLES} samples, got {n_samples}: "
            "a sequence of n poses without a gap gives n - 4 samples"
        )
    fits = _fit_axes(runs)
    theta, errors = with_undetermined(
        np.array([fit.theta for fit in fits]), np.array([fit.errors for fit in fits])
    )
    fit = ModelFit(
        theta=theta,
        standard_errors=errors,
        residual_rms=np.array([fit.rms for fit in fits]),
        iterations=max(fit.iterations for fit in fits),
        # An axis without a determined parameter may drift.
        converged=all(
            fit.converged or not np.isfinite(row).any()
            for fit, row in zip(fits, theta, strict=True)
        ),
        motor_delay=delay,
    )
    noise = Fits(record).solve(0.0).noise
    if noise.is_white:
        return with_noise(fit, noise)
    return with_noise(fit, noise, np.array([_errors_under(noise, runs, fits, a) for a in range(3)]))


def _errors_under(noise: Noise, runs: list[Segment], fits: list[_AxisFit], axis: int) -> Floats:
    """Return the standard errors (5,) of an axis under a noise."""
    samples = [_run_samples(run, axis) for run in runs]
    simulated = axis_with_pole(runs, axis, _pole(fits[axis].theta))
    return _refine(samples, simulated, noise.white[HEADING], noise, axis).errors


@dataclass(frozen=True, eq=False)
class _Samples:
    """Samples of one axis in a run: y = phi (a2, b1, b2, d1), with a1 = 1 - a2."""

    first: Floats  # (2,): the first two values of the axis
    phi: Floats  # (n, 4): regressors: x(k-2) - x(k-1), and those of b1, b2 and d1
    y: Floats  # (n,): outputs x(k) - x(k-1)
    slope: Floats  # (n, 3): derivatives of the last three regressors by the heading


@dataclass(frozen=True, kw_only=True, eq=False)
class _AxisFit:
    """Parameters (5,) and standard errors (5,) of an axis, and the rms residual."""

    theta: Floats
    errors: Floats
    rms: float
    iterations: int = 0
    converged: bool = False


def _fit_axes(runs: list[Segment]) -> list[_AxisFit]:
    """Return the fits of X, Y and P; the residuals of P give the noise of the heading."""
    start = initial_estimate(runs)
    turn = _iterate(runs, HEADING, start[HEADING], 0.0)
    return [*(_iterate(runs, axis, start[axis], turn.rms) for axis in (X, Y)), turn]


def _run_samples(run: Segment, axis: int) -> _Samples:
    all_phi, all_y = regression(run.poses, run.u)
    # d(u cos)/d heading = -u sin,  d(u sin)/d heading = u cos
    slopes = [-all_phi[:, Y, 2:], all_phi[:, X, 2:], np.zeros_like(all_phi[:, HEADING, 2:])]
    phi = all_phi[:, axis]
    # x(k) - x(k-1) = a2 (x(k-2) - x(k-1)) + forces
    difference = phi[:, 1] - phi[:, 0]
    return _Samples(
        run.poses[:2, axis],
        np.column_stack([difference, phi[:, 2:]]),
        all_y[:, axis] - phi[:, 0],
        slopes[axis],
    )


def _iterate(runs: list[Segment], axis: int, theta: Floats, heading_sigma: float) -> _AxisFit:
    samples = [_run_samples(run, axis) for run in runs]
    for iteration in range(1, _ITERATIONS + 1):
        simulated = axis_with_pole(runs, axis, _pole(theta))
        fit = _refine(samples, simulated, heading_sigma)
        # The standard error of an undetermined parameter is NaN, for which this is False.
        has_changed = np.abs(fit.theta - theta) > _TOLERANCE * fit.errors + _ROUNDING
        theta = fit.theta
        if not has_changed.any():
            return replace(fit, iterations=iteration, converged=True)
    return replace(fit, iterations=_ITERATIONS)


def _pole(theta: Floats) -> float:
    """Return the pole of an axis: every robot has one pole at 1 and the other at -a2."""
    return min(max(-float(theta[1]), 0.0), _MAXIMUM_POLE)


def _refine(
    runs: list[_Samples],
    simulated: Floats,
    heading_sigma: float,
    noise: Noise | None = None,
    axis: int = X,
) -> _AxisFit:
    """Return the next estimate of an axis, with instruments from the simulated parameters.

    Without `noise` (of all axes) the residuals give a white measurement noise.
    """
    columns = np.vstack([_whitened(run, simulated) for run in runs])
    instruments, phi, y = columns[:, :4], columns[:, 4:8], columns[:, 8]
    # Z' Phi theta = Z' y with the instruments Z = Q R: Q' Phi theta = Q' y
    Q = _orthonormal(instruments)
    estimate, covariance = solve(Q.T @ phi, Q.T @ y)
    freedom = max(len(y) - 2 * len(runs) - 4, 1)
    rms = np.sqrt(np.sum(np.square(y - phi @ estimate)) / freedom)
    sigma = rms if noise is None else noise.white[axis]
    # The noise n of the headings rotates the forces, and process noise w adds to them:
    # Q' Phi (estimate - theta) = Q' (e + H n + G w). H filters slope (b1, b2, d1) n by 1/A, and G
    # filters w, so that H' Q and G' Q filter backwards.
    a1, a2 = simulated[:2]
    parts = np.split(Q, _ends(runs))
    backwards = [second_order_recursion(a1, a2, part[::-1])[::-1] for part in parts]
    forces = np.hstack([run.slope @ estimate[1:] for run in runs])
    by_heading = forces[:, None] * np.vstack(backwards)
    by_step = [heading_sigma * by_heading]
    if noise is not None:
        by_step.append(noise.process[axis] * np.vstack(backwards))
        turns = np.split(by_heading, _ends(runs))
        by_step += [_by_colour(part, noise, axis) for part in parts]
        by_step += [_by_colour(part, noise, HEADING) for part in turns]
    spread, _ = solve(Q.T @ phi, np.vstack(by_step).T)
    errors = np.sqrt(sigma**2 * np.diag(covariance) + np.square(spread).sum(axis=1))
    return _AxisFit(
        theta=np.hstack([1 - estimate[0], estimate]),
        errors=np.hstack([errors[0], errors]),
        rms=float(rms),
    )


def _by_colour(weights: Floats, noise: Noise, axis: int) -> Floats:
    """Return the effect (n, m) of the coloured errors of an axis, with weights (n, m) in a run."""
    if not noise.correlation[axis]:
        return np.zeros_like(weights[:0])
    effect = by_driving(weights[:, np.newaxis], noise.correlation[[axis]])
    return np.asarray(noise.driving[axis] * effect[:, 0])


def _ends(runs: list[_Samples]) -> list[int]:
    return [int(end) for end in np.cumsum([len(run.y) for run in runs])[:-1]]


def _whitened(run: _Samples, simulated: Floats) -> Floats:
    """Return instruments, regressors and outputs of a run (n, 9), filtered by 1/A."""
    a1, a2 = simulated[:2]
    # The path simulated from the inputs and the first two poses.
    start = run.first[0], run.first[1] - a1 * run.first[0]
    path = second_order_recursion(a1, a2, np.hstack([start, run.phi[:, 1:] @ simulated[2:]]))
    instruments = np.column_stack([path[:-2] - path[1:-1], run.phi[:, 1:]])
    # 1/A turns the noise e(k) - a1 e(k-1) - a2 e(k-2) of a sample into e(k), plus a transient
    # from the first two poses.
    columns = second_order_recursion(a1, a2, np.column_stack([instruments, run.phi, run.y]))
    transient, _ = np.linalg.qr(second_order_recursion(a1, a2, np.eye(len(run.y), 2)))
    return columns - transient @ (transient.T @ columns)


def _orthonormal(columns: Floats) -> Floats:
    """Return an orthonormal basis (N, 4) of columns whose lengths may differ widely."""
    length = np.linalg.norm(columns, axis=0)
    length[length == 0] = 1
    return np.linalg.qr(columns / length)[0]
