"""The Ljung-Box test of an innovation's whiteness, for users and for the NIS report."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robsim.base.checks import Floats, as_float_array, check_int
from robsim.base.report import Quantity, Report, percent
from robsim.estimation.evaluation.chi_square import chi_square_quantile, chi_square_tail

# 95 % of a normal distribution lie within this number of standard deviations.
_LIMIT = 1.96
# An innovation with a smaller p-value is not white.
_LEVEL = 0.05
# With more lags than a tenth of the values a white innovation fails more often than in 5 %.
_MOST_LAGS, _VALUES_PER_LAG, _STEPS_PER_LAG = 10, 10, 4


@dataclass(frozen=True, kw_only=True, eq=False)
class WhitenessReport(Report):
    """Whether an innovation is white: uncorrelated with the innovations of earlier steps.

    Attributes
    ----------
    autocorrelation : array (L, n)
        For the n components of the innovation, at the lags 1..L; NaN without pairs.
    pairs : array (L, n) of int
        Number of pairs of steps for each autocorrelation.
    ljung_box : float
        The Ljung-Box statistic, summed over the n components.
    p_value : float
        Probability that a white innovation has a larger statistic.

    Notes
    -----
    With the default number of lags, 4 to 7 % of white innovations of 20 to 1000 steps fail. This
    holds for one to three components, with gaps, and in one or several runs. 15 to 25 % are at the
    limit (tests/statistics/RESULTS.md).

    Examples
    --------
    >>> x = np.random.default_rng(1).normal(size=(200, 1))
    >>> report = robsim.estimation.whiteness(x)
    >>> report.is_white, report.autocorrelation.shape
    (True, (10, 1))
    """

    autocorrelation: Floats
    pairs: NDArray[np.int64]
    ljung_box: float
    p_value: float

    @property
    def limits(self) -> Floats:
        """The 95 % limits of a white innovation's autocorrelations: 1.96/sqrt(pairs), (L, n)."""
        return np.asarray(_LIMIT / np.sqrt(np.where(self.pairs, self.pairs, np.nan)))

    @property
    def fraction_outside(self) -> float:
        """Fraction of the autocorrelations outside their limits; 0.05 is expected."""
        outside = np.count_nonzero(np.abs(self.autocorrelation) > self.limits)
        return float(outside / np.count_nonzero(self.pairs))

    @property
    def is_white(self) -> bool:
        """Whether the p-value is at least 0.05; about 5 % of correct filters fail by design."""
        return self.p_value >= _LEVEL

    @property
    def degrees_of_freedom(self) -> int:
        """Degrees of freedom of `ljung_box`, equal to its mean and to half of its variance."""
        return int(np.count_nonzero(self.pairs))

    @property
    def ljung_box_limit(self) -> float:
        """The limit of `ljung_box`; a larger value means that the innovation is not white."""
        return chi_square_quantile(_LEVEL, self.degrees_of_freedom)

    @property
    def at_limit(self) -> bool:
        """Whether `ljung_box` is within one standard deviation of its limit."""
        return abs(self.ljung_box - self.ljung_box_limit) <= self._spread

    @property
    def _spread(self) -> float:
        # the variance of chi2(n) is 2 n
        return math.sqrt(2.0 * self.degrees_of_freedom)

    @property
    def title(self) -> str:
        """The tested innovation and lags."""
        return f"Innovation, lags 1..{len(self.autocorrelation)}"

    @property
    def verdict(self) -> str:
        """Return ``"white"`` or ``"not white"``."""
        return "white" if self.is_white else "not white"

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """The Ljung-Box test and the autocorrelations outside their limits."""
        count = np.count_nonzero(self.pairs)
        return (
            Quantity("p_value", "p-value of the Ljung-Box test", self.p_value, format=".3g"),
            Quantity("ljung_box", "Ljung-Box statistic", self.ljung_box),
            Quantity("autocorrelations", "autocorrelations", count),
            Quantity(
                "fraction_outside", "outside +-1.96/sqrt(N)", self.fraction_outside, "", percent
            ),
        )

    @property
    def remarks(self) -> tuple[str, ...]:
        """The expectation, and the decisive numbers if the verdict is at the limit."""
        expected = (
            "white: the p-value is at least 0.05; for a white innovation about 5 % of the "
            "autocorrelations are outside"
        )
        return (*self.edge_remarks, expected)

    @property
    def edge_remarks(self) -> tuple[str, ...]:
        """The decisive numbers, if the verdict is at the limit."""
        if not self.at_limit:
            return ()
        return (
            f"the whiteness is at the limit: the Ljung-Box statistic is {self.ljung_box:.3g}, its "
            f"limit {self.ljung_box_limit:.3g}, and its random spread {self._spread:.2g}",
        )


