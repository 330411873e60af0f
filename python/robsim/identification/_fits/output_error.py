"""Output error."""

from __future__ import annotations

from typing import Any

import numpy as np

from robsim._base.checks import Floats
from robsim.identification._fits.first_guess import first_guess
from robsim.identification._fits.linearisation import Linearisation, Unknowns
from robsim.identification._fits.model_fit import ModelFit, given
from robsim.identification._fits.paths import simulated_path
from robsim.identification._fits.segments import Record, Segment, as_record, split

_ITERATIONS = 30
_MINIMUM_POSES = 3
# The first guess bridges no longer gap: the robot might turn by more than half a turn in it.
_MAXIMUM_GAP = 5
_MINIMUM_SAMPLES = 8
# It has converged when the next step is shorter than this, all unknowns together (standard errors),
_TOLERANCE = 1e-2
# or at least those of the parameters that are given, one by one.
_SETTLED = 0.1
_DIVERGED = 1e100
_INITIAL_DAMPING = 1e-8
_DAMPING_FACTOR = 100.0
_MAXIMUM_DAMPING = 1e8


def output_error(poses: Any, u: Any, *, breaks: Any = None) -> ModelFit:
    """Fit the simulated path of the robot model to measured poses.

    The path depends on the inputs, the 15 parameters and the first two poses of each segment
    between breaks; all of them are fitted together, so that the measured places say something
    about the heading, too. The noise of the poses stays out of the regressors: there is no bias.

    Parameters
    ----------
    poses : array (N, 3)
        Measured x, y (work-area px), heading (rad), wrapped or not; NaN = not seen.
    u : array (N, 2)
        The inputs given at these steps (V), also where the robot was not seen.
    breaks : array (N,) of bool, optional
        Steps that do not follow from the one before, such as bounces.

    Returns
    -------
    ModelFit
        Parameters and standard errors.

    Raises
    ------
    TypeError, ValueError
        If an argument does not fit, or if there are too few poses.

    Notes
    -----
    Gauss-Newton with sensitivity filters, damped where it must be (Levenberg-Marquardt). From a
    poor start it stalls, so the first guess tries some poles, each of which makes the path linear
    in all else. x, y and heading are weighted with the noise that the last iteration left in them.
    Source: Ljung, System Identification, 2nd edition 1999, 4.3 (output error models), 10.2.
    """
    record = as_record(poses, u, breaks)
    segments = split(record, minimum=_MINIMUM_POSES)
    start = _start(record, segments)
    fit, residuals, iterations, converged = _minimise(start, segments)
    linear = Linearisation.at(fit, segments, residuals)
    theta, errors = given(fit.theta, linear.standard_errors())
    if not converged:
        # What the record does not determine may wander for ever; the rest may stand all the same.
        moved = np.abs(linear.step(fit, 0.0).theta - fit.theta)
        converged = not (moved > _SETTLED * errors)[np.isfinite(theta)].any()
    return ModelFit(
        theta=theta,
        standard_errors=errors,
        residual_rms=np.sqrt(np.square(residuals).mean(axis=0)),
        iterations=iterations,
        converged=converged,
    )


def _start(record: Record, segments: list[Segment]) -> Unknowns:
    """Return the first guess, and the first poses as measured."""
    pieces = split(record, maximum_gap=_MAXIMUM_GAP, minimum=_MINIMUM_POSES)
    samples = sum(int(piece.seen.sum()) - 2 for piece in pieces)
    if samples < _MINIMUM_SAMPLES:
        raise ValueError(
            f"output error needs at least {_MINIMUM_SAMPLES} poses more than two for each segment "
            f"between breaks, got {samples} in {len(segments)} segments"
        )
    first = np.array([segment.interpolated()[:2] for segment in segments])
    return Unknowns(first_guess(pieces), first)


def _residuals(unknowns: Unknowns, segments: list[Segment]) -> Floats | None:
    """Return measured minus simulated poses (n, 3), or None if the simulation explodes."""
    parts = []
    for first, segment in zip(unknowns.first, segments, strict=True):
        with np.errstate(over="ignore", invalid="ignore"):
            path = simulated_path(unknowns.theta, first, segment.u)
            left = (segment.poses - path)[segment.seen]
        if not (np.abs(left) < _DIVERGED).all():
            return None
        # In a gap the robot may turn by more than half a turn; the simulated heading knows.
        left[:, 2] = np.unwrap(left[:, 2])
        parts.append(left)
    return np.vstack(parts)


def _minimise(unknowns: Unknowns, segments: list[Segment]) -> tuple[Unknowns, Floats, int, bool]:
    """Return the unknowns of the least weighted squares, the residuals, iterations, converged."""
    residuals = _residuals(unknowns, segments)
    # The first guess has no unstable pole: its path does not explode.
    assert residuals is not None
    damping = _INITIAL_DAMPING
    for iteration in range(_ITERATIONS):
        linear = Linearisation.at(unknowns, segments, residuals)
        if linear.is_rounding or linear.expected_gain() < _TOLERANCE**2:
            return unknowns, residuals, iteration, True
        while damping <= _MAXIMUM_DAMPING:
            trial = linear.step(unknowns, damping)
            left = _residuals(trial, segments)
            if left is not None and linear.is_better(left):
                break
            damping *= _DAMPING_FACTOR
        else:
            return unknowns, residuals, iteration, False
        unknowns, residuals = trial, left
        damping = max(damping / _DAMPING_FACTOR, 1e-12)
    return unknowns, residuals, _ITERATIONS, False
