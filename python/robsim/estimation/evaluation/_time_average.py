"""The standard error of an average over time, of values that resemble their neighbours."""

from __future__ import annotations

import math

import numpy as np

from robsim.base.checks import Floats


def standard_error_of_mean(values: Floats) -> float:
    """Return the standard error of the mean of a series whose neighbours are correlated.

    Parameters
    ----------
    values : array (N,)
        The series; NaN = not known, and left out. It is taken for stationary.

    Returns
    -------
    float
        The standard error; NaN for fewer than two values.

    Notes
    -----
    With the autocovariances c_k of N values, and the pairs G_j = c_2j + c_2j+1 up to the last that
    is positive in a row:

        variance of the mean = (2 sum_j G_j - c_0) / N, at least c_0 / N

    Source: Geyer, Practical Markov Chain Monte Carlo, Statistical Science 7(4), 1992, 3.3 (the
    initial positive sequence estimator).
    """
    known = values[~np.isnan(values)]
    count = len(known)
    if count < 2:
        return math.nan
    deviation = known - known.mean()
    # by FFT, padded so that the ends do not meet
    spectrum = np.abs(np.fft.rfft(deviation, 2 * count)) ** 2
    c = np.fft.irfft(spectrum)[: count - count % 2] / count
    pairs = c[::2] + c[1::2]
    positive = np.logical_and.accumulate(pairs > 0)
    variance = max(2.0 * float(pairs[positive].sum()) - c[0], c[0])
    return math.sqrt(variance / count)
