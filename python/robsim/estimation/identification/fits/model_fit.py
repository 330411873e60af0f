"""The result of `instrumental_variables` and `output_error`."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from robsim.base.checks import Floats
from robsim.base.report import Column, Quantity, Report, Table
from robsim.base.text import quoted
from robsim.estimation.identification._parameter_table import (
    contradiction_remarks,
    noise_remarks,
    parameter_table,
)
from robsim.estimation.identification.fits.coloured_noise import Noise
from robsim.estimation.identification.fits.segments import Record
from robsim.trace.timing import check_delay

# A parameter is determined if its standard error is below this fraction of the axis's scale.
_MAXIMUM_ERROR = 0.3


@dataclass(frozen=True, kw_only=True, eq=False)
class ModelFit(Report):
    """The parameters of the robot model, fitted to measured poses.

    Attributes
    ----------
    theta : array (3, 5)
        Rows X, Y, P (heading), columns a1, a2, b1, b2, d1. NaN = the run does not determine the
        parameter.
    standard_errors : array (3, 5)
        Standard errors of theta, inf where theta is NaN: the `white_noise_errors` unless the
        residuals contradict these. Otherwise they include the estimated process noise or
        correlation of the measurement noise.
    white_noise_errors : array (3, 5)
        Standard errors of theta for measurement noise alone, independent from step to step.
    residual_rms : array (3,)
        Root mean square residual: measured minus fitted pose (px, px, rad).
    iterations : int
        Number of iterations.
    converged : bool
        Whether the iteration converged; if not, theta is from the last iteration.
    motor_delay, motor_delay_error : float
        Delay of the inputs (steps), and its standard error; 0 if it was given.
    process_sigma, measurement_sigma : array (3,)
        Standard deviations of process noise and measurement noise in a step (px, px, rad), from the
        residuals.
    measurement_correlation : array (3,)
        Correlation of the coloured part of the measurement noise from step to step; 0 = white.
    whiteness_p_value : float
        Probability that residuals without process noise are as far from white. A probability below
        0.05 contradicts the `white_noise_errors`.

    Examples
    --------
    >>> control = robsim.control.PseudoRandomBinary()
    >>> trace = robsim.Simulation(seed=1, control=control).run(200)
    >>> fit = robsim.estimation.output_error(trace.pose_true, trace.u)
    >>> fit.theta[2, :2].round(3), fit.converged
    (array([ 1.833, -0.833]), True)
    """

    theta: Floats
    standard_errors: Floats
    residual_rms: Floats
    iterations: int
    converged: bool
    motor_delay: float = 0.0
    motor_delay_error: float = 0.0
    white_noise_errors: Floats = field(default_factory=lambda: np.full((3, 5), np.nan))
    process_sigma: Floats = field(default_factory=lambda: np.zeros(3))
    measurement_sigma: Floats = field(default_factory=lambda: np.zeros(3))
    measurement_correlation: Floats = field(default_factory=lambda: np.zeros(3))
    whiteness_p_value: float = 1.0

    @property
    def determined(self) -> NDArray[np.bool_]:
        """Whether the recording determines each parameter, (3, 5)."""
        return np.asarray(np.isfinite(self.theta))

    @property
    def title(self) -> str:
        """The kind of fit."""
        return "Parameters fitted to measured poses"

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """The delay of the inputs, if it is not 0."""
        return delay_quantities(self.motor_delay, self.motor_delay_error)

    @property
    def tables(self) -> tuple[Table, ...]:
        """Estimate and standard error of each parameter."""
        errors = np.where(self.determined, self.standard_errors, np.nan)
        columns = {
            Column("estimate", "estimate", format=".5g"): self.theta,
            Column("standard_error", "standard error", format=".2g"): errors,
        }
        return (parameter_table(columns),)

    @property
    def remarks(self) -> tuple[str, ...]:
        """The limitations of the fit."""
        remarks = []
        if not self.determined.all():
            remarks.append(
                "parameters without a value are not determined by the run; excite the robot more, "
                "or longer"
            )
        if not self.converged:
            remarks.append(f"not converged after {self.iterations} iterations: do not trust it")
        contradiction = contradiction_remarks(
            self.whiteness_p_value,
            self.standard_errors,
            self.white_noise_errors,
            self.process_sigma,
            self.measurement_correlation,
        )
        return (*remarks, *(contradiction or noise_remarks("measurement")))


def with_noise(fit: ModelFit, noise: Noise, standard_errors: Floats | None = None) -> ModelFit:
    """Return the fit with the noise of its residuals, and the standard errors under this noise."""
    errors = fit.standard_errors if standard_errors is None else standard_errors
    return replace(
        fit,
        standard_errors=np.where(fit.determined, errors, np.inf),
        white_noise_errors=fit.standard_errors,
        process_sigma=noise.process,
        measurement_sigma=noise.measurement,
        measurement_correlation=noise.correlation,
        whiteness_p_value=noise.p_value,
    )


def delay_quantities(delay: float, error: float) -> tuple[Quantity, ...]:
    """Return a report's quantities for a delay of the inputs (steps); empty without a delay."""
    quantities = (
        Quantity("motor_delay", "motor delay", delay, "steps", ".4g"),
        Quantity("motor_delay_error", "its standard error", error, "steps", ".2g"),
    )
    return quantities if error else quantities[: bool(delay)]


