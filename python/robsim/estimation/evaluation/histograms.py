"""Histograms of errors: the range that is drawn, and how many bins it has."""

from __future__ import annotations

import numpy as np

from robsim.base.checks import Floats

_MINIMUM_MARGINS = {"cm": 1e-4, "m": 1e-6}


def usual_limits(values: Floats, unit: str = "px") -> tuple[float, float]:
    """Return limits that contain 0 and all values except those far outside the middle 90 %.

    Parameters
    ----------
    values : array (n,)
        Finite numbers.
    unit : str
        Their unit.
    """
    if not len(values):
        return -1.0, 1.0
    low, high = np.quantile(values, (0.05, 0.95))
    tolerance = 3.0 * (high - low)
    usual = values[(values >= low - tolerance) & (values <= high + tolerance)]
    if not len(usual):  # their differences are beyond what numbers hold
        usual = values
    low, high = min(float(usual.min()), 0.0), max(float(usual.max()), 0.0)
    # A minimum range: rounding errors must not look like measurement errors.
    margin = max(0.15 * (high - low), _MINIMUM_MARGINS.get(unit, 1e-3))
    return low - margin, high + margin


def number_of_bins(n: int) -> int:
    """Return how many bins the histogram of n values has within its `usual_limits`."""
    # Rice's rule, 2 n^(1/3), over the 10/13 of the range with values. An odd number, so that one
    # bin is centred in the middle.
    return 2 * int(np.clip(1.3 * n ** (1 / 3), 5, 26)) + 1
