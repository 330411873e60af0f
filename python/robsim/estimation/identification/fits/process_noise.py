"""Process noise: found in the residuals of a simulated path, and carried to the standard errors.

In the residuals of an axis, process noise w passes through the model, measurement noise e does not:

    residual(k) = z(k) + e(k),  z(k) = a1 z(k-1) + a2 z(k-2) + w(k)
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
# The weights of chi2(1), chi2(2), chi2(3) in the sum of three likelihood ratios, each of them of a
# variance that cannot be below 0.
_WEIGHTS = (3 / 8, 3 / 8, 1 / 8)


@dataclass(frozen=True, kw_only=True, eq=False)
class Noise:
    """Standard deviations (3,) of the noise of x, y (px) and heading (rad) in a step."""

    process: Floats
    measurement: Floats
    p_value: float  # probability of residuals as far from white without process noise

    @property
    def is_white(self) -> bool:
        return not self.p_value < LEVEL


NO_NOISE = Noise(process=np.zeros(3), measurement=np.zeros(3), p_value=1.0)
_UNKNOWN = Noise(process=np.full(3, np.nan), measurement=np.full(3, np.nan), p_value=np.nan)


@dataclass(frozen=True, eq=False)
class Track:
    """A segment beside the path that is simulated for it, (n, 3)."""

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

    It is NaN where the path is too far off for numbers to resolve.
    """
    try:
        return _estimated(theta, tracks)
    except np.linalg.LinAlgError:
        return _UNKNOWN


def _estimated(theta: Floats, tracks: list[Track]) -> Noise:
    heading = _Axis.of(theta, HEADING, tracks)
    if _p_value(heading.statistic) < LEVEL:
        # The positions follow the headings that the robot had.
        ends = np.cumsum([len(track.path) for track in tracks])[:-1]
        turns = np.split(heading.drift, ends)
        tracks = [track.turned(theta, turn) for track, turn in zip(tracks, turns, strict=True)]
    axes = [*(_Axis.of(theta, axis, tracks) for axis in (X, Y)), heading]
    return Noise(
        process=np.array([axis.process for axis in axes]),
        measurement=np.array([axis.measurement for axis in axes]),
        p_value=_p_value(sum(axis.statistic for axis in axes)),
    )


def _p_value(statistic: float) -> float:
    from scipy.special import chdtrc

    if statistic <= 0:
        return 1.0
    return float(sum(w * chdtrc(n, statistic) for n, w in enumerate(_WEIGHTS, start=1)))


