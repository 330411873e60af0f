"""The linearised residuals of `output_error`, and its damped Gauss-Newton steps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robsim._core import path_sensitivities, simulated_path
from robsim.base.checks import Floats
from robsim.estimation.identification.fits.linear import solve, triangle
from robsim.estimation.identification.fits.segments import Segment
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
    """The weighted residuals, linearised in a step of the unknowns.

    Attributes
    ----------
    sigma : array (3,)
        Standard deviations of x, y and heading, which the residuals are divided by.
    cost : float
        Sum of squares of the weighted residuals.
    blocks : array (S, 22, 22)
        For each segment the triangular factor of [derivatives | residuals], whose columns are
        those of the 6 initial values, of the 15 parameters, and the residuals.
    """

    sigma: Floats
    cost: float
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