def whiteness(
    innovation: ArrayLike, S: ArrayLike | None = None, *, lags: int | None = None
) -> WhitenessReport:
    """Test whether an innovation is white.

    Parameters
    ----------
    innovation : array (N, n) or (M, N, n)
        N steps, or M independent runs of N steps; NaN = not seen: such a step belongs to no pair.
    S : array (n, n) or (..., N, n, n), optional
        The innovation covariance. If it is given, the n components are decorrelated first.
    lags : int, optional
        Maximum lag (steps). Default: a tenth of the number of known steps, at most 10, and at most
        a quarter of a run. With more lags, a white innovation fails in more than 5 % of the cases:
        in 9 % with 20 lags in 60 steps.

    Returns
    -------
    WhitenessReport
        Autocorrelations, the Ljung-Box test and a verdict.

    Raises
    ------
    TypeError, ValueError
        If an argument has the wrong type or shape, or the run is too short for the lags.

    Notes
    -----
    With w whitened, its mean assumed 0 (a bias is not white), and m_k pairs at lag k of N values::

        r_k = mean of w(t) w(t+k) / mean of w(t)^2
        Q   = (N + 2)/N sum_k m_k r_k^2,  chi2(lags) distributed if w is white

    Without gaps, Q is the statistic of Ljung and Box, On a measure of lack of fit in time series
    models, Biometrika 65(2), 1978. The number of lags follows Hyndman and Athanasopoulos,
    Forecasting: Principles and Practice, 5.4, 2021, but with a tenth instead of their fifth.

    Examples
    --------
    >>> x = np.random.default_rng(1).normal(size=(200, 1))
    >>> robsim.estimation.whiteness(x).verdict, robsim.estimation.whiteness(x.cumsum(0)).verdict
    ('white', 'not white')
    """
    w = as_float_array("innovation", innovation)
    if w.ndim not in (2, 3) or not w.size:
        raise ValueError(f"innovation must be of shape (N, n) or (M, N, n), got {w.shape}")
    if S is not None:
        w = whitened(w, S)
    if lags is None:
        lags = _default_lags(w)
    lags = check_int("lags", lags, minimum=1, maximum=10**6)
    r, pairs, count = _autocorrelation(w.reshape(-1, *w.shape[-2:]), lags)
    # Q = (N + 2)/N sum_k m_k r_k^2
    Q = float(np.nansum((count + 2.0) / count * pairs * np.square(r)))
    p_value = chi_square_tail(Q, int(np.count_nonzero(pairs)))
    return WhitenessReport(autocorrelation=r, pairs=pairs, ljung_box=Q, p_value=p_value)


