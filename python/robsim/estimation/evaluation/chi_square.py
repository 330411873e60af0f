"""Chi-square bands and tail probabilities, for the consistency and the whiteness reports."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from robsim.base.checks import Floats, check_float, check_int
from robsim.base.text import quoted


def chi_square_band(n: int, *, runs: ArrayLike = 1, level: float = 0.95) -> Floats:
    """Return the two-sided probability band of a sum of n squares, averaged over independent runs.

    Parameters
    ----------
    n : int
        Degrees of freedom: 3 for the NEES of a pose, 2 for the NIS of a position.
    runs : int or array (...) of int
        Number of independent values in the average; 0 = no values.
    level : float
        Probability that a value lies in the band.

    Returns
    -------
    array (..., 2)
        Lower and upper limit, NaN for 0 runs.

    Raises
    ------
    TypeError, ValueError
        If an argument has the wrong type or is out of range.

    Notes
    -----
    The sum of n squares of M runs has n M degrees of freedom. With c = (1 - level)/2 the limits are
    thus the quantiles c and 1 - c of chi2(n M), divided by M. Source: Bar-Shalom, Li and
    Kirubarajan, Estimation with Applications to Tracking and Navigation, 5.4.2, 2001.

    Examples
    --------
    Over 100 runs, a consistent pose filter has its mean NEES in this band with probability 0.95:

    >>> robsim.estimation.chi_square_band(3, runs=100).round(2)
    array([2.54, 3.5 ])
    """
    from scipy.special import chdtri

    n = check_int("n", n, minimum=1, maximum=10**9)
    level = check_float("level", level, exclusive_minimum=0.0)
    if level >= 1.0:
        raise ValueError(f"level must lie between 0 and 1, got {quoted(level)}")
    counts: Any = np.asarray(runs)
    if counts.dtype.kind not in "iu" or (counts < 0).any():
        raise ValueError(f"runs must be whole numbers of at least 0, got {quoted(runs)}")
    counts = np.where(counts == 0, np.nan, counts)[..., np.newaxis]
    outside = (1.0 - level) / 2.0
    # chdtri(n, p) is exceeded with the probability p
    band: Floats = chdtri(n * counts, np.array((1.0 - outside, outside))) / counts
    return band


def chi_square_quantile(probability: float, n: int) -> float:
    """Return the value that chi-square (n degrees of freedom) exceeds with a probability > 0."""
    from scipy.special import chdtri

    return float(chdtri(n, probability))


def chi_square_tail(value: float, n: int) -> float:
    """Return the probability that chi-square (n degrees of freedom) exceeds a value."""
    from scipy.special import chdtrc

    return float(chdtrc(n, value))
