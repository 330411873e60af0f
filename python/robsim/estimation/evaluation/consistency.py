"""Consistency of a filter: agreement of its errors with its reported covariance."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robsim.base.checks import Floats, as_float_array
from robsim.base.report import Quantity, Report, interval, percent
from robsim.estimation.evaluation._whiteness import (
    WhitenessReport,
    standard_error_of_mean,
    whitened,
    whiteness,
)
from robsim.estimation.evaluation.chi_square import chi_square_band
from robsim.estimation.evaluation.errors import as_runs, mean_of_known, wrapped_error
from robsim.trace import Trace

#: Level of the bands for the verdict, also if another band is shown.
JUDGED_LEVEL = 0.95

#: A filter with a smaller fraction of its steps in this band of the NEES is inconsistent.
FRACTION_IN_BAND = 0.8

#: With fewer runs the NEES does not reveal a conservative filter.
MINIMUM_RUNS = 20

#: Tolerance of the mean NEES over enough runs: relative, and in its standard errors.
MEAN_TOLERANCE = (0.1, 4.0)

# A shorter record is not tested for whiteness.
_FEWEST_STEPS = 4


def nees(error: ArrayLike, covariance: ArrayLike) -> Floats:
    """Return the normalised estimation error squared, error' covariance^-1 error.

    Parameters
    ----------
    error : array (..., n)
        Estimate minus truth, angles wrapped (`wrapped_error`); NaN = not known.
    covariance : array (..., n, n)
        The covariance that the filter reports, or one (n, n) for all.

    Returns
    -------
    array (...)
        chi2(n) distributed if the filter is consistent; NaN where error or covariance is NaN.

    Raises
    ------
    ValueError
        If a covariance is not symmetric and positive definite, or the shapes do not fit.

    Examples
    --------
    >>> float(robsim.estimation.nees([2, 0, 0], np.eye(3)))
    4.0
    """
    return _squares(whitened(as_float_array("error", error), covariance, name="covariance"))


def nis(innovation: ArrayLike, S: ArrayLike) -> Floats:
    """Return the normalised innovation squared, innovation' S^-1 innovation.

    Parameters
    ----------
    innovation : array (..., n)
        Measurement minus its prediction, angles wrapped; NaN = not seen.
    S : array (..., n, n)
        The innovation covariance that the filter reports, or one (n, n) for all.

    Returns
    -------
    array (...)
        chi2(n) distributed and white if the filter is consistent; NaN where not known.

    Raises
    ------
    ValueError
        If an S is not symmetric and positive definite, or the shapes do not fit.

    Examples
    --------
    >>> float(robsim.estimation.nis([2, 0], np.diag([4, 1])))
    1.0
    """
    return _squares(whitened(as_float_array("innovation", innovation), S))


def _squares(white: Floats) -> Floats:
    with np.errstate(over="ignore"):  # a diverging filter may give inf
        return np.asarray(np.sum(np.square(white), axis=-1))


@dataclass(frozen=True, kw_only=True, eq=False)
class ConsistencyReport(Report):
    """Agreement of a filter's errors with its reported covariance.

    Attributes
    ----------
    kind : str
        ``"NEES"`` or ``"NIS"``.
    n : int
        Degrees of freedom of one value, which is also its expected mean.
    values : array (N,)
        Mean over the runs at each step, NaN without a known value.
    counts : array (N,) of int
        Number of runs with a value at each step.
    means : array (M,)
        Mean over the steps of each run, NaN without a known value.
    level : float
        Fraction of the values expected in the displayed band.
    band : array (N, 2)
        Two-sided chi-square band of each step, wider where fewer runs have a value.
    whiteness : WhitenessReport or None
        Whiteness of the innovation, for a NIS.
    k : array (N,) of int
        Number of each step.
    drawn_headings : int or None
        Number of drawn headings of the robot, if known.

    Notes
    -----
    The NIS of a consistent filter is white: its mean over all steps must lie in its chi-square
    band, which 5 % of consistent filters miss by design.

    The NEES is not white, since the errors of neighbouring steps are correlated. So the variance of
    its mean over time is larger than for chi-square. For a correctly tuned Kalman filter of
    position and velocity, this mean misses its band in 29 % of the trials. The percentage ranges
    from 7 to 56 %, and increases with the memory of the filter. In 99 % of the trials, some step
    lies outside its own band. Therefore at least 80 % of the steps must lie in their bands. From 20
    runs on, the mean must also deviate by at most 10 %, or 4 of its standard errors if that is
    more. The standard errors come from the spread between the runs, which correlation in time does
    not affect. The verdict always uses the 95 % band, regardless of the displayed `level`.

    A verdict is at the limit if it would change when the share or the mean moves by one standard
    error. The standard error of the share comes from its autocorrelation in time. Over 20 runs, 1
    to 10 % of correct filters are at the limit. For filters with a rejection rate of one half, the
    percentage is 40 to 80 %. In the NIS test, 25 to 40 % of correct filters are at the limit, since
    its limits are only 1.96 standard deviations away. ``./run study statistics`` measures all
    rates: tests/statistics/RESULTS.md.

    The trials of this filter had four levels of process noise and 100 to 500 steps. Over 20 runs,
    the NEES test rejected 1 of 1200 correctly tuned filters. It rejected 4799 of 4800 filters whose
    Q or R was too large or too small by a factor of 4. In single runs, it rejected 3 of 4800
    correctly tuned filters. With Q too small by a factor of 4, it rejected 42 to 75 % of the
    filters; with R too small, 63 to 100 %. It rejected no filter with a Q or R too large: errors
    smaller than reported lie in the wide band of a single run. The NIS test of single runs rejected
    each wrong R. It rejected 8 to 100 % of the filters with a wrong Q, and more when Q is larger
    relative to R.

    Source: Bar-Shalom, Li and Kirubarajan, Estimation with Applications to Tracking and Navigation,
    5.4, 2001.

    Examples
    --------
    >>> error = np.random.default_rng(1).normal(size=(50, 100, 3))
    >>> report = robsim.estimation.nees_consistency(error, np.eye(3))
    >>> round(float(report.mean)), report.mean_band.round(2), report.verdict
    (3, array([2.93, 3.07]), 'consistent')
    """

    kind: str
    n: int
    values: Floats
    counts: NDArray[np.int64]
    means: Floats
    level: float
    band: Floats
    k: NDArray[np.int64]
    whiteness: WhitenessReport | None = None
    drawn_headings: int | None = None

    @property
    def runs(self) -> int:
        """Number of runs M."""
        return len(self.means)

    @property
    def unknown(self) -> int:
        """Number of steps without a value, over all runs; the statistics below omit them."""
        return self.runs * len(self.values) - int(self.counts.sum())

    @property
    def mean(self) -> float:
        """Mean of all known values, whose expectation is n; NaN if no value is known."""
        known = self.counts > 0
        total = int(self.counts.sum())
        return float(np.sum(self.values[known] * self.counts[known])) / total if total else np.nan

    @property
    def mean_standard_error(self) -> float:
        """Standard error of the mean, from the spread between the runs; NaN for a single run."""
        means = self.means[~np.isnan(self.means)]
        if np.isinf(means).any():
            return np.inf
        return float(means.std(ddof=1)) / len(means) ** 0.5 if len(means) > 1 else np.nan

    @property
    def mean_band(self) -> Floats:
        """The 95 % chi-square band (2,) of the mean, valid only for white values such as a NIS."""
        return chi_square_band(self.n, runs=int(self.counts.sum()), level=JUDGED_LEVEL)

    @property
    def _judged_band(self) -> Floats:
        if self.level == JUDGED_LEVEL:
            return self.band
        return chi_square_band(self.n, runs=self.counts, level=JUDGED_LEVEL)

    @property
    def share(self) -> float:
        """Fraction of the known steps in the 95 % band, which decides the verdict on a NEES."""
        return mean_of_known(self._is_inside, axis=0).item()

    @property
    def share_standard_error(self) -> float:
        """Standard error of `share`, from the autocorrelation of the steps in the band."""
        return standard_error_of_mean(self._is_inside)

    @property
    def _is_inside(self) -> Floats:
        """1 for a step in the 95 % band, 0 outside, NaN for an unknown value, (N,)."""
        low, high = self._judged_band.T
        inside = (self.values >= low) & (self.values <= high)
        return np.where(self.counts > 0, inside.astype(np.float64), np.nan)

    def _fraction(self, where: NDArray[np.bool_]) -> float:
        known = np.count_nonzero(self.counts)
        return np.count_nonzero(where) / known if known else np.nan

    @property
    def above(self) -> float:
        """Fraction of the known steps above the band."""
        return self._fraction(self.values > self.band[:, 1])

    @property
    def below(self) -> float:
        """Fraction of the known steps below the band."""
        return self._fraction(self.values < self.band[:, 0])

    @property
    def inside(self) -> float:
        """Fraction of the known steps in the band."""
        return 1.0 - self.above - self.below

    @property
    def verdict(self) -> str:
        """Return ``"consistent"``, ``"optimistic"``, ``"conservative"`` or ``"not known"``."""
        if not self.counts.any():
            return "not known"
        if self._passes():
            return "consistent"
        if self.kind == "NEES" and self.share < FRACTION_IN_BAND:
            low, high = self._judged_band.T
            above, below = self.values > high, self.values < low
            is_large = bool(np.count_nonzero(above) > np.count_nonzero(below))
        else:
            is_large = self.mean > self.n
        return "optimistic" if is_large else "conservative"

    @property
    def at_limit(self) -> bool:
        """Whether a change of the decisive numbers by a standard error changes the verdict."""
        return bool(self.counts.any()) and self._passes(1.0) != self._passes(-1.0)

    def _passes(self, better: float = 0.0) -> bool:
        """Return whether the filter passes with its numbers better by so many standard errors."""
        return self._share_passes(better) and self._mean_passes(better)

    def _share_passes(self, better: float) -> bool:
        if self.kind == "NIS":
            return True
        gain = better * np.nan_to_num(self.share_standard_error)
        return bool(self.share + gain >= FRACTION_IN_BAND)

    def _mean_passes(self, better: float) -> bool:
        if self.kind == "NIS":
            low, high = self.mean_band
            gain = better * self._nis_spread
            return bool(low - gain <= self.mean <= high + gain)
        if np.count_nonzero(~np.isnan(self.means)) < MINIMUM_RUNS:
            return True
        gain = better * np.nan_to_num(self.mean_standard_error)
        return bool(abs(self.mean - self.n) <= self._mean_limit + gain)

    @property
    def _mean_limit(self) -> float:
        relative, standard_errors = MEAN_TOLERANCE
        return max(relative * self.n, standard_errors * self.mean_standard_error)

    @property
    def _nis_spread(self) -> float:
        # the variance of chi2(n) is 2 n
        return float(np.sqrt(2.0 * self.n / self.counts.sum()))

    @property
    def title(self) -> str:
        """The tested value, runs and steps."""
        runs = "1 run" if self.runs == 1 else f"{self.runs} runs"
        steps = "1 step" if len(self.values) == 1 else f"{len(self.values)} steps"
        return f"{self.kind} of {runs} of {steps}"

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """The mean, its expectation, and the fractions of steps in, above and below the band."""
        band = f"{percent(self.level, 0)} band"
        return (
            Quantity("mean", f"mean {self.kind}", self.mean, format=".3g"),
            *self._expectation(),
            *self._share_quantity(),
            Quantity("inside", f"steps in the {band}", self.inside, format=percent),
            Quantity("above", "steps above it", self.above, format=percent),
            Quantity("below", "steps below it", self.below, format=percent),
            Quantity("n", "degrees of freedom", self.n),
            Quantity("unknown", "values not known", self.unknown),
            *self._whiteness_quantities(),
        )

    def _expectation(self) -> tuple[Quantity, ...]:
        if self.kind == "NIS":
            return (Quantity("mean_band", "mean expected", self.mean_band, format=interval),)
        error = self.mean_standard_error
        return (
            Quantity(
                "mean_standard_error",
                "its standard error",
                error,
                format=".2g",
                missing="unknown for a single run",
            ),
            Quantity("expected_mean", "mean expected", self.n, format="g"),
        )

    def _share_quantity(self) -> tuple[Quantity, ...]:
        if self.kind == "NIS" or self.level == JUDGED_LEVEL:
            return ()
        title = f"steps in the {percent(JUDGED_LEVEL, 0)} band"
        return (Quantity("share", title, self.share, format=percent),)

    def _whiteness_quantities(self) -> tuple[Quantity, ...]:
        if self.whiteness is None:
            return ()
        verdict = Quantity("whiteness", "innovation", self.whiteness.verdict)
        return (verdict, *self.whiteness.quantities)

    @property
    def remarks(self) -> tuple[str, ...]:
        """The meaning of the verdict."""
        remarks = [_MEANING[self.verdict]]
        if self.at_limit:
            remarks.append(
                f"at the limit, so that other runs may give another verdict: {self._edge}"
            )
        if self.kind == "NEES" and self.verdict != "not known":
            remarks.append(
                f"a consistent filter has at least {percent(FRACTION_IN_BAND, 0)} of the steps "
                f"in the {percent(JUDGED_LEVEL, 0)} band"
            )
            if self.runs < MINIMUM_RUNS and self.verdict == "consistent":
                remarks.append(
                    f"a conservative filter is visible only over {MINIMUM_RUNS} runs, or by its NIS"
                )
        if self.kind == "NEES" and self.drawn_headings is not None:
            remarks.append(
                f"the robot was drawn in {self.drawn_headings} headings, at whole pixels: the "
                "errors of "
                "its measured poses are bounded and similar from step to step, so that "
                "a mean of 2 to 3 is usual"
            )
        if self.kind == "NEES" and self.verdict == "conservative" and self.drawn_headings is None:
            remarks.append(
                "in frames without noise the errors of measured poses are not random, and their "
                "covariance is cautious: a mean of 1 to 3 is usual there"
            )
        if self.whiteness is not None:
            remarks += self.whiteness.edge_remarks
        return tuple(remarks)

    @property
    def _edge(self) -> str:
        """The deciding numbers of the verdict, and their spread."""
        if self.kind == "NIS":
            return (
                f"the mean NIS of a correct filter varies by {self._nis_spread:.2g}, and this one "
                f"is as close to the limits of the expected band, {interval(self.mean_band)}"
            )
        if self._share_passes(1.0) != self._share_passes(-1.0):
            return (
                f"the share of steps in the band is {percent(self.share)}, its limit "
                f"{percent(FRACTION_IN_BAND, 0)}, its standard error "
                f"{percent(self.share_standard_error)}"
            )
        return (
            f"the mean is {abs(self.mean - self.n):.2g} off, its limit {self._mean_limit:.2g}, its "
            f"standard error {self.mean_standard_error:.2g}"
        )


_MEANING = {
    "consistent": "the errors are as large as the covariance reports",
    "optimistic": "the errors are larger than the covariance reports: the filter is too sure",
    "conservative": "the errors are smaller than the covariance reports: the filter could be surer",
    "not known": "no step has both an error and a covariance",
}


def nees_consistency(
    error: ArrayLike, covariance: ArrayLike, *, level: float = 0.95
) -> ConsistencyReport:
    """Return the consistency of a filter from its errors (NEES); this needs the truth.

    Parameters
    ----------
    error : array (N, n) or (M, N, n)
        Estimate minus truth of N steps, or of M independent runs of N steps; NaN = not known.
    covariance : array (..., N, n, n) or (n, n)
        The covariance that the filter reports.
    level : float
        Fraction of the values expected in the displayed band; the verdict uses 95 %.

    Returns
    -------
    ConsistencyReport
        Values, band and verdict; print it, or draw it with `robsim.plotting.plot_consistency`.

    Raises
    ------
    TypeError, ValueError
        If a covariance is not symmetric positive definite, or an argument has the wrong type or
        shape.

    Examples
    --------
    Errors that are twice as large as the filter reports:

    >>> error = 2 * np.random.default_rng(1).normal(size=(50, 100, 3))
    >>> report = robsim.estimation.nees_consistency(error, np.eye(3))
    >>> round(float(report.mean)), report.verdict
    (12, 'optimistic')
    """
    rows = _rows("error", error)
    return _report("NEES", nees(rows, covariance), rows.shape[-1], level)


def nis_consistency(
    innovation: ArrayLike, S: ArrayLike, *, level: float = 0.95
) -> ConsistencyReport:
    """Return the consistency of a filter from its innovations (NIS), without the truth.

    The test also works for a real robot.

    Parameters
    ----------
    innovation : array (N, n) or (M, N, n)
        Measurement minus its prediction in N steps, or in M independent runs; NaN = not seen.
    S : array (..., N, n, n) or (n, n)
        The innovation covariance that the filter reports.
    level : float
        Fraction of the values expected in the displayed band; the verdict uses 95 %.

    Returns
    -------
    ConsistencyReport
        Values, band, whiteness and verdict; print it, or draw it with
        `robsim.plotting.plot_consistency`.

    Raises
    ------
    TypeError, ValueError
        If an S is not symmetric positive definite, or an argument has the wrong type or shape.

    Examples
    --------
    >>> innovation = np.random.default_rng(1).normal(size=(50, 100, 2))
    >>> report = robsim.estimation.nis_consistency(innovation, np.eye(2))
    >>> round(float(report.mean)), report.verdict
    (2, 'consistent')
    """
    rows = _rows("innovation", innovation)
    white = whitened(rows, S)
    values = _squares(white)
    is_long_enough = rows.shape[-2] >= _FEWEST_STEPS
    has_pairs = is_long_enough and not np.isnan(values[..., 1:] + values[..., :-1]).all()
    test = whiteness(white) if has_pairs else None
    return _report("NIS", values, rows.shape[-1], level, test)


def pose_consistency(traces: Trace | Sequence[Trace], *, level: float = 0.95) -> ConsistencyReport:
    """Return the consistency of a run's state estimator from the errors of its poses (NEES).

    Parameters
    ----------
    traces : Trace or sequence of Trace
        One run, or several of the same steps with different seeds.
    level : float
        Fraction of the values expected in the displayed band; the verdict uses 95 %.

    Returns
    -------
    ConsistencyReport
        NEES, band and verdict; print it, or draw it with `robsim.plotting.plot_consistency`.

    Raises
    ------
    NotRecordedError
        If the runs have no estimate, or no truth.
    TypeError, ValueError
        If the runs do not have the same steps, or if a covariance is not symmetric positive
        definite.

    Examples
    --------
    >>> estimator = robsim.estimation.reference.ExtendedKalmanFilter()
    >>> sim = robsim.Simulation(seed=1, measure=True, estimate_state=estimator)
    >>> report = robsim.pose_consistency(sim.run(100))
    >>> report.n, report.runs, report.verdict
    (3, 1, 'conservative')
    """
    runs = as_runs(traces)
    error = np.array([wrapped_error(trace.pose_estimated, trace.pose_true) for trace in runs])
    covariance = np.array([trace.covariance for trace in runs])
    if np.isnan(error).all():
        runs[0].require("pose_true", "pose_estimated")
    report = nees_consistency(error, covariance, level=level)
    return replace(report, k=runs[0].k, drawn_headings=_headings_of(runs))


def _headings_of(runs: Sequence[Trace]) -> int | None:
    """Return the number of drawn headings of measured robots; None: any."""
    drawn = {trace.info.headings for trace in runs}
    is_one = len(drawn) == 1 and all(trace.is_tracked for trace in runs)
    return drawn.pop() if is_one else None


def _rows(name: str, values: ArrayLike) -> Floats:
    rows = as_float_array(name, values)
    if rows.ndim not in (2, 3) or 0 in rows.shape:
        raise ValueError(f"{name} must be of shape (N, n) or (M, N, n), got {rows.shape}")
    return rows


def _report(
    kind: str, values: Floats, n: int, level: float, test: WhitenessReport | None = None
) -> ConsistencyReport:
    runs = values.reshape(-1, values.shape[-1])
    counts = np.count_nonzero(~np.isnan(runs), axis=0)
    return ConsistencyReport(
        kind=kind,
        n=n,
        values=mean_of_known(runs, axis=0),
        counts=np.asarray(counts),
        means=mean_of_known(runs, axis=1),
        level=level,
        band=chi_square_band(n, runs=counts, level=level),
        k=np.arange(runs.shape[1]),
        whiteness=test,
    )
