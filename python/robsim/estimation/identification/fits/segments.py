"""Recorded poses and inputs, checked and split into segments for the fits."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robsim.base.checks import Floats
from robsim.base.text import quoted
from robsim.trace.timing import delayed

HEADING = 2
_MAXIMUM_VALUE = 1e9  # px, rad or V: beyond any real value
Bools = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Record:
    """Measured poses and inputs of N steps."""

    poses: Floats  # (N, 3): a row of NaN = not seen
    u: Floats  # (N, 2): inputs (V)
    breaks: Bools  # (N,): the step does not follow from the previous one

    @property
    def seen(self) -> Bools:
        return np.asarray(np.isfinite(self.poses[:, 0]))

    def with_delay(self, motor_delay: float) -> Record:
        """Return the record with the inputs that act, this many steps after they were given."""
        return replace(self, u=delayed(self.u, motor_delay)) if motor_delay else self


@dataclass(frozen=True, eq=False)
class Segment:
    """Consecutive steps without a break; the robot is seen in the first and in the last one."""

    poses: Floats  # (n, 3): NaN = not seen. The heading is unwrapped
    u: Floats  # (n, 2): inputs (V)
    seen: Bools  # (n,): the steps with a pose

    def interpolated(self) -> Floats:
        """Return the poses (n, 3), linearly interpolated where the robot was not seen."""
        steps = np.arange(len(self.poses))
        at = steps[self.seen]
        return np.column_stack([np.interp(steps, at, axis[self.seen]) for axis in self.poses.T])


def as_record(poses: ArrayLike, u: ArrayLike, breaks: ArrayLike | None) -> Record:
    """Return checked copies; raise TypeError or ValueError for a wrong type, shape or value."""
    poses = _rows("poses", poses, 3)
    u = _rows("u", u, 2)
    if len(u) != len(poses):
        raise ValueError(f"u must have a row for each of the {len(poses)} poses, got {len(u)}")
    if not np.isfinite(u).all():
        raise ValueError(f"u must be finite (V), got {u[~np.isfinite(u)][0]}")
    breaks = np.zeros(len(poses), dtype=bool) if breaks is None else np.array(breaks)
    if breaks.dtype != bool or breaks.shape != (len(poses),):
        raise ValueError(
            f"breaks must be {len(poses)} bools, one per step, got {breaks.dtype} of shape "
            f"{breaks.shape}"
        )
    poses[~np.isfinite(poses).all(axis=1)] = np.nan
    for name, values in (("poses", poses), ("u", u)):
        if (np.abs(values) > _MAXIMUM_VALUE).any():
            maximum = np.nanmax(np.abs(values))
            raise ValueError(f"{name} must lie within +-{_MAXIMUM_VALUE:g}, got {maximum:g}")
    return Record(poses, u, breaks)


def _rows(name: str, values: Any, width: int) -> Floats:
    try:
        rows = np.array(values, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise TypeError(
            f"{name} must be numbers of shape (N, {width}), got {quoted(values)}"
        ) from error
    if rows.ndim != 2 or rows.shape[1] != width:
        raise ValueError(f"{name} must have the shape (N, {width}), got {rows.shape}")
    return rows


def split(record: Record, *, maximum_gap: int | None = None, minimum: int) -> list[Segment]:
    """Return segments of `minimum` poses, split at breaks and gaps over `maximum_gap` steps."""
    at = np.flatnonzero(record.seen)
    number = np.cumsum(record.breaks)[at]
    new = np.diff(number) > 0
    if maximum_gap is not None:
        new |= np.diff(at) > maximum_gap + 1
    return [
        _segment(record, slice(steps[0], steps[-1] + 1))
        for steps in np.split(at, np.flatnonzero(new) + 1)
        if len(steps) >= minimum
    ]


def _segment(record: Record, part: slice) -> Segment:
    poses, seen = record.poses[part].copy(), record.seen[part]
    poses[seen, HEADING] = np.unwrap(poses[seen, HEADING])
    return Segment(poses, record.u[part], seen)
