"""The output-error method, made for measurement noise alone, and its linearisation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from robsim._core import path_sensitivities, simulated_path
from robsim.base.checks import Floats
from robsim.estimation.identification.fits.coloured_noise import (
    NO_NOISE,
    Noise,
    Track,
    errors_under,
    estimated_noise,
)
from robsim.estimation.identification.fits.linear import (
    costs_of_poles,
    initial_estimate,
    solve,
    triangle,
)
from robsim.estimation.identification.fits.model_fit import (
    DIFFERENCE,
    ModelFit,
    check_delay_or_fit,
    fit_delay,
    with_noise,
    with_undetermined,
)
from robsim.estimation.identification.fits.segments import Record, Segment, as_record, split
from robsim.estimation.identification.fits.unknowns import FIRST, UNKNOWNS

# Residuals smaller than this fraction of the maximum coordinate are rounding errors.
_ROUNDING = 1e-9


@dataclass(frozen=True, eq=False)
class Unknowns:
    """The parameters theta (3, 5) and the first two poses (S, 2, 3) of each segment."""

    theta: Floats
    first: Floats


@dataclass(frozen=True, eq=False)
class Linearisation:
    """The weighted residuals, linearised in a step of the unknowns."""

    # (3,): standard deviations of x, y and heading, which the residuals are divided by
    sigma: Floats
    cost: float  # sum of squares of the weighted residuals
    # (S, 22, 22): for each segment the triangular factor of [derivatives | residuals], whose
    # columns are for the 6 initial values, the 15 parameters, and the residuals
    blocks: Floats

    @staticmethod
    def at(unknowns: Unknowns, segments: list[Segment], residuals: Floats) -> Linearisation:
        """Linearise about the unknowns, which have these residuals."""
        freedom = max(len(residuals) - 2 * len(segments) - 5, 1)
        sigma = np.sqrt(np.square(residuals).sum(axis=0) / freedom)
        sizes = [np.nanmax(np.abs(segment.poses), axis=0) for segment in segments]
        sigma = np.maximum(sigma, _ROUNDING * np.maximum(np.max(sizes, axis=0), 1.0))
        blocks = np.zeros((len(segments), UNKNOWNS + 1, UNKNOWNS + 1))
        edges = np.cumsum([0, *(segment.seen.sum() for segment in segments)])
        for i, segment in enumerate(segments):
            path = simulated_path(unknowns.theta, unknowns.first[i], segment.u)
            slopes = path_sensitivities(unknowns.theta, path, segment.u)[segment.seen]
            columns = np.dstack([slopes, residuals[edges[i] : edges[i + 1]]]) / sigma[:, None]
            factor = triangle(columns.reshape(-1, UNKNOWNS + 1))
            blocks[i, : len(factor)] = factor
        return Linearisation(sigma, float(np.square(residuals / sigma).sum()), blocks)

    @property
    def is_rounding(self) -> bool:
        """Whether the residuals are far below the minimum noise, and so only rounding errors."""
        return self.cost < 1

    def is_better(self, residuals: Floats) -> bool:
        return bool(np.square(residuals / self.sigma).sum() < self.cost)

    def eliminated(self, damping: float = 0.0) -> tuple[Floats, Floats, Floats]:
        """Eliminate the initial values: return the parameters' derivatives, residuals, factors."""
        lengths = np.linalg.norm(self.blocks[:, :, :FIRST], axis=1)
        damper = np.zeros((len(self.blocks), FIRST, UNKNOWNS + 1))
        damper[:, range(FIRST), range(FIRST)] = np.sqrt(damping) * lengths
        factors = triangle(np.concatenate([self.blocks, damper], axis=1))
        reduced = factors[:, FIRST:, FIRST:].reshape(-1, UNKNOWNS - FIRST + 1)
        return reduced[:, :-1], reduced[:, -1], factors

    def standard_errors(self) -> Floats:
        """Return the standard errors of the parameters (3, 5), NaN where not determined."""
        slopes, residuals, _ = self.eliminated()
        # sigma^2 (J' J)^-1; the slopes are divided by sigma
        _, covariance = solve(slopes, residuals)
        return np.sqrt(np.diag(covariance)).reshape(3, 5)

    def expected_decrease(self) -> float:
        """Return the decrease of the cost by an undamped step, in the linear approximation."""
        slopes, residuals, factors = self.eliminated()
        remaining = residuals - slopes @ solve(slopes, residuals)[0]
        by_first = np.square(factors[:, :FIRST, -1]).sum()
        return float(by_first + np.square(residuals).sum() - np.square(remaining).sum())

    def step(self, unknowns: Unknowns, damping: float) -> Unknowns:
        """Return the unknowns after a damped step."""
        slopes, residuals, factors = self.eliminated(damping)
        lengths = np.linalg.norm(slopes, axis=0)
        damper = np.diag(np.sqrt(damping) * lengths)
        step, _ = solve(np.vstack([slopes, damper]), np.hstack([residuals, np.zeros(len(lengths))]))
        # The first rows of each factor: R first + S step = r
        right = factors[:, :FIRST, -1] - factors[:, :FIRST, FIRST:-1] @ step
        first = np.array(
            [solve(factor[:FIRST, :FIRST], r)[0] for factor, r in zip(factors, right, strict=True)]
        )
        return Unknowns(
            unknowns.theta + step.reshape(3, 5),
            unknowns.first + first.reshape(-1, 3, 2).swapaxes(1, 2),
        )


