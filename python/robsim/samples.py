"""The samples of a record."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robsim._core import regression_samples
from robsim.numbers import Floats
from robsim.trace import Bools, Trace, longest_run

SOURCES = {"truth": "pose_true", "measurement": "measured", "estimate": "estimated"}
SELECTIONS = ("valid", "longest", "all")


@dataclass(frozen=True, kw_only=True, eq=False)
class Samples:
    """Samples of the robot model's predictor: y = sum(phi * theta, axis=2).

    Attributes
    ----------
    phi : array (N, 3, 5)
        Regressors of the axes X, Y and P (heading).
    y : array (N, 3)
        Outputs x, y (work-area px) and heading (rad).
    k : array (N,) of int
        The step whose output y is; its regressors are from the two steps before.
    identify_from : str
        The poses that they are made of: truth, measurement or estimate.
    left_out : int
        Samples that were left out for a bounce or a missing pose in them.
    """

    phi: Floats
    y: Floats
    k: NDArray[np.int64]
    identify_from: str
    left_out: int


def samples_of(
    trace: Trace, *, identify_from: str | None = None, samples: str = "valid"
) -> Samples:
    """Return the samples of a trace.

    Parameters
    ----------
    trace : Trace
        The recorded run.
    identify_from : str, optional
        ``"truth"``, ``"measurement"`` or ``"estimate"``. Default: as the trace's own online
        estimate.
    samples : str
        ``"valid"``: all but those that span a bounce or a step without a pose. ``"longest"``: those
        of the longest record without an interruption. ``"all"``: also those that span a bounce,
        which the model knows nothing of.

    Raises
    ------
    ValueError
        For another name.
    """
    identify_from = trace.info.identify_from if identify_from is None else identify_from
    for name, value, known in (
        ("identify_from", identify_from, tuple(SOURCES)),
        ("samples", samples, SELECTIONS),
    ):
        if value not in known:
            names = ", ".join(map(repr, known))
            raise ValueError(f"{name} must be one of {names}, got {value!r}")
    poses = getattr(trace, SOURCES[identify_from])
    if samples == "longest":
        record = longest_record(trace, poses)
        chosen = np.zeros(max(len(trace) - 2, 0), dtype=bool)
        chosen[record.start : max(record.stop - 2, record.start)] = True
    else:
        chosen = _complete(_follows(trace, poses, over_bounces=samples == "all"))
    if not chosen.any():
        phi, y = np.empty((0, 3, 5)), np.empty((0, 3))
    else:
        known_poses = np.where(np.isfinite(poses).all(axis=1)[:, np.newaxis], poses, 0.0)
        phi, y = regression_samples(known_poses, np.nan_to_num(trace.u))
    return Samples(
        phi=phi[chosen[: len(phi)]],
        y=y[chosen[: len(y)]],
        k=trace.k[2:][chosen],
        identify_from=identify_from,
        left_out=int((~chosen).sum()) if samples != "longest" else 0,
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
    run = longest_run(_follows(trace, poses))
    return slice(run.start, run.stop + 1) if run.stop > run.start else slice(0, 0)


def _follows(trace: Trace, poses: Floats, *, over_bounces: bool = False) -> Bools:
    """Return at which of the steps 1.. the pose follows from the one before."""
    seen = np.asarray(np.isfinite(poses).all(axis=1))
    # Step k follows from step k-1 unless a bounce mirrored the robot in it.
    unbroken = over_bounces | ~trace.bounced[1:]
    return np.asarray(seen[1:] & seen[:-1] & unbroken)


def _complete(follows: Bools) -> Bools:
    """Return at which of the steps 2.. there is a sample: it takes three poses in a row."""
    return np.asarray(follows[1:] & follows[:-1])
