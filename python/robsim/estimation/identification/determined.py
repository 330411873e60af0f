"""Identifiability of each parameter in a run: standard errors relative to the parameter."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robsim.base.checks import Floats, as_float_array, check_choice, check_int
from robsim.base.report import Column, Report, Table, percent
from robsim.base.text import quoted
from robsim.estimation.identification._parameter_table import (
    equation_noise,
    lengths_in,
    noise_remarks,
    parameter_table,
)
from robsim.estimation.identification.regressions import regression_of
from robsim.trace import PARAMETER_NAMES, Trace
from robsim.trace.trace import check_trace

#: Assumed standard deviations of the equation noise of x, y (px) and heading (rad) for true poses,
#: which have no noise.
ASSUMED_SIGMA = (0.1, 0.1, 0.005)

#: Maximum standard error, relative to the parameter, of well and poorly determined ones.
WELL, POORLY = 0.05, 0.5

_VERDICTS = ("well", "poorly", "not excited")


@dataclass(frozen=True, kw_only=True, eq=False)
class Identifiability(Report):
    """The identifiability of each parameter from the samples so far.

    Attributes
    ----------
    standard_errors : array (3, 5)
        Standard errors of the parameters, rows X, Y, P (heading), columns a1, a2, b1, b2, d1: the
        Cramér-Rao bound for process noise of `sigma`; for measured poses the least error of
        least squares. inf = not determined at all, NaN = no samples yet.
    relative : array (3, 5)
        Standard errors as a fraction of the parameter's magnitude; for d1, which may be 0, as a
        fraction of the larger of b1 and b2, the effect of 1 V.
    sigma : array (3,)
        Standard deviations of the equation noise of x, y (in `unit`) and heading (rad).
    is_assumed : bool
        Whether sigma is `ASSUMED_SIGMA`, since true poses have no noise; otherwise it was given, or
        comes from the prediction errors.
    relative_range : array (2, 3, 5)
        `relative` with the parameter and sigma, which are estimates, too, one standard deviation
        better and worse; equal for true poses and a given sigma.
    identify_from : str
        The data of the estimates: truth, measurement or estimate.
    unit : str
        The unit of lengths, as in the trace.

    Examples
    --------
    >>> sim = robsim.Simulation(control=robsim.Spin(), estimate_parameters=True, seed=1)
    >>> print(robsim.identifiability(sim.run(100)).verdict)
    not excited
    """

    standard_errors: Floats
    relative: Floats
    sigma: Floats
    is_assumed: bool
    relative_range: Floats
    identify_from: str = "truth"
    unit: str = "px"

    @property
    def verdicts(self) -> NDArray[np.str_]:
        """Array (3, 5): ``"well"``, ``"poorly"`` or ``"not excited"``.

        "well" means that the standard error is at most 5 % of the parameter, "poorly" at most 50 %.
        """
        return _verdicts(self.relative)

    @property
    def are_at_limit(self) -> NDArray[np.bool_]:
        """Array (3, 5): whether each verdict changes within the `relative_range`."""
        better, worse = map(_verdicts, self.relative_range)
        return np.asarray(better != worse)

    @property
    def verdict_texts(self) -> NDArray[np.str_]:
        """The `verdicts` as text for a table, with a remark on verdicts at the limit, (3, 5)."""
        suffixes = np.where(self.are_at_limit, ", at the limit", "")
        return np.char.add(self.verdicts, suffixes)

    def names(self, verdict: str) -> list[str]:
        """Return the names of the parameters with this verdict: ``["a1X", ...]``.

        Parameters
        ----------
        verdict : str
            ``"well"``, ``"poorly"`` or ``"not excited"``.
        """
        check_choice("verdict", verdict, _VERDICTS)
        return [
            name
            for name, given in zip(PARAMETER_NAMES, self.verdicts.ravel(), strict=True)
            if given == verdict
        ]

    @property
    def title(self) -> str:
        """The subject of the report: the excitation of the parameters."""
        return f"Excitation of the parameters{lengths_in(self.unit)}"

    @property
    def verdict(self) -> str:
        """The verdict on the worst-determined parameter."""
        return _worst(self.verdicts)

    @property
    def at_limit(self) -> bool:
        """Whether `verdict` differs within the `relative_range`."""
        better, worse = map(_verdicts, self.relative_range)
        return _worst(better) != _worst(worse)

    @property
    def tables(self) -> tuple[Table, ...]:
        """The standard error (also relative to the parameter) and the verdict of each parameter."""
        columns = {
            Column("standard_error", "standard error", format=".2g"): self.standard_errors,
            Column("relative", "relative", format=percent): self.relative,
            Column("excited", "excited"): self.verdict_texts,
        }
        return (parameter_table(columns),)

    @property
    def remarks(self) -> tuple[str, ...]:
        """The definitions of the verdicts, and their uncertainty."""
        return (*self._on_excitation, *self._on_methods, *noise_remarks(self.identify_from))

    @property
    def _on_excitation(self) -> tuple[str, ...]:
        source = " (assumed)" if self.is_assumed else ""
        remarks = [
            f"excited well: standard error at most {percent(WELL, 0)} of the parameter (of d1: "
            f"of b1 or b2), poorly: at most {percent(POORLY, 0)}, for noise of "
            f"{equation_noise(self.sigma, self.unit)} in each step{source}"
        ]
        if self.are_at_limit.any():
            remarks.append(
                "at the limit: the standard error relative to the parameter is random itself. It "
                "is "
                "one standard deviation from the limit or less: another run may give another "
                "verdict"
            )
        return tuple(remarks)

    @property
    def _on_methods(self) -> tuple[str, ...]:
        """A remark on least squares from measured poses."""
        remark = (
            "this is for least squares: batch_estimate(trace, method='output_error') may be 100 "
            "times as exact where measurement noise dominates"
        )
        return (remark,) if self.identify_from == "measurement" else ()


def _range(relative: Floats, freedom: float, *, is_random: bool) -> Floats:
    """Return relative standard errors, one standard deviation better and worse, (2, 3, 5)."""
    with np.errstate(divide="ignore", invalid="ignore"):
        # t = |theta| / s, where theta varies by s, and s by s / sqrt(2 freedom)
        t = 1.0 / relative
        spread = np.sqrt(is_random + np.square(t) / (2.0 * freedom))
        edges = 1.0 / np.array((t + spread, np.maximum(t - spread, 0.0)))
    is_inexact = (spread > 0) & np.isfinite(spread)
    return np.where(is_inexact, edges, relative)


def _verdicts(relative: Floats) -> NDArray[np.str_]:
    # These comparisons are False for NaN, which is thus not excited.
    return np.select([relative <= WELL, relative <= POORLY], _VERDICTS[:2], _VERDICTS[2])


def _worst(verdicts: NDArray[np.str_]) -> str:
    return max(verdicts.ravel().tolist(), key=_VERDICTS.index)


def judge(
    standard_errors_unscaled: ArrayLike,
    theta: ArrayLike,
    *,
    sigma: ArrayLike | None = None,
    freedom: float = math.inf,
    identify_from: str = "truth",
    unit: str = "px",
    px_length: float = 1.0,
) -> Identifiability:
    """Return the identifiability of parameters theta (3, 5) from their unscaled standard errors.

    Unscaled errors (3, 5), of noise 1, are the roots of the diagonal of (phi' phi)^-1. `sigma` (3,)
    is the equation noise (`unit`, `unit`, rad), by default `ASSUMED_SIGMA`, estimated with
    `freedom` degrees of freedom; inf = known. `px_length` is the length of a px in the unit.
    """
    assumed = np.multiply(ASSUMED_SIGMA, (px_length, px_length, 1.0))
    values = np.array(as_float_array("sigma", assumed if sigma is None else sigma))
    if values.shape != (3,) or not (np.isfinite(values) & (values >= 0)).all():
        raise ValueError(
            f"sigma must be three numbers of at least 0 ({unit}, {unit}, rad), got {quoted(sigma)}"
        )
    size = np.abs(np.asarray(theta, dtype=np.float64))
    size[:, 4] = size[:, 2:4].max(axis=1)
    errors = values[:, np.newaxis] * np.asarray(standard_errors_unscaled, dtype=np.float64)
    with np.errstate(divide="ignore", invalid="ignore"):
        relative = errors / size
    return Identifiability(
        standard_errors=errors,
        relative=relative,
        sigma=values,
        is_assumed=sigma is None,
        relative_range=_range(relative, freedom, is_random=identify_from != "truth"),
        identify_from=identify_from,
        unit=unit,
    )


def identifiability(
    trace: Trace, *, k: int | None = None, sigma: ArrayLike | None = None
) -> Identifiability:
    """Return the identifiability of the online estimate's parameters from the samples up to a step.

    Parameters
    ----------
    trace : Trace
        A run with ``estimate_parameters=True``.
    k : int, optional
        The step. Default: the last one.
    sigma : array (3,), optional
        Standard deviations of the equation noise of x, y (in the unit of the trace) and heading
        (rad). Default for an estimate from the truth, which has no noise: 0.1 px, 0.1 px, 0.005
        rad. Default for other estimates: the one-step prediction errors of the samples up to the
        step.

    Returns
    -------
    Identifiability
        Standard errors and verdicts; print it.

    Raises
    ------
    NotRecordedError
        If the trace has no standard errors, as with your own estimator.
    TypeError, ValueError
        If `trace` is not a Trace, or `k` or `sigma` is wrong.

    Notes
    -----
    The result is practical identifiability, given the excitation and the noise of this run.
    Structural identifiability asks whether any run without noise determines the parameters.

    Examples
    --------
    A robot that turns on the spot does not show how its motors drive it along x:

    >>> sim = robsim.Simulation(seed=1, control=robsim.Spin(), estimate_parameters=True)
    >>> report = robsim.identifiability(sim.run(100), sigma=(0.1, 0.1, 0.001))
    >>> report.verdicts[0].tolist()
    ['not excited', 'not excited', 'not excited', 'not excited', 'not excited']
    """
    check_trace(trace, "standard_errors_unscaled")
    last = int(trace.k[-1])
    step = last if k is None else check_int("k", k, minimum=int(trace.k[0]), maximum=last)
    until = trace[: step - int(trace.k[0]) + 1]
    theta, source = until.parameters[-1], trace.info.identify_from
    # An assumed sigma is taken to be as uncertain as one that was estimated from the run.
    freedom = math.inf if sigma is not None else max(len(until) - 5, 1)
    if sigma is None and source != "truth":
        sigma, freedom = prediction_sigma(until, theta)
    errors = until.standard_errors_unscaled[-1]
    return judge(
        errors,
        theta,
        sigma=sigma,
        freedom=freedom,
        identify_from=source,
        unit=trace.info.unit,
        px_length=trace.info.px_length,
    )


def prediction_sigma(trace: Trace, theta: Floats) -> tuple[Floats, int]:
    """Return sigma (3,) of one-step errors (unit, unit, rad) by theta (3, 5), and the freedom."""
    found = regression_of(trace)
    errors = found.y - np.sum(found.phi * theta, axis=2)
    freedom = max(len(errors) - 5, 1)
    sigma: Floats = np.sqrt(np.sum(np.square(errors), axis=0) / freedom)
    return np.nan_to_num(sigma), freedom