_ITERATIONS = 30
_MINIMUM_POSES = 3
# The initial estimate bridges no longer gap: the robot might turn by more than 180 degrees in it.
_MAXIMUM_GAP = 5
_MINIMUM_SAMPLES = 8
# Converged: the next step of all unknowns together is shorter than this (standard errors),
_TOLERANCE = 1e-2
# or at least that of each determined parameter is shorter than this.
_SETTLED = 0.1
_FINE = 1e-2  # of _TOLERANCE, in the search for a delay
_DELAY_STEP = 1e-6  # steps, of a derivative to one side
_DIVERGED = 1e100
_TINY = float(np.finfo(float).tiny)
_INITIAL_DAMPING = 1e-8
_DAMPING_FACTOR = 100.0
_MAXIMUM_DAMPING = 1e8


def output_error(
    poses: ArrayLike,
    u: ArrayLike,
    *,
    breaks: ArrayLike | None = None,
    motor_delay: float | str = 0.0,
) -> ModelFit:
    """Fit the simulated path of the robot model to measured poses.

    The path depends on the inputs, the 15 parameters and the first two poses of each segment
    between breaks. Parameters and poses are fitted together, so that the measured positions also
    determine the heading. The noise of the poses is not in the regressors: with measurement noise
    alone the estimate has asymptotically no bias and the minimum variance. Process noise moves all
    later poses of the path, which increases the errors of the estimate. The residuals show the
    process noise, and the standard errors include it. If process noise dominates, least squares is
    the better method.

    Parameters
    ----------
    poses : array (N, 3)
        Measured x, y (work-area px), heading (rad), wrapped or not; NaN = not seen.
    u : array (N, 2)
        The inputs given at these steps (V), also if the robot was not seen.
    breaks : array (N,) of bool, optional
        Steps that do not follow from the previous one, such as bounces.
    motor_delay : float or str
        Delay of the inputs (steps), 0..1000; inputs ahead of the first are 0. ``"fit"``: estimate
        it, too, within 0..10 steps.

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
    The method is Gauss-Newton with sensitivity filters, damped if necessary (Levenberg-Marquardt).
    From a poor initial estimate it stalls, so the initial estimate comes from a grid of poles: for
    each pole the path is linear in the other unknowns. x, y and heading are weighted by the
    residuals of the last iteration. Source: Ljung, System Identification, 2nd edition 1999, 4.3
    (output error models), 10.2.

    An estimated delay maximises the likelihood for normally distributed errors of the poses: the
    parameters fit best with this delay. The standard errors of the parameters then include the
    uncertainty of the delay.

    The variances of process noise and measurement noise maximise the restricted likelihood of the
    residuals. Source: Patterson and Thompson, Recovery of inter-block information when block sizes
    are unequal, Biometrika 58(3), 1971. The likelihood ratio is the test statistic for process
    noise. Source of its distribution at variances of 0: Self and Liang, Asymptotic properties of
    maximum likelihood estimators and likelihood ratio tests under nonstandard conditions, JASA
    82(398), 1987. A correlation of neighbouring errors of the poses replaces process noise if the
    correlation is more likely.

    Examples
    --------
    >>> noise, control = robsim.GaussianNoise(10), robsim.control.PseudoRandomBinary()
    >>> trace = robsim.Simulation(seed=1, control=control, measure=True, noise=noise).run(300)
    >>> fit = robsim.estimation.output_error(trace.pose_measured, trace.u)
    >>> fit.theta[:, 0].round(1), fit.converged
    (array([1.9, 1.9, 1.8]), True)
    """
    delay = check_delay_or_fit(motor_delay)
    record = as_record(poses, u, breaks)
    fits = Fits(record)
    if delay is not None:
        solution = fits.solve(delay)
        return fits.tested(solution.fit, solution)
    return fits.tested(*fit_delay(record, fits))