@dataclass(frozen=True, kw_only=True, eq=False)
class _Axis:
    """The noise of an axis."""

    process: float
    measurement: float
    statistic: float  # -2 log of the likelihood without process noise, relative to the maximum
    drift: Floats  # (N,): the expected z, and the change by other parameters

    @staticmethod
    def of(theta: Floats, axis: int, tracks: list[Track]) -> _Axis:
        from scipy.optimize import minimize_scalar

        likelihood = _Likelihood.of(theta, axis, tracks)
        costs = [likelihood.cost(ratio) for ratio in _LOG_RATIOS]
        best = int(np.argmin(costs))
        bounds = _LOG_RATIOS[max(best - 1, 0)], _LOG_RATIOS[min(best + 1, len(costs) - 1)]
        options = {"xatol": _TOLERANCE}
        found = minimize_scalar(likelihood.cost, bounds=bounds, method="bounded", options=options)
        log_ratio = min(float(found.x), float(_LOG_RATIOS[best]), key=likelihood.cost)
        measurement, drift = likelihood.solution(log_ratio)
        return _Axis(
            process=measurement * float(np.exp(log_ratio / 2)),
            measurement=measurement,
            statistic=max(costs[0] - likelihood.cost(log_ratio), 0.0),
            drift=drift,
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class _Likelihood:
    """The restricted likelihood of residuals y = z + F beta + e of an axis.

    The first two z of each segment are free. With q, the variance of w relative to e, the expected
    z minimises sum e^2 + sum w^2 / q. The matrix of this linear problem has five diagonals.
    """

    seen: NDArray[np.bool_]  # (N,)
    inner: NDArray[np.bool_]  # (N,): the steps whose two previous ones are in their segment
    bands: Floats  # (3, N): diagonals of A'A, with w = A z
    F: Floats  # (N, m): orthonormal where seen, and orthogonal to the free z
    y: Floats  # (N,)

    @staticmethod
    def of(theta: Floats, axis: int, tracks: list[Track]) -> _Likelihood:
        c = np.hstack([1.0, -theta[axis, :2]])
        seen = np.hstack([track.segment.seen for track in tracks])
        inner = np.hstack([np.arange(len(track.path)) >= 2 for track in tracks])
        after = np.append(inner, [False, False])
        n = len(seen)
        bands = [
            sum(c[i] * c[i + j] * after[i + j : i + j + n] for i in range(3 - j)) for j in range(3)
        ]
        # The parameters of the heading move the positions, too.
        columns = [FIRST + 5 * axis + i for i in range(5)]
        turning = [] if axis == HEADING else [FIRST + 5 * HEADING + i for i in range(5)]
        starts = [] if axis == HEADING else [4, 5]
        F = np.vstack([track.slopes[:, axis, columns + turning] for track in tracks])
        F = np.hstack([F, _blocks([track.slopes[:, axis, starts] for track in tracks])])
        a1, a2 = theta[axis, :2]
        free = _blocks([second_order_recursion(a1, a2, np.eye(len(t.path), 2)) for t in tracks])
        F -= free @ np.linalg.lstsq(free[seen], F[seen], rcond=None)[0]
        parts = decompose(F[seen])
        F = F / parts.lengths @ parts.inverse[:, np.any(parts.inverse, axis=0)]
        y = np.hstack([track.residuals[:, axis] for track in tracks])
        return _Likelihood(seen=seen, inner=inner, bands=np.array(bands), F=F, y=y)

    @property
    def _freedom(self) -> int:
        # Each free z takes one.
        free = len(self.inner) - int(self.inner.sum())
        return max(int(self.seen.sum()) - free - int(self.F.shape[1]), 1)

    def _whitened(self, log_ratio: float) -> tuple[Floats, Floats, float]:
        """Return z of [F | y], the triangular factor of their weighted squares, log |weights|."""
        from scipy.linalg import cho_solve_banded, cholesky_banded

        matrix = self.bands * np.exp(-log_ratio)
        matrix[0] += self.seen
        factor = cholesky_banded(matrix, lower=True, check_finite=False)
        columns = np.column_stack([self.F, self.y]) * self.seen[:, np.newaxis]
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
        by_ratio = int(self.inner.sum()) * log_ratio
        return float(2 * self._freedom * d[-1] + by_ratio + weights + 2 * d[:-1].sum())

    def solution(self, log_ratio: float) -> tuple[float, Floats]:
        """Return the standard deviation of e, and z + F beta."""
        z, R, _ = self._whitened(log_ratio)
        beta = np.linalg.solve(R[:-1, :-1], R[:-1, -1])
        drift = z[:, -1] - z[:, :-1] @ beta + self.F @ beta
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
        by_push = _adjoint(theta, track, by_residual)[2:]
        spreads += [
            (by_residual * noise.measurement[:, np.newaxis]).reshape(3 * n, -1),
            (by_push * noise.process[:, np.newaxis]).reshape(3 * n - 6, -1),
        ]
    found = decompose(np.vstack(parts))
    inverse = found.inverse @ found.inverse.T / np.outer(found.lengths, found.lengths)
    # The rows of R' R = sum spread' spread are as good as the spreads.
    errors: Floats = np.linalg.norm(triangle(np.vstack(spreads)) @ inverse, axis=0)
    return errors


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
