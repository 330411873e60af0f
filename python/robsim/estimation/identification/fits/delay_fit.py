"""The delay of the inputs for which a fit is best."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np

from robsim.base.checks import Floats
from robsim.base.text import quoted
from robsim.estimation.identification.fits.model_fit import ModelFit
from robsim.estimation.identification.fits.segments import Record
from robsim.trace.timing import check_delay

#: Delays are searched from 0 to this (steps).
LONGEST_DELAY = 10

_TOLERANCE = 1e-5  # steps
_DIFFERENCE = 0.05  # steps, of numerical derivatives
_LEAST_CURVATURE = 1e-3  # of -2 log likelihood, per step^2: less is rounding


def check_delay_or_fit(delay: float | str) -> float | None:
    """Return the argument ``input_delay`` in steps; None = it is to be estimated."""
    if isinstance(delay, str):
        if delay == "fit":
            return None
        raise ValueError(f"input_delay must be a number (steps) or 'fit', got {quoted(delay)}")
    return check_delay("input_delay", delay)


def fit_delay(record: Record, fit: Callable[[Record, float], ModelFit]) -> ModelFit:
    """Return the best of the fits with any delay, and how well the record determines it.

    Parameters
    ----------
    record : Record
        Poses and inputs.
    fit : callable
        Returns the fit for a delay (steps).
    """
    from scipy.optimize import minimize_scalar

    at = cache(lambda delay: fit(record, delay))

    def cost(delay: float) -> float:
        # -2 log likelihood / n = sum log(residual_rms^2), but for a constant
        return float(2 * np.log(_rms(at(float(delay)))).sum())

    whole = min(range(LONGEST_DELAY + 1), key=cost)
    bounds = max(whole - 1, 0), min(whole + 1, LONGEST_DELAY)
    found = minimize_scalar(cost, bounds=bounds, method="bounded", options={"xatol": _TOLERANCE})
    best = at(min(float(found.x), float(whole), key=cost))
    error, slope = _spread(at, best, int(record.seen.sum()))
    return replace(
        best,
        standard_errors=_with_delay(best.standard_errors, slope, error),
        converged=best.converged and best.input_delay < LONGEST_DELAY and math.isfinite(error),
        input_delay_error=error,
    )


def _rms(fit: ModelFit) -> Floats:
    return np.maximum(fit.residual_rms, np.finfo(float).tiny)


def _spread(at: Callable[[float], ModelFit], best: ModelFit, n: int) -> tuple[float, Floats]:
    """Return the standard error of the best delay, and what the parameters change with it."""
    # Numerical derivatives, at an edge of what was searched one-sided.
    h = _DIFFERENCE
    middle = min(max(best.input_delay, h), LONGEST_DELAY - h)
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
