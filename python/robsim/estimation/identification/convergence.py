"""Convergence times of online parameter estimates against the true parameters."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from robsim.base.checks import Floats, as_float_array, check_float
from robsim.base.report import Column, Report, Table
from robsim.estimation.identification._parameter_table import lengths_in, parameter_table
from robsim.estimation.identification.determined import prediction_sigma
from robsim.trace import PARAMETER_NAMES, Trace
from robsim.trace.trace import check_trace


def convergence_time(
    estimate: ArrayLike, truth: ArrayLike, tolerance: ArrayLike, *, t: ArrayLike | None = None
) -> Floats:
    """Return the time at which an estimate enters a band around the truth and stays there.

    Parameters
    ----------
    estimate : array (N, ...)
        Estimates of N steps; NaN = no estimate, which counts as outside the band.
    truth, tolerance : array (...) or float
        The true value and the half width of the band.
    t : array (N,), optional
        Time of each step (s). Default: the row index.

    Returns
    -------
    array (...)
        The time; NaN if the last estimate is outside the band.

    Raises
    ------
    ValueError
        If the shapes do not match.

    Examples
    --------
    >>> error = 0.5 ** np.arange(10)
    >>> float(robsim.estimation.convergence_time(error, 0, 0.1))
    4.0
    """
    history = np.atleast_1d(as_float_array("estimate", estimate))
    times = np.arange(len(history)) if t is None else as_float_array("t", t)
    if not len(history) or times.shape != history.shape[:1]:
        raise ValueError(f"t must have a time for each of {len(history)} steps, got {times.shape}")
    try:
        is_near = np.abs(history - as_float_array("truth", truth)) <= as_float_array(
            "tolerance", tolerance
        )
    except ValueError:
        shapes = f"{np.shape(truth)} and {np.shape(tolerance)}"
        raise ValueError(
            f"truth and tolerance must be of shape {history.shape[1:]}, got {shapes}"
        ) from None
    # The estimate stays from row i on if all rows from i to the last are near.
    rows_at_the_end = np.logical_and.accumulate(is_near[::-1]).sum(axis=0)
    first = len(history) - rows_at_the_end
    return np.where(rows_at_the_end > 0, times[np.minimum(first, len(history) - 1)], np.nan)


@dataclass(frozen=True, kw_only=True, eq=False)
class ConvergenceReport(Report):
    """The convergence times of the online parameter estimates.

    Attributes
    ----------
    theta_true, last, tolerance : array (3, 5)
        True values, last online estimate, half width of the band around the true value; rows X, Y,
        P (heading), columns a1, a2, b1, b2, d1.
    time : array (3, 5)
        Time from the first step of the trace until the estimate stays in the band (s); NaN = not
        in the band at the end.
    identify_from : str
        The data of the online estimate: truth, measurement or estimate.
    spread : array (3, 5)
        Standard errors of the last estimate from the prediction errors; 0 if unknown.
    unit : str
        The unit of lengths, as in the trace.

    Examples
    --------
    >>> options = dict(estimate_parameters=True, identify_from="measurement")
    >>> sim = robsim.Simulation(seed=1, control=robsim.DriveAround(), measure=True, **options)
    >>> report = robsim.estimation.parameter_convergence(sim.run(300))
    >>> report.verdict, [f"{theta[2, 0]:.1f}" for theta in (report.theta_true, report.last)]
    ('not converged', ['1.8', '1.2'])
    """

    theta_true: Floats
    last: Floats
    tolerance: Floats
    time: Floats
    identify_from: str = "truth"
    spread: Floats = field(default_factory=lambda: np.zeros((3, 5)))
    unit: str = "px"

    @property
    def title(self) -> str:
        """The source of the online estimate."""
        return f"Online estimate from {self.identify_from}{lengths_in(self.unit)}"

    @property
    def verdict(self) -> str:
        """Return ``"converged"``, or ``"not converged"`` if a parameter is not near at the end."""
        return "not converged" if np.isnan(self.time).any() else "converged"

    @property
    def at_limit(self) -> bool:
        """Whether a change of the last estimates by one `spread` changes the verdict."""
        error = np.abs(self.last - self.theta_true)
        better, worse = error - self.spread, error + self.spread
        return bool((better <= self.tolerance).all() != (worse <= self.tolerance).all())

    @property
    def tables(self) -> tuple[Table, ...]:
        """True value, last estimate, tolerance and convergence time of each parameter."""
        time = Column("time", "stays near from", "s", ".4g", missing="not near at the end")
        columns = {
            Column("true", "true value", format=".5g"): self.theta_true,
            Column("last", "last estimate", format=".5g"): self.last,
            Column("tolerance", "tolerance", format=".2g"): self.tolerance,
            time: self.time,
        }
        return (parameter_table(columns),)

    @property
    def remarks(self) -> tuple[str, ...]:
        """The definition of "near", and the decisive numbers if the verdict is at the limit."""
        near = "near: within the tolerance of the true value, from then on until the end"
        if self.identify_from != "truth":
            near += (
                f"; from the {self.identify_from}, least squares is biased, however long it runs"
            )
        if not self.at_limit:
            return (near,)
        name = PARAMETER_NAMES[int(np.argmin(self._margins()))]
        return (
            near,
            f"at the limit: {name} is within its standard error of the limit of its tolerance, so "
            "that another run may give another verdict",
        )

    def _margins(self) -> Floats:
        """Return the distance of each last estimate from its limit in standard errors, (3, 5)."""
        distance = np.abs(np.abs(self.last - self.theta_true) - self.tolerance)
        with np.errstate(divide="ignore", invalid="ignore"):
            margins = distance / self.spread
        return np.where(np.isnan(margins), np.inf, margins)


def parameter_convergence(
    trace: Trace, *, tolerance: float = 0.01, offset_tolerance: float = 1e-3
) -> ConvergenceReport:
    """Return the times after which the online parameter estimates stay near the true values.

    Parameters
    ----------
    trace : Trace
        A run with ``estimate_parameters=True``.
    tolerance : float
        Half width of the band of a1, a2, b1 and b2, relative to the true value.
    offset_tolerance : float
        Half width of the band of d1, whose true value may be 0 (px, px, rad), in the trace's unit
        as well.

    Returns
    -------
    ConvergenceReport
        Times since the first step of the trace; print it.

    Raises
    ------
    NotRecordedError
        If the trace has no parameter estimates, or no true parameters.
    TypeError, ValueError
        If an argument has the wrong type or is out of range.

    Examples
    --------
    >>> sim = robsim.Simulation(seed=1, control=robsim.DriveAround(), estimate_parameters=True)
    >>> report = robsim.estimation.parameter_convergence(sim.run(100))
    >>> report.time[2, :2].round(1)
    array([0.8, 0.8])
    """
    check_trace(trace)
    relative = check_float("tolerance", tolerance, exclusive_minimum=0.0)
    offset = check_float("offset_tolerance", offset_tolerance, exclusive_minimum=0.0)
    theta_true = np.array(trace.info.theta_true)
    trace.require("parameters", "theta_true")
    half_width = relative * np.abs(theta_true)
    half_width[:, 4] = offset * np.array((trace.info.px_length, trace.info.px_length, 1.0))
    return ConvergenceReport(
        theta_true=theta_true,
        last=np.array(trace.parameters[-1]),
        tolerance=half_width,
        time=convergence_time(trace.parameters, theta_true, half_width, t=trace.t - trace.t[0]),
        identify_from=trace.info.identify_from,
        spread=_spread(trace),
        unit=trace.info.unit,
    )


def _spread(trace: Trace) -> Floats:
    """Return the standard errors of the last estimates, (3, 5); 0 if unknown."""
    sigma, _ = prediction_sigma(trace, trace.parameters[-1])
    spread = sigma[:, np.newaxis] * trace.standard_errors_unscaled[-1]
    return np.asarray(np.nan_to_num(spread, posinf=0.0))
