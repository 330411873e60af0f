"""Batch identification of the robot model from a recorded run, and its report."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Any, NotRequired, TypedDict

import numpy as np
from numpy.typing import NDArray

from robsim._core import least_squares
from robsim.base.checks import Floats, check_choice
from robsim.base.report import Column, Quantity, Report, Table
from robsim.base.text import quoted
from robsim.estimation.identification._parameter_table import (
    contradiction_remarks,
    equation_noise,
    lengths_in,
    mean_ratio,
    noise_remarks,
    parameter_table,
)
from robsim.estimation.identification.determined import Identifiability, identifiability, judge
from robsim.estimation.identification.fits import METHODS
from robsim.estimation.identification.fits.linear import decompose
from robsim.estimation.identification.fits.model_fit import (
    LONGEST_DELAY,
    ModelFit,
    check_delay_or_fit,
    delay_quantities,
)
from robsim.estimation.identification.regressions import (
    Regression,
    inputs_of,
    interruptions,
    regression_of,
)
from robsim.trace import PARAMETER_NAMES, NotRecordedError, Trace
from robsim.trace.columns import POSES
from robsim.trace.trace import check_trace
from robsim.trace.units import scaled

_MINIMUM_SAMPLES = 5
_ROUNDING = 1e-6  # px and rad
_UNSEEN = 0.1  # standard errors: a smaller move of the estimates does not matter.
_WIDEST = 4.0  # standard errors of a fitted delay, around its true value.
# A model without mismatch has a smaller p-value in one of 1000 runs.
_OTHER_MODEL = 1e-3 / 3
_AXES = ("X", "Y", "P")
_METHODS = ("least_squares", *METHODS)


class _Fit(TypedDict):
    """The fields of `BatchEstimate` that the method determines."""

    motor_delay: float
    motor_delay_error: float
    white_noise_errors: NotRequired[Floats]
    whiteness_p_value: NotRequired[float]
    process_sigma: NotRequired[Floats]
    measurement_sigma: NotRequired[Floats]
    measurement_correlation: NotRequired[Floats]
    least_squares_errors: NotRequired[Floats]
    batch: Floats
    rank: NDArray[np.int64]
    condition: Floats
    residual_rms: Floats
    standard_errors: Floats
    standard_errors_unscaled: Floats
    converged: bool


def _unknown() -> Floats:
    return np.full((3, 5), np.nan)


@dataclass(frozen=True, kw_only=True, eq=False)
class BatchEstimate(Report):
    """The parameters of the robot model, estimated from a whole run.

    Attributes
    ----------
    theta_true, batch, online : array (3, 5)
        The model's own values, the batch estimate and the last online estimate; rows X, Y, P
        (heading), columns a1, a2, b1, b2, d1. NaN = the run does not determine the parameter, or no
        online estimate.
    identify_from, online_from : str
        The data of the batch and of the online estimate: truth, measurement or estimate.
    start, stop : int
        The steps start..stop - 1 were used.
    rank : array (3,) of int
        Rank of the regressors of each axis; 5 = all parameters are determined.
    condition : array (3,)
        Condition number of the regressors of each axis, scaled to length 1; NaN for a method other
        than least squares.
    residual_rms : array (3,)
        Root mean square of the one-step prediction error (x, y in `unit`, heading in rad); for a
        method other than least squares, of the residuals of its fit.
    standard_errors : array (3, 5)
        Standard errors of `batch`, with the noise estimated from the residuals. For least squares,
        the standard errors are valid for equation noise; measurement noise also causes a bias. For
        the other methods, they are the `white_noise_errors` unless the residuals contradict these.
        In that case they include the estimated process noise or the correlation of the measurement
        noise. The standard errors do not cover a wrong model.
    white_noise_errors : array (3, 5)
        Standard errors of a method other than least squares for measurement noise alone,
        independent from step to step; otherwise NaN. The errors of a camera partly depend on the
        pose, so they are similar in neighbouring steps.
    standard_errors_unscaled : array (3, 5)
        Standard errors for noise of standard deviation 1 (x, y in `unit`, heading in rad).
    n_samples : int, optional
        Number of samples. Default: all steps start..stop - 1, without interruption.
    left_out : int
        Number of samples omitted because they span a bounce, a missing pose or lost frames.
    select : str
        The selection of samples: valid, longest or all.
    method : str
        The method: least_squares, instrumental_variables or output_error.
    converged : bool
        Whether the method converged; if not, `batch` is the result of its last iteration.
    model_error : array (3,)
        Root mean square one-step prediction error of `theta_true` on the true path (x, y in `unit`,
        heading in rad). `departure` gives the reason if it is not 0.
    motor_delay, motor_delay_error : float
        Delay of the inputs (steps), and its standard error if it was estimated, otherwise 0.
    whiteness_p_value : float
        Probability that residuals without process noise are as far from white; NaN for least
        squares. A probability below 0.05 contradicts the `white_noise_errors`.
    process_sigma, measurement_sigma : array (3,)
        Standard deviations of process noise and measurement noise in a step, from the residuals (x,
        y in `unit`, heading in rad); NaN for least squares.
    measurement_correlation : array (3,)
        Correlation of the coloured part of the measurement noise from step to step; 0 = white, NaN
        for least squares.
    least_squares_errors : array (3, 5)
        The root mean square errors, with bias, of least squares under this noise; NaN for least
        squares.
    departure : str
        The robot's departure from its model, according to the trace: ``"none"``, ``"process
        noise"``, ``"mismatch"`` (other parameters or equations), or ``"unknown"``. It is also
        ``"none"`` if a fitted delay explains `model_error`, or if `model_error` moves `batch` by
        less than a tenth of its standard errors.
    unit : str
        The unit of lengths, as in the trace.
    px_length : float
        Length of a px of the work area in that unit.
    """

    theta_true: Floats
    batch: Floats
    online: Floats
    identify_from: str
    start: int
    stop: int
    rank: NDArray[np.int64]
    condition: Floats
    residual_rms: Floats
    online_from: str = "truth"
    standard_errors: Floats = field(default_factory=_unknown)
    standard_errors_unscaled: Floats = field(default_factory=_unknown)
    n_samples: int | None = None
    left_out: int = 0
    select: str = "valid"
    method: str = "least_squares"
    converged: bool = True
    model_error: Floats = field(default_factory=lambda: np.zeros(3))
    motor_delay: float = 0.0
    motor_delay_error: float = 0.0
    white_noise_errors: Floats = field(default_factory=_unknown)
    whiteness_p_value: float = math.nan
    process_sigma: Floats = field(default_factory=lambda: np.full(3, np.nan))
    measurement_sigma: Floats = field(default_factory=lambda: np.full(3, np.nan))
    measurement_correlation: Floats = field(default_factory=lambda: np.full(3, np.nan))
    least_squares_errors: Floats = field(default_factory=_unknown)
    departure: str = "unknown"
    unit: str = "px"
    px_length: float = 1.0

    @property
    def _samples(self) -> int:
        return self.stop - self.start - 2 if self.n_samples is None else self.n_samples

    @property
    def title(self) -> str:
        """The data and the method of the estimate, in one line."""
        kind = {"longest": ", the longest segment", "all": ", bounces included"}
        method = "" if self.method == "least_squares" else f" by {self.method.replace('_', ' ')}"
        return (
            f"Batch estimate from {self.identify_from}{method}, steps "
            f"{self.start}..{self.stop - 1} ({self._samples} samples{kind.get(self.select, '')})"
            f"{lengths_in(self.unit)}"
        )

    @property
    def is_model_exact(self) -> bool:
        """Whether the robot moved like its model, within the resolution of the estimate."""
        return self.departure == "none" or not self.model_error.any()

    @property
    def knows_truth(self) -> bool:
        """Whether `theta_true` is the truth: the model is exact, except for process noise."""
        return self.is_model_exact or self.departure == "process noise"

    @property
    def identifiability(self) -> Identifiability:
        """The identifiability of each parameter in this run.

        For true poses, which have no noise, a value of sigma is assumed; otherwise sigma comes from
        the residuals.
        """
        n_samples = self._samples
        if self.identify_from == "truth":
            return judge(
                self.standard_errors_unscaled,
                self.batch,
                freedom=max(n_samples - 5, 1),
                unit=self.unit,
                px_length=self.px_length,
            )
        freedom = np.maximum(n_samples - self.rank, 1)
        sigma = self.residual_rms
        if self.method == "least_squares":
            sigma = sigma * np.sqrt(n_samples / freedom)
        return judge(
            self.standard_errors_unscaled,
            self.batch,
            sigma=sigma,
            freedom=float(freedom.min()),
            identify_from=self.identify_from,
            unit=self.unit,
        )

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """The delay of the inputs, if it is not 0."""
        return delay_quantities(self.motor_delay, self.motor_delay_error)

    @property
    def tables(self) -> tuple[Table, ...]:
        """True value, batch estimate with standard error, and online estimate of each parameter."""
        true = "true value" if self.knows_truth else "model's value"
        errors = np.where(np.isfinite(self.batch), self.standard_errors, np.nan)
        columns = {
            Column("true", true, format=".5g"): self.theta_true,
            Column("batch", "batch estimate", format=".5g"): self.batch,
            Column("standard_error", "standard error", format=".2g"): errors,
        }
        if self._has_online:
            columns[Column("online", "online estimate", format=".5g")] = self.online
        verdicts = {Column("excited", "excited"): self.identifiability.verdict_texts}
        return (parameter_table(columns | verdicts),)

    @property
    def _has_online(self) -> bool:
        return bool(np.isfinite(self.online).any())

    @property
    def remarks(self) -> tuple[str, ...]:
        """The limitations of the estimate."""
        remarks = [
            f"{axis}: the run does not determine {', '.join(missing)}; excite the robot more"
            for axis, missing in zip(_AXES, self._missing(), strict=True)
            if missing
        ]
        if not self.converged:
            remarks.append("the fit did not converge: do not trust it")
        if self.left_out:
            remarks.append(
                f"{self.left_out} samples with a bounce, a missing pose or lost frames are omitted"
            )
        if not self.is_model_exact:
            error = equation_noise(self.model_error, self.unit, ".2g")
            remarks.append(
                f"process noise moves the robot ({error} per step): the model's values are true"
                if self.departure == "process noise"
                else f"the robot does not move as its model predicts (rmse {error} per step): the "
                "model's values need not be true"
            )
        if not self._has_online:
            remarks.append("no online estimate: run with estimate_parameters=True")
        elif self.online_from != self.identify_from:
            remarks.append(f"the online estimate is from {self.online_from}")
        excited = self.identifiability
        noise = self._contradiction or (
            *(excited._on_methods if self.method == "least_squares" else ()),
            *noise_remarks(self.identify_from),
        )
        return (*remarks, *excited._on_excitation, *noise)

    @property
    def _contradiction(self) -> tuple[str, ...]:
        """Remarks on residuals that contradict measurement noise alone."""
        remarks = contradiction_remarks(
            self.whiteness_p_value,
            self.standard_errors,
            self.white_noise_errors,
            self.process_sigma,
            self.measurement_correlation,
            unit=self.unit,
            departure=self.departure,
        )
        gain = mean_ratio(self.standard_errors, self.least_squares_errors)
        if not remarks or gain <= 1:
            return remarks
        better = f"least squares is the better method here: its errors are {gain:.2g} times smaller"
        return (*remarks, better)

    def _missing(self) -> list[list[str]]:
        """Return the names of the parameters that the run does not determine, by axis."""
        names = np.reshape(PARAMETER_NAMES, (3, 5))
        return [list(names[axis][np.isnan(self.batch[axis])]) for axis in range(3)]


def batch_estimate(
    trace: Trace,
    *,
    identify_from: str | None = None,
    select: str = "valid",
    method: str = "least_squares",
    motor_delay: float | str = 0.0,
) -> BatchEstimate:
    """Estimate the parameters of the robot model from a whole run.

    Least squares from measured poses is biased, since the regressors contain the noise, too. The
    other methods are asymptotically unbiased, and assume measurement noise alone. If the residuals
    show process noise, the standard errors of these methods include it. The report then also names
    the better method.

    Parameters
    ----------
    trace : Trace
        The recorded run.
    identify_from : str, optional
        ``"truth"``, ``"measurement"`` or ``"estimate"``. Default: the source of the trace's own
        online estimate.
    select : str
        ``"valid"``: all samples except those that span a bounce, a step without a pose or lost
        frames. ``"longest"``: the samples of the longest segment without an interruption.
        ``"all"``: also samples that span a bounce, to see their effect.
    method : str
        ``"least_squares"``, ``"instrumental_variables"`` or ``"output_error"``; see the functions
        of these names.
    motor_delay : float or str
        Delay of the inputs (steps of the model), 0..1000: the `motor_delay` of a simulated world,
        the ``trace.timing().motor_delay`` of a live one. ``"fit"``: estimate it, too, within 0..10
        steps, with the method ``"output_error"``. The delay refers to ``trace.u``, or to
        ``trace.last_u`` if the frames reported the motors' inputs.

    Returns
    -------
    BatchEstimate
        The report; print it, or put it at the end of a notebook cell.

    Raises
    ------
    NotRecordedError
        If the trace lacks these poses.
    TypeError, ValueError
        If `trace` is not a Trace, it has too few samples, or a name is unknown; if the time
        between two steps is not a multiple of the model's dt.

    Examples
    --------
    >>> control = robsim.control.PseudoRandomBinary()
    >>> report = robsim.batch_estimate(robsim.Simulation(seed=1, control=control).run(200))
    >>> report.batch[2, :2].round(3), report.n_samples
    (array([ 1.833, -0.833]), 198)
    """
    check_trace(trace)
    # The fits are made for px.
    info, trace = trace.info, trace.in_unit("px")
    check_choice("method", method, _METHODS)
    delay = check_delay_or_fit(motor_delay)
    if delay is None and method != "output_error":
        raise ValueError(f"motor_delay='fit' requires method='output_error', got {quoted(method)}")
    found = regression_of(
        trace,
        identify_from=identify_from,
        select=select,
        motor_delay=LONGEST_DELAY if delay is None else delay,
    )
    if len(found.k) < _MINIMUM_SAMPLES:
        trace.require(POSES[found.identify_from])
        where = "the longest stretch of" if select == "longest" else "all"
        raise ValueError(
            f"a batch estimate from {found.identify_from} needs at least {_MINIMUM_SAMPLES} "
            f"samples, got {len(found.k)} in {where} {len(trace)} steps; a sample needs three "
            "consecutive steps"
        )
    trace.require("u")
    start, stop = int(found.k[0]) - 2, int(found.k[-1]) + 1
    fit = (
        _least_squares(found, delay)
        if method == "least_squares" and delay is not None
        else _fitted(trace, found, start, stop, select, method, delay)
    )
    model_error, departure = _departure(trace, fit)
    report = BatchEstimate(
        theta_true=np.array(trace.info.theta_true),
        online=np.array(trace.parameters[-1]),
        identify_from=found.identify_from,
        online_from=trace.info.identify_from,
        start=start,
        stop=stop,
        n_samples=len(found.k),
        left_out=found.left_out,
        select=select,
        method=method,
        model_error=model_error,
        departure=departure,
        **fit,
    )
    return report if info.unit == "px" else _converted(report, info.unit, info.px_length)


def _converted(report: BatchEstimate, unit: str, px_length: float) -> BatchEstimate:
    """Return a report in px with lengths in another unit."""
    lengths = np.array((px_length, px_length, 1.0))
    parameters: dict[str, Any] = {
        name: scaled("parameters", getattr(report, name), px_length)
        for name in (
            *("theta_true", "batch", "online", "standard_errors"),
            *("white_noise_errors", "least_squares_errors"),
        )
    }
    unscaled = report.standard_errors_unscaled
    return replace(
        report,
        **parameters,
        standard_errors_unscaled=scaled("standard_errors_unscaled", unscaled, px_length),
        residual_rms=report.residual_rms * lengths,
        process_sigma=report.process_sigma * lengths,
        measurement_sigma=report.measurement_sigma * lengths,
        model_error=report.model_error * lengths,
        unit=unit,
        px_length=px_length,
    )


def _least_squares(found: Regression, motor_delay: float) -> _Fit:
    fits = [least_squares(found.phi[:, axis], found.y[:, axis]) for axis in range(3)]
    return {
        "batch": np.array([fit.theta for fit in fits]),
        "rank": np.array([fit.rank for fit in fits]),
        "condition": np.array([fit.condition for fit in fits]),
        "residual_rms": np.array([fit.residual_rms for fit in fits]),
        "standard_errors": np.array([fit.standard_errors for fit in fits]),
        "standard_errors_unscaled": np.array([fit.standard_errors_unscaled for fit in fits]),
        "converged": True,
        "motor_delay": motor_delay,
        "motor_delay_error": 0.0,
    }


def _fitted(
    trace: Trace,
    found: Regression,
    start: int,
    stop: int,
    select: str,
    method: str,
    delay: float | None,
) -> _Fit:
    # Late inputs from before the first used pose still act on the used poses.
    before = start - int(trace.k[0])
    record = trace[: stop - int(trace.k[0])]
    poses, u = record.poses_from(found.identify_from).copy(), inputs_of(record)
    poses[:before], u[:before] = np.nan, np.nan_to_num(u[:before])
    breaks = interruptions(
        record,
        over_bounces=select == "all",
        motor_delay=LONGEST_DELAY if delay is None else delay,
    )
    fit = METHODS[method](poses, u, breaks=breaks, motor_delay="fit" if delay is None else delay)
    sigma = np.maximum(fit.residual_rms, np.finfo(float).tiny)
    return {
        "batch": fit.theta,
        "rank": fit.determined.sum(axis=1),
        "condition": np.full(3, np.nan),
        "residual_rms": fit.residual_rms,
        "standard_errors": np.where(fit.determined, fit.standard_errors, np.nan),
        "standard_errors_unscaled": fit.standard_errors / sigma[:, np.newaxis],
        "white_noise_errors": np.where(fit.determined, fit.white_noise_errors, np.nan),
        "whiteness_p_value": fit.whiteness_p_value,
        "process_sigma": fit.process_sigma,
        "measurement_sigma": fit.measurement_sigma,
        "measurement_correlation": fit.measurement_correlation,
        "least_squares_errors": _least_squares_errors(found, fit),
        "converged": fit.converged,
        "motor_delay": fit.motor_delay,
        "motor_delay_error": fit.motor_delay_error,
    }


def _least_squares_errors(found: Regression, fit: ModelFit) -> Floats:
    """Return the root mean square errors (3, 5) of least squares under the noise of a fit."""
    theta = np.nan_to_num(fit.theta)
    errors = []
    for axis in range(3):
        a1, a2 = theta[axis, :2]
        w, e = fit.process_sigma[axis], fit.measurement_sigma[axis]
        parts = decompose(found.phi[:, axis])
        root = parts.inverse / parts.lengths[:, np.newaxis]
        # y - phi theta = w(k) + e(k) - a1 e(k-1) - a2 e(k-2), and phi has x + e of k-1 and k-2:
        # bias = -n e^2 (phi' phi)^-1 (a1, a2, 0, 0, 0)
        bias = len(found.k) * e**2 * root @ (root[:2].T @ (a1, a2))
        by_sample = np.pad(parts.U @ root.T, ((2, 2), (0, 0)))
        by_pose = by_sample[:-2] - a1 * by_sample[1:-1] - a2 * by_sample[2:]
        errors.append(np.linalg.norm(np.vstack([bias, w * by_sample, e * by_pose]), axis=0))
    return np.array(errors)


def _departure(trace: Trace, fit: _Fit) -> tuple[Floats, str]:
    """Return the rms one-step errors of the model (3,), and the departure of the robot from it."""
    found = regression_of(trace, identify_from="truth", motor_delay=fit["motor_delay"])
    n, theta = len(found.k), np.array(trace.info.theta_true)
    if not n or np.isnan(theta).any():
        return np.zeros(3), "unknown"
    errors = found.y - np.sum(found.phi * theta, axis=2)
    rmse: Floats = np.sqrt(np.mean(np.square(errors), axis=0))
    # Errors m move the estimates by at most sqrt(n) m / e standard errors, with residuals e.
    unseen = _UNSEEN * fit["residual_rms"] / math.sqrt(n)
    # By a delay that is wrong by d, the inputs are wrong by d of their change in a step.
    change = np.diff(np.sum(found.phi[:, :, 2:4] * theta[:, 2:4], axis=2), axis=0)
    late = _WIDEST * fit["motor_delay_error"] * np.sqrt(np.square(change).sum(axis=0) / n)
    if (rmse <= np.maximum(_ROUNDING, np.maximum(unseen, late))).all():
        return rmse, "none"
    if n <= _MINIMUM_SAMPLES:
        return rmse, "mismatch"
    from scipy.special import fdtrc  # it takes long to load

    # Process noise leaves the model the best one: F tests whether another one is better.
    left = [least_squares(found.phi[:, axis], found.y[:, axis]).residual_rms for axis in range(3)]
    square = np.maximum(np.square(left), np.finfo(float).tiny)
    F = (np.square(rmse) / square - 1) * (n - 5) / 5
    is_other = fdtrc(5, n - 5, np.maximum(F, 0.0)) < _OTHER_MODEL
    return rmse, "mismatch" if is_other.any() else "process noise"


def judged(trace: Trace) -> Identifiability | None:
    """Return the identifiability; for an estimator without standard errors, from the samples."""
    try:
        return identifiability(trace)
    except NotRecordedError:
        pass
    try:
        return batch_estimate(trace).identifiability
    except ValueError:  # still too few samples
        return None
