"""Batch identification and its report."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robsim._core import least_squares, regression_samples
from robsim.numbers import Floats
from robsim.trace import PARAMETER_NAMES, Trace, longest_run

_SOURCES = {"truth": "pose_true", "measurement": "measured", "estimate": "estimated"}
_MINIMUM_SAMPLES = 5


@dataclass(frozen=True, kw_only=True, eq=False)
class BatchEstimate:
    """The parameters of the robot model from a whole record.

    Attributes
    ----------
    theta_true, batch, online : array (3, 5)
        True values, batch estimate, last online estimate; rows X, Y, P (heading), columns a1, a2,
        b1, b2, d1. NaN = not determined by the record, or no online estimate.
    identify_from, online_from : str
        The data of the batch and of the online estimate: truth, measurement or estimate.
    start, stop : int
        The record: steps start..stop - 1.
    rank : array (3,) of int
        Independent regressors of each axis; 5 = all parameters are determined.
    condition : array (3,)
        Condition number of the regressors of each axis, scaled to length 1.
    residual_rms : array (3,)
        Root mean square of the one-step prediction error (px, px, rad).
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

    @property
    def title(self) -> str:
        """Which data the estimate is made from."""
        return (
            f"Batch estimate from {self.identify_from}, steps {self.start}..{self.stop - 1} "
            f"({self.stop - self.start - 2} samples)"
        )

    def to_dict(self) -> dict[str, dict[str, float | None]]:
        """Return name -> {"true", "batch", "online"} of all 15 parameters; None = not there."""
        columns = (self.theta_true, self.batch, self.online)
        return {
            name: {
                key: float(value) if np.isfinite(value) else None
                for key, value in zip(("true", "batch", "online"), values, strict=True)
            }
            for name, *values in zip(PARAMETER_NAMES, *map(np.ravel, columns), strict=True)
        }

    def _rows(self) -> list[tuple[str, str, str, str]]:
        def text(value: float | None) -> str:
            return "-" if value is None else f"{value:.5g}"

        return [
            (name, text(values["true"]), text(values["batch"]), text(values["online"]))
            for name, values in self.to_dict().items()
        ]

    def __str__(self) -> str:
        line = "-" * 58
        rows = [("", "True value", "Batch estimate", "Online estimate"), *self._rows()]
        texts = [f"{n:<6}{true:>14}{batch:>19}{online:>19}" for n, true, batch, online in rows]
        for end_of_axis in (16, 11, 6, 1):
            texts.insert(end_of_axis, line)
        return "\n".join([self.title, line, *texts, *self._remarks()])

    def _remarks(self) -> list[str]:
        remarks = [
            f"{axis}: the record determines {rank} of 5 parameters only; excite the robot more"
            for axis, rank in zip(("X", "Y", "P"), self.rank, strict=True)
            if rank < 5
        ]
        if not np.isfinite(self.online).any():
            remarks.append("no online estimate: run with estimate_parameters=True")
        elif self.online_from != self.identify_from:
            remarks.append(f"the online estimate is from {self.online_from}")
        return remarks

    def _repr_html_(self) -> str:
        titles = ("", "True value", "Batch estimate", "Online estimate")
        head = f"<tr>{''.join(f'<th>{title}</th>' for title in titles)}</tr>"
        body = "".join(
            f"<tr><td>{name}</td><td>{true}</td><td>{batch}</td><td>{online}</td></tr>"
            for name, true, batch, online in self._rows()
        )
        remarks = "".join(f"<p>{remark}</p>" for remark in self._remarks())
        return f"<p>{self.title}</p><table>{head}{body}</table>{remarks}"


def batch_estimate(trace: Trace, *, identify_from: str | None = None) -> BatchEstimate:
    """Estimate the parameters of the robot model by least squares.

    The longest unbroken record is used: no bounce in it and, unless from truth, no step without a
    pose.

    Parameters
    ----------
    trace : Trace
        The recorded run.
    identify_from : str, optional
        ``"truth"``, ``"measurement"`` or ``"estimate"``. Default: as the trace's own online
        estimate.

    Returns
    -------
    BatchEstimate
        The report; print it, or leave it at the end of a notebook's cell.

    Raises
    ------
    ValueError
        If the longest record is too short.
    """
    if identify_from is None:
        identify_from = trace.info.identify_from
    if identify_from not in _SOURCES:
        names = ", ".join(map(repr, _SOURCES))
        raise ValueError(f"identify_from must be one of {names}, got {identify_from!r}")
    poses = getattr(trace, _SOURCES[identify_from])
    record = longest_record(trace, poses)
    samples = max(record.stop - record.start - 2, 0)
    if samples < _MINIMUM_SAMPLES:
        raise ValueError(
            f"a batch estimate from {identify_from} needs at least {_MINIMUM_SAMPLES} samples in "
            f"a row, got {samples} in the longest of {len(trace)} steps"
        )
    phi, y = regression_samples(poses[record], trace.u[record])
    fits = [least_squares(phi[:, axis], y[:, axis]) for axis in range(3)]
    first = int(trace.k[0])
    return BatchEstimate(
        theta_true=np.array(trace.info.theta_true),
        batch=np.array([fit.theta for fit in fits]),
        online=np.array(trace.parameters[-1]),
        identify_from=identify_from,
        online_from=trace.info.identify_from,
        start=first + record.start,
        stop=first + record.stop,
        rank=np.array([fit.rank for fit in fits]),
        condition=np.array([fit.condition for fit in fits]),
        residual_rms=np.array([fit.residual_rms for fit in fits]),
    )


def longest_record(trace: Trace, poses: Floats) -> slice:
    """Return the longest record of a trace in which every step follows from the one before.

    Parameters
    ----------
    trace : Trace
        The recorded run; a bounce breaks a record.
    poses : array (N, 3)
        The poses to use; NaN breaks a record.
    """
    seen = np.asarray(np.isfinite(poses).all(axis=1))
    # Step k follows from step k-1 unless a bounce mirrored the robot in it.
    follows = seen[1:] & seen[:-1] & ~trace.bounced[1:]
    run = longest_run(follows)
    return slice(run.start, run.stop + 1) if run.stop > run.start else slice(0, 0)
