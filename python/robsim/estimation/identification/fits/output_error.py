"""Parameter estimation by the output-error method, unbiased by measurement noise."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from robsim._core import simulated_path
from robsim.base.checks import Floats
from robsim.estimation.identification.fits.delay_fit import check_delay_or_fit, fit_delay
from robsim.estimation.identification.fits.initial_estimate import initial_estimate
from robsim.estimation.identification.fits.linearisation import Linearisation, Unknowns
from robsim.estimation.identification.fits.model_fit import ModelFit, with_undetermined
from robsim.estimation.identification.fits.segments import Record, Segment, as_record, split

_ITERATIONS = 30
_MINIMUM_POSES = 3
# The initial estimate bridges no longer gap: the robot might turn by more than 180 degrees in it.
_MAXIMUM_GAP = 5
_MINIMUM_SAMPLES = 8
# Converged: the next step of all unknowns together is shorter than this (standard errors),
_TOLERANCE = 1e-2
# or at least that of each determined parameter is shorter than this.
_SETTLED = 0.1
_DIVERGED = 1e100
_INITIAL_DAMPING = 1e-8
_DAMPING_FACTOR = 100.0
_MAXIMUM_DAMPING = 1e8


def output_error(
    poses: ArrayLike,
    u: ArrayLike,
    *,
    breaks: ArrayLike | None = None,
    input_delay: float | str = 0.0,
) -> ModelFit:
    """Fit the simulated path of the robot model to measured poses.

    The path depends on the inputs, the 15 parameters and the first two poses of each segment
    between breaks; all of them are fitted together, so that the measured positions also inform the
    heading. There is no bias, since the noise of the poses is not in the regressors.

    Parameters
    ----------
    poses : array (N, 3)
        Measured x, y (work-area px), heading (rad), wrapped or not; NaN = not seen.
    u : array (N, 2)
        The inputs given at these steps (V), also where the robot was not seen.
    breaks : array (N,) of bool, optional
        Steps that do not follow from the previous one, such as bounces.
    input_delay : float or str
        How late the inputs act (steps), 0..1000; before the first they were 0. ``"fit"``: it is
        estimated, too, within 0..10 steps.

    Returns
    -------
    ModelFit
        Parameters and standard errors.

    Raises
    ------
    TypeError, ValueError
        If an argument has the wrong type or shape, or if there are too few poses.

    Notes
    -----
    Gauss-Newton with sensitivity filters, damped where necessary (Levenberg-Marquardt). From a
    poor initial estimate it stalls, so that one is searched over a grid of poles, for each of which
    the path is linear in the other unknowns. x, y and heading are weighted by the residuals of the
    last iteration. Source: Ljung, System Identification, 2nd edition 1999, 4.3 (output error
    models), 10.2.

    An estimated delay is that of the maximum likelihood, for normal errors of the poses: of all
    delays the one for which the parameters fit best. The standard errors of the parameters then
    include what the uncertainty of the delay adds to them.
    """
    delay = check_delay_or_fit(input_delay)
    record = as_record(poses, u, breaks)
    return fit_delay(record, _fit) if delay is None else _fit(record, delay)


def _fit(record: Record, delay: float) -> ModelFit:
    """Return the fit for a known delay of the inputs (steps)."""
    record = record.with_delay(delay)
    segments = split(record, minimum=_MINIMUM_POSES)
    start = _start(record, segments)
    fit, residuals, iterations, converged = _minimise(start, segments)
    linear = Linearisation.at(fit, segments, residuals)
    theta, errors = with_undetermined(fit.theta, linear.standard_errors())
    if not converged:
        # Undetermined parameters may drift for ever while the others have converged.
        change = np.abs(linear.step(fit, 0.0).theta - fit.theta)
        converged = not (change > _SETTLED * errors)[np.isfinite(theta)].any()
    return ModelFit(
        theta=theta,
        standard_errors=errors,
        residual_rms=np.sqrt(np.square(residuals).mean(axis=0)),
        iterations=iterations,
        converged=converged,
        input_delay=delay,
    )


def _start(record: Record, segments: list[Segment]) -> Unknowns:
    """Return the initial estimate of the parameters, and the first poses as measured."""
    pieces = split(record, maximum_gap=_MAXIMUM_GAP, minimum=_MINIMUM_POSES)
    n_samples = sum(int(piece.seen.sum()) - 2 for piece in pieces)
    if n_samples < _MINIMUM_SAMPLES:
        raise ValueError(
            f"output error needs at least {_MINIMUM_SAMPLES} poses in addition to two per segment "
            f"between breaks, got {n_samples} in {len(segments)} segments"
        )
    first = np.array([segment.interpolated()[:2] for segment in segments])
    return Unknowns(initial_estimate(pieces), first)


def _residuals(unknowns: Unknowns, segments: list[Segment]) -> Floats | None:
    """Return measured minus simulated poses (n, 3), or None if the simulation diverges."""
    parts = []
    for first, segment in zip(unknowns.first, segments, strict=True):
        path = simulated_path(unknowns.theta, first, segment.u)
        residuals = (segment.poses - path)[segment.seen]
        if not (np.abs(residuals) < _DIVERGED).all():
            return None
        # In a gap the robot may turn by more than 180 degrees; the simulated heading includes it.
        residuals[:, 2] = np.unwrap(residuals[:, 2])
        parts.append(residuals)
    return np.vstack(parts)


def _minimise(unknowns: Unknowns, segments: list[Segment]) -> tuple[Unknowns, Floats, int, bool]:
    """Minimise the cost: return the unknowns, the residuals, the iterations, and converged."""
    residuals = _residuals(unknowns, segments)
    # The initial estimate has no unstable pole: its path does not diverge.
    assert residuals is not None
    damping = _INITIAL_DAMPING
    for iteration in range(_ITERATIONS):
        linear = Linearisation.at(unknowns, segments, residuals)
        if linear.is_rounding or linear.expected_decrease() < _TOLERANCE**2:
            return unknowns, residuals, iteration, True
        while damping <= _MAXIMUM_DAMPING:
            trial = linear.step(unknowns, damping)
            trial_residuals = _residuals(trial, segments)
            if trial_residuals is not None and linear.is_better(trial_residuals):
                break
            damping *= _DAMPING_FACTOR
        else:
            return unknowns, residuals, iteration, False
        unknowns, residuals = trial, trial_residuals
        damping = max(damping / _DAMPING_FACTOR, 1e-12)
    return unknowns, residuals, _ITERATIONS, False