@dataclass(frozen=True, eq=False)
class Solution:
    """The best unknowns for a delay of the inputs (steps)."""

    delay: float
    segments: list[Segment]
    unknowns: Unknowns
    residuals: Floats
    iterations: int
    converged: bool

    @property
    def cost(self) -> float:
        """-2 log likelihood / n for normal errors, but for a constant."""
        return _log_sum(np.square(self.residuals).sum(axis=0))

    @cached_property
    def linear(self) -> Linearisation:
        """The linearisation about the unknowns."""
        return Linearisation.at(self.unknowns, self.segments, self.residuals)

    @cached_property
    def fit(self) -> ModelFit:
        """The parameters, with standard errors for white measurement noise."""
        linear, unknowns = self.linear, self.unknowns
        theta, errors = with_undetermined(unknowns.theta, linear.standard_errors())
        converged = self.converged
        if not converged:
            # Undetermined parameters may keep drifting while the others have converged.
            change = np.abs(linear.step(unknowns, 0.0).theta - unknowns.theta)
            converged = not (change > _SETTLED * errors)[np.isfinite(theta)].any()
        return ModelFit(
            theta=theta,
            standard_errors=errors,
            residual_rms=np.sqrt(np.square(self.residuals).mean(axis=0)),
            iterations=self.iterations,
            converged=converged,
            motor_delay=self.delay,
        )

    @cached_property
    def tracks(self) -> list[Track]:
        """The segments and the paths simulated for them."""
        theta = self.unknowns.theta
        paths = _paths(self.unknowns, self.segments)
        return [
            Track(segment, path, path_sensitivities(theta, path, segment.u))
            for segment, path in zip(self.segments, paths, strict=True)
        ]

    @property
    def noise(self) -> Noise:
        """The noise that the residuals show."""
        if self.linear.is_rounding:
            return NO_NOISE
        return estimated_noise(self.unknowns.theta, self.tracks)


@dataclass(frozen=True, eq=False)
class Fits:
    """The solutions of a record, for any delay of its inputs (steps)."""

    record: Record

    def rough_cost(self, delay: float) -> float:
        """Return the cost of the initial estimate, for normal errors."""
        return _log_sum(costs_of_poles(_pieces(self.record.with_delay(delay))).min(axis=0))

    def solve(self, delay: float, known: Sequence[Solution] = ()) -> Solution:
        """Return the solution for a delay, starting from up to two solutions for other delays."""
        record = self.record.with_delay(delay)
        segments = split(record, minimum=_MINIMUM_POSES)
        tolerance = _TOLERANCE * (_FINE if len(known) > 1 else 1.0)
        found = []
        if known and _residuals(start := _between(delay, known), segments) is not None:
            found.append(Solution(delay, segments, *_minimise(start, segments, tolerance)))
        if not found or not found[0].converged:
            start = _start(record, segments)
            found.append(Solution(delay, segments, *_minimise(start, segments, tolerance)))
        return min(found, key=lambda one: one.cost)

    def slope(self, solution: Solution, side: int) -> float:
        """Return the derivative of the cost by the delay, to one side."""
        ends = sorted((solution.delay, solution.delay + side * _DELAY_STEP))
        slopes = self._path_slopes(solution, *ends)
        parts = zip(solution.segments, slopes, strict=True)
        by_delay = np.vstack([slope[segment.seen] for segment, slope in parts])
        # The best parameters move with the delay, but this changes no cost in the first order.
        change = -2 * (solution.residuals * by_delay).sum(axis=0)
        squares = np.square(solution.residuals).sum(axis=0)
        return float((change / np.maximum(squares, _TINY)).sum())

    def tested(self, fit: ModelFit, solution: Solution) -> ModelFit:
        """Return the fit with the noise of its residuals, and with standard errors under it."""
        noise = solution.noise
        if noise.is_white:
            return with_noise(fit, noise)
        tracks = solution.tracks
        # Infinite: the delay is not determined.
        has_delay = 0 < fit.motor_delay_error < np.inf
        if has_delay:
            ends = max(fit.motor_delay - DIFFERENCE, 0.0), fit.motor_delay + DIFFERENCE
            tracks = [
                replace(track, slopes=np.dstack([track.slopes, slope]))
                for track, slope in zip(tracks, self._path_slopes(solution, *ends), strict=True)
            ]
        errors = errors_under(noise, solution.unknowns.theta, tracks, solution.linear.sigma)
        if has_delay:
            fit = replace(fit, motor_delay_error=float(errors[-1]))
        return with_noise(fit, noise, errors[:15].reshape(3, 5))

    def _path_slopes(self, solution: Solution, before: float, after: float) -> list[Floats]:
        """Return the derivatives (n, 3) of the segments' paths by the delay, between two delays."""
        early, late = (
            _paths(solution.unknowns, split(self.record.with_delay(delay), minimum=_MINIMUM_POSES))
            for delay in (before, after)
        )
        return [(b - a) / (after - before) for a, b in zip(early, late, strict=True)]


