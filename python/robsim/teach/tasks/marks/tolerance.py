"""Limits that hold for whatever distribution, and intervals of shares, by the binomial."""

from __future__ import annotations

import math


def fewest_values(exceeded: float, confidence: float) -> int:
    """Return how many values it takes for a bound that few others exceed: then their largest.

    Parameters
    ----------
    exceeded : float
        The probability with which another value may exceed the bound, within 0..1.
    confidence : float
        The probability that the bound is that high, within 0..1.
    """
    # P(the largest of n lies above the quantile) = 1 - (1 - p)^n
    return math.ceil(math.log1p(-confidence) / math.log1p(-exceeded))


def bound_rank(n: int, exceeded: float, confidence: float) -> int:
    """Return r: the r-th largest of n independent values is a bound that few others exceed.

    A one-sided tolerance bound, whatever the distribution of the values is.

    Parameters
    ----------
    n : int
        How many values there are.
    exceeded, confidence : float
        As for `fewest_values`.

    Raises
    ------
    ValueError
        If there are too few values.

    Notes
    -----
    The r-th largest lies above the quantile q(1 - p) if r values or more do, and their number is
    binomial: P(X >= r), X ~ B(n, p). Source: Wilks, Determination of Sample Sizes for Setting
    Tolerance Limits, Ann. Math. Statist. 12, 1941.
    """
    from scipy.special import bdtrc

    fewest = fewest_values(exceeded, confidence)
    if n < fewest:
        raise ValueError(f"it takes at least {fewest} values, got {n}")
    rank = 1
    # bdtrc(r, n, p) = P(X >= r + 1)
    while bdtrc(rank, n, exceeded) >= confidence:
        rank += 1
    return rank


def share_interval(count: int, n: int, level: float = 0.95) -> tuple[float, float]:
    """Return the exact confidence interval of a probability, from how often it came true.

    Parameters
    ----------
    count, n : int
        How often, of how many times.
    level : float
        Level of confidence.

    Notes
    -----
    Source: Clopper and Pearson, The Use of Confidence or Fiducial Limits Illustrated in the Case of
    the Binomial, Biometrika 26, 1934.
    """
    from scipy.special import betaincinv

    outside = (1 - level) / 2
    low = float(betaincinv(count, n - count + 1, outside)) if count else 0.0
    high = float(betaincinv(count + 1, n - count, 1 - outside)) if count < n else 1.0
    return low, high
