"""Coloured noise: found in the residuals of a simulated path, and carried to the standard errors.

The residuals of an axis are a sum of white noise e, and of z, driven by w:

    residual(k) = z(k) + e(k),  z(k) = a1 z(k-1) + a2 z(k-2) + w(k)

Process noise w passes through the model of the axis: its a1 and a2. Measured poses with similar
neighbouring errors have a1 = their correlation, a2 = 0, and these do not move the robot.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robsim._core import path_sensitivities, second_order_recursion
from robsim.base.checks import Floats
from robsim.estimation.identification._parameter_table import LEVEL
from robsim.estimation.identification.fits.linear import decompose, triangle
from robsim.estimation.identification.fits.segments import Segment
from robsim.estimation.identification.fits.unknowns import FIRST, HEADING, X, Y

# The logarithms of the ratios of the variances of w and e that are searched; the first one is 0.
_LOG_RATIOS = np.linspace(-24.0, 8.0, 9)
_TOLERANCE = 0.05
# The longest segments with so many steps together give the noise: each costs unknowns, thus time.
_ENOUGH = 3000
# Correlations of the errors of measured poses. They have one more number than process noise, and
# so must be more likely by a margin of -2 log likelihood.
_CORRELATIONS = (0.5, 0.7, 0.85, 0.95)
_MARGIN = 2.0
# The weights of chi2(1), chi2(2), chi2(3) in the sum of three likelihood ratios, each of them of a
# variance that cannot be below 0.
_WEIGHTS = (3 / 8, 3 / 8, 1 / 8)


@dataclass(frozen=True, kw_only=True, eq=False)
class Noise:
    """Standard deviations (3,) of the noise of x, y (px) and heading (rad) in a step."""

    driving: Floats  # of w
    white: Floats  # of e
    # Of neighbouring errors of measured poses; 0 where w is process noise
    correlation: Floats
    p_value: float  # probability of residuals as far from white without process noise

    @property
    def is_white(self) -> bool:
        return not self.p_value < LEVEL

    @property
    def process(self) -> Floats:
        """Standard deviations of the process noise, (3,)."""
        return np.where(self.correlation > 0, 0.0, self.driving)

    @property
    def measurement(self) -> Floats:
        """Standard deviations of the errors of measured poses, (3,)."""
        spread = self.driving / np.sqrt(1 - np.square(self.correlation))
        return np.asarray(np.hypot(self.white, np.where(self.correlation > 0, spread, 0.0)))


NO_NOISE, _UNKNOWN = (
    Noise(driving=np.full(3, sigma), white=np.full(3, sigma), correlation=np.zeros(3), p_value=p)
    for sigma, p in ((0.0, 1.0), (np.nan, np.nan))
)


@dataclass(frozen=True, eq=False)
class Track:
    """A segment and its simulated path, (n, 3)."""

    segment: Segment
    path: Floats
    slopes: Floats  # (n, 3, 21 or more): derivatives of the path by the unknowns

    @property
    def residuals(self) -> Floats:
        """Measured minus simulated poses (n, 3); 0 = not seen."""
        seen = self.segment.seen
        residuals = np.where(seen[:, np.newaxis], self.segment.poses - self.path, 0.0)
        residuals[seen, HEADING] = np.unwrap(residuals[seen, HEADING])
        return residuals

    def turned(self, theta: Floats, turn: Floats) -> Track:
        """Return the track with a path whose headings differ by `turn` (n,), rad."""
        path = self.path.copy()
        path[:, HEADING] += turn
        force = self.segment.u @ theta[:, 2:4].T + theta[:, 4]
        for axis, part in ((X, np.cos), (Y, np.sin)):
            a1, a2 = theta[axis, :2]
            pushes = force[1:-1, axis] * part(path[1:-1, HEADING])
            start = path[0, axis], path[1, axis] - a1 * path[0, axis]
            path[:, axis] = second_order_recursion(a1, a2, np.hstack([start, pushes]))
        return Track(self.segment, path, path_sensitivities(theta, path, self.segment.u))


def estimated_noise(theta: Floats, tracks: list[Track]) -> Noise:
    """Return the noise that makes the residuals of tracks by theta (3, 5) most likely.

    It is NaN if the path is too far off for the number format.
    """
    longest = sorted(tracks, key=lambda track: -len(track.path))
    steps = np.cumsum([0, *(len(track.path) for track in longest)])[:-1]
    try:
        return _estimated(
            theta, [track for track, n in zip(longest, steps, strict=True) if n < _ENOUGH]
        )
    except np.linalg.LinAlgError:
        return _UNKNOWN


def _estimated(theta: Floats, tracks: list[Track]) -> Noise:
    residuals = [_Residuals.of(theta, axis, tracks) for axis in range(3)]
    heading = residuals[HEADING].driven(*theta[HEADING, :2])
    turns = _p_value(heading.statistic) < LEVEL
    turns = turns and heading.cost < residuals[HEADING].coloured().cost + _MARGIN
    if turns:
        # The positions follow the headings that the robot had.
        ends = np.cumsum([len(track.path) for track in tracks])[:-1]
        parts = zip(tracks, np.split(heading.drift, ends), strict=True)
        tracks = [track.turned(theta, turn) for track, turn in parts]
        residuals[:HEADING] = [_Residuals.of(theta, axis, tracks) for axis in (X, Y)]
    axes = [*(residuals[axis].driven(*theta[axis, :2]) for axis in (X, Y)), heading]
    p_value = _p_value(sum(axis.statistic for axis in axes))
    if p_value < LEVEL and not turns:
        others = [one.coloured() for one in residuals]
        if sum(axis.cost for axis in others) + 3 * _MARGIN < sum(axis.cost for axis in axes):
            axes = others
    return Noise(
        driving=np.array([axis.driving for axis in axes]),
        white=np.array([axis.white for axis in axes]),
        correlation=np.array([axis.correlation for axis in axes]),
        p_value=p_value,
    )


def _p_value(statistic: float) -> float:
    from scipy.special import chdtrc

    if statistic <= 0:
        return 1.0
    return float(sum(w * chdtrc(n, statistic) for n, w in enumerate(_WEIGHTS, start=1)))


@dataclass(frozen=True, kw_only=True, eq=False)
class _Axis:
    """The noise of an axis."""

    driving: float
    white: float
    correlation: float
    cost: float  # -2 log likelihood, but for a constant
    statistic: float  # the cost without z, relative to this one
    drift: Floats  # (N,): the expected z, and the change by other parameters


@dataclass(frozen=True, kw_only=True, eq=False)
class _Residuals:
    """Residuals y = z + F beta + e of an axis.

    The columns of F are the derivatives by the parameters, and the path of the model from any first
    two values of each segment.
    """

    seen: NDArray[np.bool_]  # (N,)
    left: NDArray[np.int64]  # (N,): steps to the end of the segment
    starts: NDArray[np.bool_]  # (N,): the first steps of the segments
    F: Floats  # (N, m): orthonormal where seen
    y: Floats  # (N,)

    @staticmethod
    def of(theta: Floats, axis: int, tracks: list[Track]) -> _Residuals:
        # The parameters of the heading move the positions, too.
        columns = [FIRST + 5 * axis + i for i in range(5)]
        turning = [] if axis == HEADING else [FIRST + 5 * HEADING + i for i in range(5)]
        starts = [] if axis == HEADING else [4, 5]
        shared = np.vstack([track.slopes[:, axis, columns + turning] for track in tracks])
        a1, a2 = theta[axis, :2]
        own = [
            np.hstack(
                [
                    second_order_recursion(a1, a2, np.eye(len(track.path), 2)),
                    track.slopes[:, axis, starts],
                ]
            )
            for track in tracks
        ]
        F = np.hstack([shared, _blocks(own)])
        seen = np.hstack([track.segment.seen for track in tracks])
        parts = decompose(F[seen])
        return _Residuals(
            seen=seen,
            left=np.hstack([np.arange(len(track.path))[::-1] for track in tracks]),
            starts=np.hstack([np.arange(len(track.path)) == 0 for track in tracks]),
            F=F / parts.lengths @ parts.inverse[:, np.any(parts.inverse, axis=0)],
            y=np.hstack([track.residuals[:, axis] for track in tracks]),
        )

    def coloured(self) -> _Axis:
        """Return the noise for measured poses with similar neighbouring errors."""
        return min((self.driven(r) for r in _CORRELATIONS), key=lambda axis: axis.cost)

    def driven(self, a1: float, a2: float | None = None) -> _Axis:
        """Return the most likely noise for z(k) = a1 z(k-1) + a2 z(k-2) + w(k).

        Without a2, z is stationary.
        """
        from scipy.optimize import minimize_scalar

        likelihood = _Likelihood.of(self, a1, a2)
        costs = [likelihood.cost(ratio) for ratio in _LOG_RATIOS]
        best = int(np.argmin(costs))
        bounds = _LOG_RATIOS[max(best - 1, 0)], _LOG_RATIOS[min(best + 1, len(costs) - 1)]
        options = {"xatol": _TOLERANCE}
        found = minimize_scalar(likelihood.cost, bounds=bounds, method="bounded", options=options)
        log_ratio = min(float(found.x), float(_LOG_RATIOS[best]), key=likelihood.cost)
        cost = likelihood.cost(log_ratio)
        white, drift = likelihood.solution(log_ratio)
        return _Axis(
            driving=white * float(np.exp(log_ratio / 2)),
            white=white,
            correlation=a1 if a2 is None else 0.0,
            cost=cost,
            statistic=max(costs[0] - cost, 0.0),
            drift=drift,
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class _Likelihood:
    """The restricted likelihood of residuals with a recursion for z.

    With q, the variance of w relative to e, the expected z minimises sum e^2 + sum w^2 / q. The
    matrix of this linear problem has five diagonals.
    """

    residuals: _Residuals
    bands: Floats  # (3, N): diagonals of A'A, with w = A z
    log_A: float  # log |A'A|

    @staticmethod
    def of(residuals: _Residuals, a1: float, a2: float | None) -> _Likelihood:
        c = np.array([1.0, -a1, -(a2 or 0.0)])
        bands = np.array(
            [
                sum(c[i] * c[i + j] * (residuals.left >= i + j) for i in range(3 - j))
                for j in range(3)
            ]
        )
        if a2 is not None:
            return _Likelihood(residuals=residuals, bands=bands, log_A=0.0)
        # the variance of the first z: that of w / (1 - a1^2)
        bands[0] -= a1**2 * residuals.starts
        log_A = int(residuals.starts.sum()) * float(np.log1p(-(a1**2)))
        return _Likelihood(residuals=residuals, bands=bands, log_A=log_A)

    @property
    def _freedom(self) -> int:
        return max(int(self.residuals.seen.sum()) - int(self.residuals.F.shape[1]), 1)

    def _whitened(self, log_ratio: float) -> tuple[Floats, Floats, float]:
        """Return z of [F | y], the triangular factor of their weighted squares, log |weights|."""
        from scipy.linalg import cho_solve_banded, cholesky_banded

        seen = self.residuals.seen
        matrix = self.bands * np.exp(-log_ratio)
        matrix[0] += seen
        factor = cholesky_banded(matrix, lower=True, check_finite=False)
        columns = np.column_stack([self.residuals.F, self.residuals.y]) * seen[:, np.newaxis]
        z = cho_solve_banded((factor, True), columns, check_finite=False)
        squares = columns.T @ (columns - z)
        return z, np.linalg.cholesky(squares).T, 2 * float(np.log(factor[0]).sum())

    def cost(self, log_ratio: float) -> float:
        """Return -2 log likelihood, but for a constant."""
        try:
            _, R, weights = self._whitened(log_ratio)
        except np.linalg.LinAlgError:  # beyond what numbers resolve
            return np.inf
        d = np.log(np.diag(R))
        # residual variance, |covariance of the seen y|, |F' covariance^-1 F|
        by_ratio = len(self.residuals.seen) * log_ratio + weights - self.log_A
        return float(2 * self._freedom * d[-1] + by_ratio + 2 * d[:-1].sum())

    def solution(self, log_ratio: float) -> tuple[float, Floats]:
        """Return the standard deviation of e, and z + F beta."""
        z, R, _ = self._whitened(log_ratio)
        beta = np.linalg.solve(R[:-1, :-1], R[:-1, -1])
        drift = z[:, -1] - z[:, :-1] @ beta + self.residuals.F @ beta
        return float(R[-1, -1] / np.sqrt(self._freedom)), drift


def _blocks(parts: list[Floats]) -> Floats:
    """Return a matrix with the parts along its diagonal."""
    rows, columns = np.sum([part.shape for part in parts], axis=0)
    whole = np.zeros((rows, columns))
    row = column = 0
    for part in parts:
        n, m = part.shape
        whole[row : row + n, column : column + m] = part
        row, column = row + n, column + m
    return whole


def errors_under(noise: Noise, theta: Floats, tracks: list[Track], sigma: Floats) -> Floats:
    """Return the standard errors of the unknowns but the first poses, under a noise.

    They were fitted with weights 1 / sigma^2, sigma (3,):

        error = (J' J)^-1 J' residuals,  J: derivatives without those by the first poses
    """
    parts, spreads = [], []
    for track in tracks:
        weights = track.segment.seen[:, np.newaxis] / sigma
        scaled = track.slopes * weights[:, :, np.newaxis]
        n, _, m = scaled.shape
        J = scaled.reshape(3 * n, m)
        Q, _ = np.linalg.qr(J[:, :FIRST])
        J = J[:, FIRST:] - Q @ (Q.T @ J[:, FIRST:])
        parts.append(triangle(J))
        by_residual = J.reshape(n, 3, m - FIRST) * weights[:, :, np.newaxis]
        by_push = (
            by_driving(by_residual, noise.correlation)
            if noise.correlation.any()
            else _adjoint(theta, track, by_residual)[2:]
        )
        spreads += [
            (by_residual * noise.white[:, np.newaxis]).reshape(3 * n, -1),
            (by_push * noise.driving[:, np.newaxis]).reshape(3 * len(by_push), -1),
        ]
    found = decompose(np.vstack(parts))
    inverse = found.inverse @ found.inverse.T / np.outer(found.lengths, found.lengths)
    # The rows of R' R = sum spread' spread are as good as the spreads.
    errors: Floats = np.linalg.norm(triangle(np.vstack(spreads)) @ inverse, axis=0)
    return errors


def by_driving(weights: Floats, correlation: Floats) -> Floats:
    """Return the effect (n, a, m) of w in each step on sum weights' z, for errors of poses."""
    effect = [
        second_order_recursion(r, 0.0, weights[::-1, axis])[::-1]
        for axis, r in enumerate(correlation)
    ]
    result = np.stack(effect, axis=1)
    # the variance of the first z: that of w / (1 - correlation^2)
    result[0] /= np.sqrt(1 - np.square(correlation))[:, np.newaxis]
    return result


def _adjoint(theta: Floats, track: Track, weights: Floats) -> Floats:
    """Return the effect (n, 3, m) of a push w in each step on sum weights' path."""
    u, heading = track.segment.u, track.path[:, HEADING]
    force = u @ theta[:, 2:4].T + theta[:, 4]
    effect = weights.copy()

    def backwards(axis: int) -> None:
        a1, a2 = theta[axis, :2]
        effect[:, axis] = second_order_recursion(a1, a2, effect[::-1, axis])[::-1]

    # d(force cos)/d heading = -force sin,  d(force sin)/d heading = force cos, one step later
    for axis, slope in ((X, -np.sin(heading)), (Y, np.cos(heading))):
        backwards(axis)
        effect[:-1, HEADING] += (force[:-1, axis] * slope[:-1])[:, np.newaxis] * effect[1:, axis]
    backwards(HEADING)
    return effect