def with_undetermined(theta: Floats, standard_errors: Floats) -> tuple[Floats, Floats]:
    """Return theta and its standard errors (3, 5), NaN and inf where theta is not determined.

    The scale of a1 and a2 is 1; of b1, b2, d1 it is the larger of b1, b2: the effect of 1 V.
    """
    gain = np.abs(theta[:, 2:4]).max(axis=1)
    scale = np.column_stack([np.ones((3, 2)), gain, gain, gain])
    # False for NaN, too
    is_determined = standard_errors < _MAXIMUM_ERROR * scale
    # Without a determined b1, b2 or d1, or with an a1 that no robot has, noise has been fitted.
    a1 = theta[:, 0]
    is_determined &= (is_determined[:, 2:].any(axis=1) & (a1 > 0) & (a1 < 2))[:, None]
    return (
        np.where(is_determined, theta, np.nan),
        np.where(is_determined, standard_errors, np.inf),
    )


#: Delays are searched from 0 to this (steps).
LONGEST_DELAY = 10
_TOLERANCE = 1e-4  # steps
#: Of numerical derivatives by the delay (steps).
DIFFERENCE = 0.05
_LEAST_CURVATURE = 1e-3  # of -2 log likelihood, per step^2: less is rounding


def check_delay_or_fit(delay: float | str) -> float | None:
    """Return the argument ``motor_delay`` in steps; None = to be estimated."""
    if isinstance(delay, str):
        if delay == "fit":
            return None
        raise ValueError(f"motor_delay must be a number (steps) or 'fit', got {quoted(delay)}")
    return check_delay("motor_delay", delay)


class DelayedFit(Protocol):
    """The solution for a delay of the inputs (steps)."""

    @property
    def fit(self) -> ModelFit:
        """The parameters."""


Solution = TypeVar("Solution", bound=DelayedFit)


class DelayedFits(Protocol[Solution]):
    """The solutions of a record, for any delay of its inputs (steps)."""

    def rough_cost(self, delay: float) -> float:
        """Return a cost that is least near the best delay."""

    def solve(self, delay: float, known: Sequence[Solution]) -> Solution:
        """Return the solution for a delay, starting from up to two solutions for other delays."""

    def slope(self, solution: Solution, side: int) -> float:
        """Return the derivative of -2 log likelihood by the delay, to the side +1 or -1."""


def fit_delay(record: Record, fits: DelayedFits[Solution]) -> tuple[ModelFit, Solution]:
    """Return the best of the fits with any delay (steps), and its solution."""
    solutions: dict[float, Solution] = {}

    def at(delay: float) -> Solution:
        if delay not in solutions:
            nearest = sorted(solutions, key=lambda known: abs(known - delay))[:2]
            solutions[delay] = fits.solve(delay, [solutions[known] for known in nearest])
        return solutions[delay]

    first = float(min(range(LONGEST_DELAY + 1), key=fits.rough_cost))
    solution = at(_lowest(lambda delay, side: fits.slope(at(delay), side), first))
    best = solution.fit
    error, slopes = _spread(lambda delay: at(delay).fit, best, int(record.seen.sum()))
    fit = replace(
        best,
        standard_errors=_with_delay(best.standard_errors, slopes, error),
        converged=best.converged and best.motor_delay < LONGEST_DELAY and math.isfinite(error),
        motor_delay_error=error,
    )
    return fit, solution


def _lowest(slope: Callable[[float, int], float], delay: float) -> float:
    """Return the minimum of a cost, downhill from a whole delay, where corners are possible."""
    from scipy.optimize import brentq

    side = 1 if slope(delay, 1) < 0 else -1
    while 0 <= delay + side <= LONGEST_DELAY and side * slope(delay, side) < 0:
        delay += side
        if side * slope(delay, -side) > 0:
            low, high = sorted((delay - side, delay))
            inwards = partial(_inwards, slope, high)
            return float(brentq(inwards, low, high, xtol=_TOLERANCE))
    return delay


def _inwards(slope: Callable[[float, int], float], high: float, delay: float) -> float:
    return slope(delay, -1 if delay == high else 1)


def _rms(fit: ModelFit) -> Floats:
    return np.maximum(fit.residual_rms, np.finfo(float).tiny)


def _spread(at: Callable[[float], ModelFit], best: ModelFit, n: int) -> tuple[float, Floats]:
    """Return the standard error of the best delay, and the parameters' slope with the delay."""
    # Numerical derivatives, one-sided at an edge of the search range.
    h = DIFFERENCE
    middle = min(max(best.motor_delay, h), LONGEST_DELAY - h)
    fits = [at(delay) for delay in (middle - h, middle, middle + h)]
    # -2 log likelihood for the noise of the best fit; variance = 2 / (its second derivative)
    before, now, after = (n * np.square(_rms(fit) / _rms(best)).sum() for fit in fits)
    curvature = (before - 2 * now + after) / h**2
    error = math.sqrt(2 / curvature) if curvature > _LEAST_CURVATURE else math.inf
    return error, (fits[2].theta - fits[0].theta) / (2 * h)


def _with_delay(standard_errors: Floats, slope: Floats, error: float) -> Floats:
    """Return the standard errors (3, 5) of parameters that change by `slope` with the delay."""
    # variance = variance for this delay + slope^2 variance of the delay
    by_delay = np.where(np.isfinite(slope), slope, 0.0) * (error if math.isfinite(error) else 0.0)
    return np.hypot(standard_errors, by_delay)
