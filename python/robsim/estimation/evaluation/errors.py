"""Errors of poses and of other estimates against the truth, and their histograms."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robsim._core import wrap_angle
from robsim.base.checks import Floats, as_float_array, check_text, is_int
from robsim.base.report import Column, Quantity, Report, Row, Table, count, percent
from robsim.base.report.table import shown, shown_unit
from robsim.base.text import quoted
from robsim.estimation.evaluation.few_steps import few_steps, reasons
from robsim.trace import Trace
from robsim.trace.columns import POSES


def wrapped_error(estimate: ArrayLike, truth: ArrayLike, *, angles: Sequence[int] = (2,)) -> Floats:
    """Return estimate minus truth, with angular errors wrapped.

    Parameters
    ----------
    estimate, truth : array (..., n)
        The n components of each estimate and of the truth; NaN = not known.
    angles : sequence of int
        Indices of the components that are angles (rad). Default: the heading of a pose.

    Returns
    -------
    array (..., n)
        The error; angles lie in (-pi, pi].

    Raises
    ------
    TypeError, ValueError
        If the shapes do not fit together, a value is infinite, or an index is out of range.

    Examples
    --------
    >>> robsim.estimation.wrapped_error([0, 0, 3.1], [0, 0, -3.1]).round(4)
    array([ 0.    ,  0.    , -0.0832])
    """
    estimate, truth = as_float_array("estimate", estimate), as_float_array("truth", truth)
    for name, values in (("estimate", estimate), ("truth", truth)):
        if np.isinf(values).any():
            raise ValueError(f"{name} must be finite, or NaN if unknown, got inf")
    try:
        error: Floats = np.subtract(estimate, truth, dtype=np.float64)
    except ValueError:
        shapes = f"{np.shape(estimate)} and {np.shape(truth)}"
        raise ValueError(f"estimate and truth must be of the same shape, got {shapes}") from None
    size = error.shape[-1] if error.ndim else 0
    if not isinstance(angles, Iterable):
        raise TypeError(f"angles must be a sequence of ints, got {quoted(angles)}")
    for angle in angles:
        if not is_int(angle) or not 0 <= angle < size:
            raise ValueError(
                f"angles must be column indices within 0..{size - 1}, got {quoted(angle)}"
            )
        error[..., angle] = wrap_angle(error[..., angle])
    return error


@dataclass(frozen=True, kw_only=True, eq=False)
class ErrorReport(Report):
    """The errors of poses or other estimates against the truth.

    Attributes
    ----------
    source : str
        Name of the compared data: ``"estimate"``, ``"measurement"`` or your own name.
    error : array (M, N, n)
        Estimate minus truth of M runs of N steps, NaN if one of them is not known.
    reported_sd : array (M, N, n) or None
        The standard deviations that the estimator reports, if any.
    names, units : tuple of n str
        Names and units of the n components. Angles are in rad; the printed table has angles in
        degrees.
    k : array (N,) of int
        Number of each step.
    measured : array (M, N, n) or None
        Errors of the measurements in the same steps, for estimates; NaN = not seen.
    bounced : array (M, N) of bool or None
        Steps in which the robot bounced off a wall, if they are known.

    Notes
    -----
    The root mean square error of a single run is random, too. For a Kalman filter its standard
    deviation is about 10 %; the mean of 20 runs has a standard deviation of 2.5 %. So compare
    filters over many runs.

    Examples
    --------
    >>> report = robsim.estimation.estimation_errors([[1, 0, 0], [3, 0, 0]], np.zeros((2, 3)))
    >>> report.names, report.max_error
    (('x', 'y', 'heading'), array([3., 0., 0.]))
    """

    source: str
    error: Floats
    names: tuple[str, ...]
    units: tuple[str, ...]
    k: NDArray[np.int64]
    reported_sd: Floats | None = None
    measured: Floats | None = None
    bounced: NDArray[np.bool_] | None = None

    @property
    def title(self) -> str:
        """The compared data."""
        runs = "" if len(self.error) == 1 else f" over {len(self.error)} runs"
        return f"{self.source[:1].upper()}{self.source[1:]} minus truth{runs}"

    @property
    def total(self) -> int:
        """Number of steps in all runs."""
        return len(self.error) * len(self.k)

    @property
    def known(self) -> NDArray[np.int64]:
        """Number of steps with a known error, (n,); the statistics below use only these steps."""
        return np.asarray(np.count_nonzero(~np.isnan(self.error), axis=(0, 1)))

    @property
    def rmse(self) -> Floats:
        """Root mean square error (n,)."""
        return _rmse(self.error)

    @property
    def bias(self) -> Floats:
        """Mean error (n,)."""
        return mean_of_known(self.error, axis=(0, 1))

    @property
    def sd(self) -> Floats:
        """Standard deviation of the error around its mean (n,)."""
        return np.sqrt(mean_of_known(np.square(self.error - self.bias), axis=(0, 1)))

    @property
    def max_error(self) -> Floats:
        """Maximum absolute error (n,)."""
        sizes = np.where(np.isnan(self.error), -1.0, np.abs(self.error))
        maximum = sizes.max(axis=(0, 1), initial=-1.0)
        return np.where(maximum < 0, np.nan, maximum)

    @property
    def reported_sd_median(self) -> Floats:
        """Median of the reported standard deviations (n,); NaN without reports.

        The steps before the first detection of the robot would dominate a root mean square.
        """
        if self.reported_sd is None or np.isnan(self.reported_sd).all():
            return np.full(len(self.names), np.nan)
        return np.asarray(np.nanmedian(self.reported_sd, axis=(0, 1)))

    @property
    def rmse_of_steps(self) -> Floats:
        """Root mean square error of each step over the runs (N, n): compare it with a bound."""
        return np.sqrt(mean_of_known(np.square(self.error), axis=0))

    @property
    def few_steps(self) -> NDArray[np.bool_]:
        """Dominant steps (M, N): at most 3 % of the steps, with half of the total squared error."""
        return np.asarray(few_steps(self.error).any(axis=-1))

    @property
    def remarks(self) -> tuple[str, ...]:
        """The dominant steps, and the measurement in the same steps."""
        return (*self._on_few_steps(), *self._on_measurement())

    def _on_few_steps(self) -> Iterator[str]:
        steps = self.few_steps
        if not steps.any():
            return
        source = self.error if self.measured is None else self.measured
        bounced = np.zeros_like(steps) if self.bounced is None else self.bounced
        why = ", ".join(reasons(steps, ~np.isnan(source[..., 0]), bounced, self.k))
        rest = np.where(steps[..., np.newaxis], np.nan, self.error)
        of = np.unique(np.nonzero(few_steps(self.error))[2])
        squares = np.square(self.error[..., of])
        share = np.nansum(squares[steps], axis=0) / np.nansum(squares, axis=(0, 1))
        yield (
            f"{np.count_nonzero(steps)} steps make {percent(float(share.min()), 0)} of the "
            f"squared error of {' and '.join(self.names[i] for i in of)}: {why}; without them the "
            f"rmse is {self._in_words(_rmse(rest))}"
        )

    def _on_measurement(self) -> Iterator[str]:
        if self.measured is None:
            return
        known = ~np.isnan(self.measured) & ~np.isnan(self.error)
        measured, own = (_rmse(np.where(known, of, np.nan)) for of in (self.measured, self.error))
        yield (
            f"in the {np.count_nonzero(known[..., 0])} steps in which the robot was seen, the rmse "
            f"is {self._in_words(own)}; the measurement has {self._in_words(measured)}"
        )

    def _in_words(self, values: Floats) -> str:
        """Return values (n,) of the components with their units."""
        pairs = zip(values, self.units, strict=True)
        return ", ".join(
            f"{shown(value, unit, '.3g', '?')} {shown_unit(unit)}".rstrip() for value, unit in pairs
        )

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """The number of steps."""
        return (Quantity("total", "steps", self.total),)

    @property
    def tables(self) -> tuple[Table, ...]:
        """Root mean square error, bias, standard deviation and maximum of each component."""
        columns = [
            (Column("rmse", "rmse"), self.rmse),
            (Column("bias", "bias"), self.bias),
            (Column("sd", "sd"), self.sd),
            (Column("max_error", "maximum"), self.max_error),
            (Column("known", "steps known", "", lambda n: count(n, self.total)), self.known),
        ]
        if self.reported_sd is not None:
            reported = Column("reported_sd_median", "reported sd")
            columns.insert(-1, (reported, self.reported_sd_median))
        titles, numbers = zip(*columns, strict=True)
        rows = [
            Row(name, values, unit)
            for name, values, unit in zip(
                self.names, zip(*numbers, strict=True), self.units, strict=True
            )
        ]
        return (Table(key="errors", columns=titles, rows=rows, row_title="error"),)


def _rmse(error: Floats) -> Floats:
    return np.sqrt(mean_of_known(np.square(error), axis=(0, 1)))


def mean_of_known(values: Floats, axis: int | tuple[int, ...]) -> Floats:
    """Return the mean of the known values; NaN if all are NaN."""
    known = ~np.isnan(values)
    count = np.count_nonzero(known, axis=axis)
    mean: Floats = np.sum(values, axis=axis, where=known) / np.where(count, count, np.nan)
    return mean


def estimation_errors(
    estimate: ArrayLike,
    truth: ArrayLike,
    *,
    covariance: ArrayLike | None = None,
    names: Sequence[str] = ("x", "y", "heading"),
    units: Sequence[str] = ("px", "px", "rad"),
    source: str = "estimate",
) -> ErrorReport:
    """Return the errors of an estimate against the truth.

    Parameters
    ----------
    estimate, truth : array (N, n) or (M, N, n)
        N steps, or M runs of N steps; NaN = not known: the report counts these steps.
    covariance : array (N, n, n) or (M, N, n, n), optional
        The covariance that the estimator reports.
    names, units : sequence of n str
        Names and units of the n components; those in ``"rad"`` are angles. Default: a pose.
    source : str
        Name of the estimate in the report.

    Returns
    -------
    ErrorReport
        Root mean square error, bias, standard deviation and maximum; print it.

    Raises
    ------
    TypeError, ValueError
        If an argument has the wrong type, or the shapes do not fit together.

    Examples
    --------
    >>> report = robsim.estimation.estimation_errors([[1, 0, 0], [3, 0, 0]], np.zeros((2, 3)))
    >>> report.rmse.round(3), report.bias
    (array([2.236, 0.   , 0.   ]), array([2., 0., 0.]))
    """
    names, units = _texts("names", names), _texts("units", units)
    check_text("source", source)
    angles = [i for i, unit in enumerate(units) if unit == "rad"]
    error = wrapped_error(estimate, truth, angles=angles)
    if (
        error.ndim not in (2, 3)
        or not error.size
        or not error.shape[-1] == len(names) == len(units)
    ):
        raise ValueError(
            f"estimate must be of shape (N, n) or (M, N, n) with a name and a unit for each of the "
            f"n numbers, got {np.shape(estimate)}, {len(names)} names and {len(units)} units"
        )
    reported_sd = None
    if covariance is not None:
        matrices = as_float_array("covariance", covariance)
        if matrices.shape != (*error.shape, error.shape[-1]):
            expected = (*error.shape, error.shape[-1])
            raise ValueError(f"covariance must be of shape {expected}, got {matrices.shape}")
        reported_sd = _standard_deviations(matrices)
    return ErrorReport(
        source=source,
        error=error.reshape(-1, *error.shape[-2:]),
        reported_sd=None if reported_sd is None else reported_sd.reshape(-1, *error.shape[-2:]),
        names=names,
        units=units,
        k=np.arange(error.shape[-2]),
    )


def _texts(name: str, texts: Sequence[str]) -> tuple[str, ...]:
    if isinstance(texts, str) or not isinstance(texts, Iterable):
        raise TypeError(f"{name} must be a sequence of texts, got {quoted(texts)}")
    return tuple(check_text(name, text) for text in texts)


def pose_errors(traces: Trace | Sequence[Trace], *, of: str = "estimate") -> ErrorReport:
    """Return the errors of the estimated or measured poses of a run against the truth.

    Parameters
    ----------
    traces : Trace or sequence of Trace
        One run, or several of the same length.
    of : str
        ``"estimate"`` or ``"measurement"``.

    Returns
    -------
    ErrorReport
        Root mean square error, bias, standard deviation and maximum of x, y and the heading; print
        it.

    Raises
    ------
    NotRecordedError
        If the runs have no such poses, or no truth.
    TypeError, ValueError
        If the runs do not have the same steps, or `of` is unknown.

    Examples
    --------
    >>> sim = robsim.Simulation(seed=1, measure=True, noise=robsim.GaussianNoise(20), headings=None)
    >>> report = robsim.pose_errors(sim.run(100), of="measurement")
    >>> report.rmse.round(3)
    array([0.063, 0.062, 0.003])
    """
    if of not in ("estimate", "measurement"):
        raise ValueError(f"`of` must be 'estimate' or 'measurement', got {quoted(of)}")
    runs = as_runs(traces)
    poses = np.array([trace.poses_from(of) for trace in runs])
    truth = np.array([trace.pose_true for trace in runs])
    for values, name in ((truth, "pose_true"), (poses, POSES[of])):
        if np.isnan(values).all():
            runs[0].require(name)
    name = "covariance" if of == "estimate" else "covariance_measured"
    covariances = np.array([getattr(trace, name) for trace in runs])
    is_reported = of == "estimate" or bool(np.isfinite(covariances).any())
    seen = np.array([trace.pose_measured for trace in runs])
    is_compared = of == "estimate" and bool(np.isfinite(seen).any())
    return ErrorReport(
        source=of,
        error=wrapped_error(poses, truth),
        reported_sd=_standard_deviations(covariances) if is_reported else None,
        names=("x", "y", "heading"),
        units=(runs[0].info.unit,) * 2 + ("rad",),
        k=runs[0].k,
        measured=wrapped_error(seen, truth) if is_compared else None,
        bounced=np.array([trace.bounced for trace in runs]).astype(bool),
    )


def as_runs(traces: Trace | Sequence[Trace]) -> list[Trace]:
    """Return a list of runs of the same steps."""
    runs = [traces] if isinstance(traces, Trace) or not isinstance(traces, Iterable) else [*traces]
    if not runs or not all(isinstance(trace, Trace) for trace in runs):
        hint = ": give sim.trace of each" if any(hasattr(one, "trace") for one in runs) else ""
        raise TypeError(f"traces must be a Trace or a sequence of them, got {quoted(traces)}{hint}")
    units = sorted({trace.info.unit for trace in runs})
    if len(units) > 1:
        raise ValueError(f"traces must have the same unit of length, got {', '.join(units)}")
    steps = {(int(trace.k[0]) if len(trace) else 0, len(trace)) for trace in runs}
    if len(steps) > 1 or not len(runs[0]):
        lengths = sorted({len(trace) for trace in runs})
        raise ValueError(f"traces must all have the same steps, at least 1, got lengths {lengths}")
    return runs


def _standard_deviations(covariances: Floats) -> Floats:
    variances = np.diagonal(covariances, axis1=-2, axis2=-1)
    if (variances < 0).any():
        raise ValueError(f"covariance must have no negative variance, got {np.nanmin(variances):g}")
    return np.sqrt(variances)


_MINIMUM_MARGINS = {"cm": 1e-4, "m": 1e-6}


def usual_limits(values: Floats, unit: str = "px") -> tuple[float, float]:
    """Return limits that contain 0 and all values (n,) but those far outside the middle 90 %."""
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
    """Return the number of bins for the histogram of n values within its `usual_limits`."""
    # Rice's rule, 2 n^(1/3), over the 10/13 of the range with values. An odd number, so that one
    # bin is centred in the middle.
    return 2 * int(np.clip(1.3 * n ** (1 / 3), 5, 26)) + 1