def _between(delay: float, known: Sequence[Solution]) -> Unknowns:
    """Return the unknowns on the line through those of other delays."""
    a, b = known[0], known[-1]
    share = (delay - a.delay) / (b.delay - a.delay) if len(known) > 1 else 0.0
    theta = a.unknowns.theta + share * (b.unknowns.theta - a.unknowns.theta)
    return Unknowns(theta, a.unknowns.first + share * (b.unknowns.first - a.unknowns.first))


def _log_sum(squares: Floats) -> float:
    return float(np.log(np.maximum(squares, _TINY)).sum())


def _pieces(record: Record) -> list[Segment]:
    """Return the segments without a longer gap; ValueError if they have too few poses."""
    pieces = split(record, maximum_gap=_MAXIMUM_GAP, minimum=_MINIMUM_POSES)
    n_samples = sum(int(piece.seen.sum()) - 2 for piece in pieces)
    if n_samples < _MINIMUM_SAMPLES:
        segments = split(record, minimum=_MINIMUM_POSES)
        raise ValueError(
            f"output error needs at least {_MINIMUM_SAMPLES} poses beyond the first two of each "
            f"segment between breaks, got {n_samples} in {len(segments)} segments"
        )
    return pieces


def _start(record: Record, segments: list[Segment]) -> Unknowns:
    """Return the initial estimate of the parameters, and the first poses as measured."""
    pieces = _pieces(record)
    first = np.array([segment.interpolated()[:2] for segment in segments])
    return Unknowns(initial_estimate(pieces), first)


def _paths(unknowns: Unknowns, segments: list[Segment]) -> list[Floats]:
    """Return the simulated path (n, 3) of each segment."""
    return [
        simulated_path(unknowns.theta, first, segment.u)
        for first, segment in zip(unknowns.first, segments, strict=True)
    ]


def _residuals(unknowns: Unknowns, segments: list[Segment]) -> Floats | None:
    """Return measured minus simulated poses (n, 3), or None if the simulation diverges."""
    parts = []
    for segment, path in zip(segments, _paths(unknowns, segments), strict=True):
        residuals = (segment.poses - path)[segment.seen]
        if not (np.abs(residuals) < _DIVERGED).all():
            return None
        # In a gap the robot may turn by more than 180 degrees; the simulated heading includes it.
        residuals[:, 2] = np.unwrap(residuals[:, 2])
        parts.append(residuals)
    return np.vstack(parts)


def _minimise(
    unknowns: Unknowns, segments: list[Segment], tolerance: float
) -> tuple[Unknowns, Floats, int, bool]:
    """Minimise the cost: return the unknowns, the residuals, the iterations, and converged."""
    residuals = _residuals(unknowns, segments)
    # The initial estimate has no unstable pole: its path does not diverge.
    assert residuals is not None
    damping = _INITIAL_DAMPING
    for iteration in range(_ITERATIONS):
        linear = Linearisation.at(unknowns, segments, residuals)
        if linear.is_rounding or linear.expected_decrease() < tolerance**2:
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
