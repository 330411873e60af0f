"""Convergence times of online parameter estimates against the true parameters."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from robsim._base.checks import Floats, as_float_array, check_float
from robsim.trace import PARAMETER_NAMES, Trace
from robsim.trace._trace import check_trace


def convergence_time(
    estimate: ArrayLike, truth: ArrayLike, tolerance: ArrayLike, *, t: ArrayLike | None = None
) -> Floats:
    """Return the time at which an estimate enters a band around the truth and stays there.

    Parameters
    ----------
    estimate : array (N, ...)
        Estimates of N steps; NaN = none, which is outside the band.
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
        If the shapes do not fit together.
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
class ConvergenceReport:
    """The convergence times of the online parameter estimates.

    Attributes
    ----------
    theta_true, last, tolerance : array (3, 5)
        True values, last online estimate, half width of the band around the true value; rows X, Y,
        P (heading), columns a1, a2, b1, b2, d1.
    time : array (3, 5)
        Time from the first step of the trace until the estimate stays in the band (s); NaN = not
        in the band at the end.
    title : str
        The first line of the report.
    """

    theta_true: Floats
    last: Floats
    tolerance: Floats
    time: Floats
    title: str

    def to_dict(self) -> dict[str, dict[str, float | None]]:
        """Return name -> {"true", "last", "tolerance", "time"}; None = not known."""
        keys = ("true", "last", "tolerance", "time")
        columns = (self.theta_true, self.last, self.tolerance, self.time)
        return {
            name: {
                key: float(value) if np.isfinite(value) else None
                for key, value in zip(keys, values, strict=True)
            }
            for name, *values in zip(PARAMETER_NAMES, *map(np.ravel, columns), strict=True)
        }

    def _rows(self) -> list[tuple[str, ...]]:
        def text(value: float | None, otherwise: str = "-") -> str:
            return otherwise if value is None else f"{value:.5g}"

        return [
            (
                name,
                text(values["true"]),
                text(values["last"]),
                f"{values['tolerance']:.2g}",
                text(values["time"], "not near at the end"),
            )
            for name, values in self.to_dict().items()
        ]

    def __str__(self) -> str:
        rows = [
            f"{name:<6}{true:>14}{last:>16}{tolerance:>12}{time:>22}"
            for name, true, last, tolerance, time in [_TITLES, *self._rows()]
        ]
        return "\n".join([self.title, *rows])

    def _repr_html_(self) -> str:
        head = "".join(f"<th>{title}</th>" for title in _TITLES)
        body = "".join(
            f"<tr>{''.join(f'<td>{text}</td>' for text in row)}</tr>" for row in self._rows()
        )
        return f"<p>{self.title}</p><table><tr>{head}</tr>{body}</table>"


_TITLES = ("", "True value", "Last estimate", "Tolerance", "Stays near from (s)")


def parameter_convergence(
    trace: Trace, *, tolerance: float = 0.01, offset_tolerance: float = 1e-3
) -> ConvergenceReport:
    """Return the times from which on the online parameter estimates stay near the true values.

    Parameters
    ----------
    trace : Trace
        A run with ``estimate_parameters=True``.
    tolerance : float
        Half width of the band of a1, a2, b1 and b2, relative to the true value.
    offset_tolerance : float
        Half width of the band of d1, whose true value may be 0 (px, px, rad).

    Returns
    -------
    ConvergenceReport
        Times since the first step of the trace; print it.

    Raises
    ------
    TypeError, ValueError
        If the trace has no parameter estimates or no true parameters, or an argument has the wrong
        type or is out of range.
    """
    check_trace(trace)
    relative = check_float("tolerance", tolerance, exclusive_minimum=0.0)
    offset = check_float("offset_tolerance", offset_tolerance, exclusive_minimum=0.0)
    theta_true = np.array(trace.info.theta_true)
    if not (np.isfinite(trace.parameters).any() and np.isfinite(theta_true).all()):
        raise ValueError(
            "the trace must have parameter estimates and true parameters: run the simulation with "
            "estimate_parameters=True"
        )
    half_width = relative * np.abs(theta_true)
    half_width[:, 4] = offset
    return ConvergenceReport(
        theta_true=theta_true,
        last=np.array(trace.parameters[-1]),
        tolerance=half_width,
        time=convergence_time(trace.parameters, theta_true, half_width, t=trace.t - trace.t[0]),
        title=f"Online estimate from {trace.info.identify_from}: when it stays near the truth",
    )