def _default_lags(w: Floats) -> int:
    known = int(np.count_nonzero(~np.isnan(w).any(axis=-1)))
    steps = int(w.shape[-2])
    return max(1, min(_MOST_LAGS, known // _VALUES_PER_LAG, steps // _STEPS_PER_LAG))


def _autocorrelation(w: Floats, lags: int) -> tuple[Floats, NDArray[np.int64], NDArray[np.int64]]:
    """Return the autocorrelations, the numbers of pairs, and of known values."""
    known = ~np.isnan(w)
    count = np.asarray(np.count_nonzero(known, axis=(0, 1)))
    w = np.where(known, w, 0.0)
    shifted = [(slice(k, None), slice(None, max(w.shape[1] - k, 0))) for k in range(1, lags + 1)]
    pairs = np.array([np.count_nonzero(known[:, a] & known[:, b], axis=(0, 1)) for a, b in shifted])
    square = np.sum(np.square(w), axis=(0, 1))
    if not pairs.any(axis=0).all() or (square == 0).any():
        raise ValueError(
            f"innovation must have nonzero values, and pairs of known values for each lag up to "
            f"{lags} steps, got {count.tolist()} known values in {w.shape[0]} runs of "
            f"{w.shape[1]} steps"
        )
    # r_k = mean of w(t) w(t+k) / mean of w(t)^2
    sums = np.array([np.sum(w[:, a] * w[:, b], axis=(0, 1)) for a, b in shifted])
    r = sums / np.where(pairs, pairs, np.nan) / (square / count)
    return r, pairs, count


def whitened(values: Floats, covariance: ArrayLike, *, name: str = "S") -> Floats:
    """Return L^-1 values (..., n) with L L' = covariance (..., n, n): uncorrelated, of variance 1.

    NaN = not known. ValueError: a covariance, which messages call `name`, is not symmetric positive
    definite, a value is infinite, or the shapes do not fit.
    """
    matrices = as_float_array(name, covariance)
    if not values.ndim:
        raise ValueError(f"errors and innovations must be rows of n numbers, got {values}")
    shape = (*values.shape, values.shape[-1])
    # One matrix may stand for all steps or runs; see numpy's broadcasting.
    pairs = zip(matrices.shape[::-1], shape[::-1], strict=False)
    fits = all(size in (1, wanted) for size, wanted in pairs)
    if matrices.shape[-2:] != shape[-2:] or matrices.ndim > len(shape) or not fits:
        raise ValueError(f"{name} must be of shape {shape} or {shape[-2:]}, got {matrices.shape}")
    matrices = np.broadcast_to(matrices, shape)
    known = ~(np.isnan(values).any(axis=-1) | np.isnan(matrices).any(axis=(-2, -1)))
    result = np.full(values.shape, np.nan)
    if known.any():
        result[known] = _whitened_rows(values[known], matrices[known], np.argwhere(known), name)
    return result


def _whitened_rows(
    values: Floats, matrices: Floats, indices: NDArray[np.int64], name: str
) -> Floats:
    def check(is_valid: Any, expected: str) -> None:
        if not is_valid.all():
            i = int(np.argmin(is_valid))
            index = ", ".join(map(str, indices[i]))
            raise ValueError(f"{name}[{index}] must be {expected}, got {matrices[i].tolist()}")

    if np.isinf(values).any():
        raise ValueError("errors and innovations must be finite, or NaN if unknown, got inf")
    check(np.isfinite(matrices).all(axis=(1, 2)), "finite, or NaN for a step without one")
    variances = np.diagonal(matrices, axis1=1, axis2=2)
    check((variances > 0).all(axis=1), "positive definite")
    # In units of the standard deviations: px and rad differ by orders of magnitude.
    sd = np.sqrt(variances)
    correlation = matrices / sd[:, :, np.newaxis] / sd[:, np.newaxis, :]
    asymmetry = np.abs(correlation - np.swapaxes(correlation, 1, 2)).max(axis=(1, 2))
    check(asymmetry < 1e-6, "symmetric")
    check(np.linalg.eigvalsh(correlation)[:, 0] > 1e-14, "positive definite")
    L = np.linalg.cholesky(correlation)
    whitened_rows: Floats = np.linalg.solve(L, (values / sd)[..., np.newaxis])[..., 0]
    return whitened_rows


def standard_error_of_mean(values: Floats) -> float:
    """Return the standard error of the mean of a series (N,) whose neighbours are correlated.

    The series is assumed stationary; NaN = not known, and left out. The result is NaN for fewer
    than two values. With the autocovariances c_k of N values, and the pairs G_j = c_2j + c_2j+1 up
    to the
    last that is positive in a row::

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
