"""Batch identification and its report."""

from __future__ import annotations

import html
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, TypedDict

import numpy as np
from numpy.typing import NDArray

from robsim._base.checks import Floats
from robsim._core import least_squares
from robsim.identification._fits import METHODS
from robsim.identification._identifiability import Identifiability, judge
from robsim.identification._regression import SOURCES, Regression, regression_of
from robsim.trace import PARAMETER_NAMES, Trace

if TYPE_CHECKING:
    import pandas

_MINIMUM_SAMPLES = 5
_ROUNDING = 1e-6  # px and rad
_AXES = ("X", "Y", "P")
_METHODS = ("least_squares", *METHODS)


class _Fit(TypedDict):
    """What a method finds: fields of `BatchEstimate`."""

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
class BatchEstimate:
    """The parameters of the robot model from a whole record.

    Attributes
    ----------
    theta_true, batch, online : array (3, 5)
        The model's own values, batch estimate, last online estimate; rows X, Y, P (heading),
        columns a1, a2, b1, b2, d1. NaN = not determined by the record, or no online estimate.
    identify_from, online_from : str
        The data of the batch and of the online estimate: truth, measurement or estimate.
    start, stop : int
        The record: steps start..stop - 1.
    rank : array (3,) of int
        Independent regressors of each axis; 5 = all parameters are determined.
    condition : array (3,)
        Condition number of the regressors of each axis, scaled to length 1; NaN with another
        method than least squares.
    residual_rms : array (3,)
        Root mean square of the one-step prediction error (px, px, rad); with another method than
        least squares, of what its fit leaves over of the poses.
    standard_errors : array (3, 5)
        Standard errors of `batch`, with the noise estimated from the residuals. They hold for noise
        in the equations; noise of measurements makes least squares biased, too.
    standard_errors_unscaled : array (3, 5)
        The same for noise of standard deviation 1 (px, px, rad).
    n_samples : int, optional
        Number of samples. Default: all that a record without interruption has.
    left_out : int
        Samples of the record that were left out for a bounce or a missing pose in them.
    select : str
        Which samples were taken: valid, longest or all.
    method : str
        How: least_squares, instrumental_variables or output_error.
    converged : bool
        Whether the method came to an end; if not, `batch` is only as far as it got.
    model_error : array (3,)
        Root mean square of what `theta_true` leaves over of the true path in a step (px, px, rad).
        Not 0, if something else than the model moved the robot: then `theta_true` is not the truth.
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

    @property
    def _samples(self) -> int:
        return self.stop - self.start - 2 if self.n_samples is None else self.n_samples

    @property
    def title(self) -> str:
        """Which data the estimate is made from."""
        kind = {"longest": ", the longest record", "all": ", bounces included"}
        method = "" if self.method == "least_squares" else f" by {self.method.replace('_', ' ')}"
        return (
            f"Batch estimate from {self.identify_from}{method}, steps "
            f"{self.start}..{self.stop - 1} ({self._samples} samples{kind.get(self.select, '')})"
        )

    @property
    def is_model_exact(self) -> bool:
        """Whether the robot moved as its model says, so that `theta_true` is the truth."""
        return bool((self.model_error <= _ROUNDING).all())

    @property
    def identifiability(self) -> Identifiability:
        """How well the record determines each parameter.

        For poses of the truth, which have no noise, the noise is assumed; else it is that of the
        residuals.
        """
        if self.identify_from == "truth":
            return judge(self.standard_errors_unscaled, self.batch)
        if self.method != "least_squares":
            return judge(self.standard_errors_unscaled, self.batch, noise=self.residual_rms)
        n_samples = self._samples
        freedom = np.maximum(n_samples - self.rank, 1)
        noise = self.residual_rms * np.sqrt(n_samples / freedom)
        return judge(self.standard_errors_unscaled, self.batch, noise=noise)

    def to_dict(self) -> dict[str, dict[str, float | None]]:
        """Return name -> {"true", "batch", "standard_error", "online"} of all 15 parameters.

        None = not there.
        """
        columns = (self.theta_true, self.batch, self.standard_errors, self.online)
        keys = ("true", "batch", "standard_error", "online")
        return {
            name: {
                key: float(value) if np.isfinite(value) else None
                for key, value in zip(keys, values, strict=True)
            }
            for name, *values in zip(PARAMETER_NAMES, *map(np.ravel, columns), strict=True)
        }

    def to_pandas(self) -> pandas.DataFrame:
        """Return a data frame: a row for each parameter, with the verdict on its excitation.

        Raises
        ------
        ImportError
            If pandas is not installed.
        """
        try:
            import pandas as pd
        except ImportError as error:
            raise ImportError("to_pandas needs pandas: pip install pandas") from error
        frame = pd.DataFrame.from_dict(self.to_dict(), orient="index", dtype=float)
        frame["excited"] = self.identifiability.verdicts.ravel()
        return frame.rename_axis("parameter")

    def _titles(self) -> tuple[str, ...]:
        value = "True value" if self.is_model_exact else "Model value"
        return ("", value, "Batch estimate", "Standard error", "Online estimate")

    def _rows(self) -> list[tuple[str, ...]]:
        digits = {"standard_error": ".2g"}

        def text(key: str, value: float | None) -> str:
            return "-" if value is None else format(value, digits.get(key, ".5g"))

        return [
            (name, *(text(key, value) for key, value in values.items()))
            for name, values in self.to_dict().items()
        ]

    def __str__(self) -> str:
        line = "-" * 76
        rows = [self._titles(), *self._rows()]
        texts = [
            f"{name:<6}{true:>14}{batch:>19}{error:>18}{online:>19}"
            for name, true, batch, error, online in rows
        ]
        for end_of_axis in (16, 11, 6, 1):
            texts.insert(end_of_axis, line)
        return "\n".join([self.title, line, *texts, *self._remarks(), str(self.identifiability)])

    def _remarks(self) -> list[str]:
        remarks = [
            f"{axis}: the record cannot give {', '.join(missing)}; excite the robot more"
            for axis, missing in zip(_AXES, self._missing(), strict=True)
            if missing
        ]
        if not self.converged:
            remarks.append("the fit did not converge: do not trust it")
        if self.left_out:
            remarks.append(f"{self.left_out} samples with a bounce or a missing pose are left out")
        if not self.is_model_exact:
            x, y, heading = self.model_error
            remarks.append(
                f"the robot does not move as its model says (rms {x:.2g} px, {y:.2g} px, "
                f"{heading:.2g} rad a step): the model's values need not be true"
            )
        if not np.isfinite(self.online).any():
            remarks.append("no online estimate: run with estimate_parameters=True")
        elif self.online_from != self.identify_from:
            remarks.append(f"the online estimate is from {self.online_from}")
        return remarks

    def _missing(self) -> list[list[str]]:
        """Return the names of the parameters that the record does not determine, by axis."""
        names = np.reshape(PARAMETER_NAMES, (3, 5))
        return [list(names[axis][np.isnan(self.batch[axis])]) for axis in range(3)]

    def _repr_html_(self) -> str:
        head = f"<tr>{''.join(f'<th>{title}</th>' for title in self._titles())}</tr>"
        body = "".join(
            f"<tr>{''.join(f'<td>{text}</td>' for text in row)}</tr>" for row in self._rows()
        )
        lines = [*self._remarks(), *str(self.identifiability).splitlines()]
        remarks = "<br>".join(map(html.escape, lines))
        return f"<p>{self.title}</p><table>{head}{body}</table><p>{remarks}</p>"


def batch_estimate(
    trace: Trace,
    *,
    identify_from: str | None = None,
    select: str = "valid",
    method: str = "least_squares",
) -> BatchEstimate:
    """Estimate the parameters of the robot model from a whole record.

    From measured poses least squares is biased, as there is noise in its regressors, too; the other
    methods are not.

    Parameters
    ----------
    trace : Trace
        The recorded run.
    identify_from : str, optional
        ``"truth"``, ``"measurement"`` or ``"estimate"``. Default: as the trace's own online
        estimate.
    select : str
        ``"valid"``: all samples but those that span a bounce or a step without a pose.
        ``"longest"``: those of the longest record without an interruption. ``"all"``: also those
        that span a bounce, to see what harm they do.
    method : str
        ``"least_squares"``, ``"instrumental_variables"`` or ``"output_error"``; see the functions
        of these names.

    Returns
    -------
    BatchEstimate
        The report; print it, or leave it at the end of a notebook's cell.

    Raises
    ------
    TypeError, ValueError
        If it is no trace, there are too few samples, or a name is none of these.
    """
    if not isinstance(trace, Trace):
        raise TypeError(f"trace must be a Trace, got {trace!r}")
    if method not in _METHODS:
        names = ", ".join(map(repr, _METHODS))
        raise ValueError(f"method must be one of {names}, got {method!r}")
    found = regression_of(trace, identify_from=identify_from, select=select)
    if len(found.k) < _MINIMUM_SAMPLES:
        where = "the longest of" if select == "longest" else "all"
        raise ValueError(
            f"a batch estimate from {found.identify_from} needs at least {_MINIMUM_SAMPLES} "
            f"samples, each of three steps in a row, got {len(found.k)} in {where} {len(trace)} "
            "steps"
        )
    start, stop = int(found.k[0]) - 2, int(found.k[-1]) + 1
    fit = (
        _least_squares(found)
        if method == "least_squares"
        else _fitted(trace, found, start, stop, select, method)
    )
    return BatchEstimate(
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
        model_error=_model_error(trace),
        **fit,
    )


def _least_squares(found: Regression) -> _Fit:
    fits = [least_squares(found.phi[:, axis], found.y[:, axis]) for axis in range(3)]
    return {
        "batch": np.array([fit.theta for fit in fits]),
        "rank": np.array([fit.rank for fit in fits]),
        "condition": np.array([fit.condition for fit in fits]),
        "residual_rms": np.array([fit.residual_rms for fit in fits]),
        "standard_errors": np.array([fit.standard_errors for fit in fits]),
        "standard_errors_unscaled": np.array([fit.standard_errors_unscaled for fit in fits]),
        "converged": True,
    }


def _fitted(
    trace: Trace, found: Regression, start: int, stop: int, select: str, method: str
) -> _Fit:
    first = int(trace.k[0])
    record = trace[start - first : stop - first]
    poses = getattr(record, SOURCES[found.identify_from])
    breaks = None if select == "all" else record.bounced
    fit = METHODS[method](poses, record.u, breaks=breaks)
    noise = np.maximum(fit.residual_rms, np.finfo(float).tiny)
    return {
        "batch": fit.theta,
        "rank": fit.determined.sum(axis=1),
        "condition": np.full(3, np.nan),
        "residual_rms": fit.residual_rms,
        "standard_errors": np.where(fit.determined, fit.standard_errors, np.nan),
        "standard_errors_unscaled": fit.standard_errors / noise[:, np.newaxis],
        "converged": fit.converged,
    }


def _model_error(trace: Trace) -> Floats:
    """Return the root mean squares of what the model leaves over of the true path, (3,)."""
    found = regression_of(trace, identify_from="truth")
    if not len(found.k):
        return np.zeros(3)
    left_over = found.y - np.sum(found.phi * np.array(trace.info.theta_true), axis=2)
    error: Floats = np.sqrt(np.mean(np.square(left_over), axis=0))
    return error
