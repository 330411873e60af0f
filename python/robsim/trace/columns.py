"""The columns of a trace: groups, names, units, widths."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, Generic, Self, TypeVar, overload

import numpy as np
from numpy.typing import NDArray

from robsim._core import trace_schema
from robsim.base.checks import Floats, check_words
from robsim.base.text import quoted

_Values = TypeVar("_Values")
GROUPS = {group.name: group for group in trace_schema()}
"""The groups of fixed width by name; a new one is added to the schema in the core."""
#: The groups that the trace of a simulated run, or of recorded frames, must have.
SIMULATED = tuple(name for name, group in GROUPS.items() if group.in_simulated)
RECORDED = tuple(name for name, group in GROUPS.items() if group.in_recorded)
#: The 15 parameters of the robot model, row by row of theta (3, 5).
PARAMETER_NAMES = tuple(GROUPS["parameters"].units)
#: The group of the poses from each source.
POSES = {"truth": "pose_true", "measurement": "pose_measured", "estimate": "pose_estimated"}


def check_group_name(name: str) -> None:
    """Raise a ValueError unless a group, also of a colour's blobs, can have this name."""
    check_words("the name of a group", name.removeprefix("blobs_"))


def fields_of(group: str, width: int) -> dict[str, str]:
    """Return name -> unit of the single columns of a group."""
    if group.startswith("blobs_") and group != "blobs_":
        color = group.removeprefix("blobs_")
        return {f"{color}{i}_{q}": "px" for i in (1, 2) for q in "xy"}
    if group == "state":
        return {f"state{i}": "" for i in range(width)}
    if group not in GROUPS:
        raise ValueError(f"there is no group of columns {quoted(group)}")
    return GROUPS[group].units


def group_of(field: str) -> str | None:
    """Return the group of a single column; None if it is not in a group of fixed width."""
    return next((name for name, group in GROUPS.items() if field in group.units), None)


def empty_groups(names: Iterable[str]) -> dict[str, Floats]:
    return {name: np.empty((0, len(GROUPS[name].units))) for name in names}


def as_numbers(name: str, values: Any) -> Floats:
    """Return real numbers as float64."""
    try:
        array = np.asarray(values)
    except ValueError:
        raise ValueError(f"{name} must be an array of numbers, got {quoted(values)}") from None
    if array.dtype.kind not in "biuf":
        raise ValueError(f"{name} must be numbers, got {array.dtype} of shape {array.shape}")
    return array.astype(np.float64, copy=False)


def _shape_of(group: str) -> tuple[int, ...]:
    """Return the shape of the numbers of a step; () for a state, whose width varies."""
    if group in GROUPS:
        return GROUPS[group].shape
    return () if group == "state" else (2, 2)


def as_rows(name: str, values: Any) -> Floats:
    """Return a read-only array (N, width) of a group's numbers; input may be (N, 3, 5)."""
    array = as_numbers(name, values)
    if array.ndim < 1 or (array.ndim > 2 and array.shape[1:] != _shape_of(name)):
        raise ValueError(f"{name} must have a row for each step, got shape {array.shape}")
    rows = array.reshape(len(array), math.prod(array.shape[1:])).view()
    rows.setflags(write=False)
    width = len(fields_of(name, rows.shape[1]))
    if rows.shape[1] != width:
        raise ValueError(f"{name} must have {width} columns, got shape {array.shape}")
    variances = rows[:, :: math.isqrt(width) + 1]  # of a covariance
    if name.startswith("covariance") and (variances < 0).any():
        raise ValueError(f"{name} must have variances of at least 0, got {np.nanmin(variances):g}")
    return rows


class _Group(property, Generic[_Values]):
    """The group of its name: a row for each step, as described by the schema."""

    def __set_name__(self, owner: type, name: str) -> None:
        group = GROUPS[name]
        if group.is_flag:
            super().__init__(lambda trace: np.asarray(trace._numbers(group) > 0))
        else:
            super().__init__(lambda trace: trace._numbers(group))
        self.__doc__ = group.description

    if TYPE_CHECKING:

        @overload
        def __get__(self, trace: None, owner: type, /) -> Self: ...
        @overload
        def __get__(self, trace: Any, owner: type | None = None, /) -> _Values: ...
        def __get__(self, trace: Any, owner: type | None = None, /) -> Any: ...


class Column(_Group[Floats]):
    """An array of numbers."""


class Flag(_Group[NDArray[np.bool_]]):
    """True or False at each step."""


_TRUTH = "only a simulation knows the truth; recorded frames do not have it"
_NOT_FITTED = (
    "run with measure=True; a measure of your own must return the result of robsim.locate with "
    "image=..., or a Measurement with this value"
)
_UNSEEN = "the robot was never seen; a measure of your own must return its Measurement"
# How to record a group of columns.
_HOW = {
    "pose_true": _TRUTH,
    "theta_true": _TRUTH,
    "u": "there was no controller: give control=..., or control=robsim.Replay(u) for inputs "
    "recorded with the frames",
    "pose_measured": "run with measure=True",
    "pose_held": "run with measure=True",
    "covariance_measured": _NOT_FITTED,
    "misfit": _NOT_FITTED,
    "signal_to_noise": _NOT_FITTED,
    "missed": "the default measurement missed no frame, or there was none: run with measure=True",
    "pose_estimated": "run with estimate_state=...",
    "covariance": "run with estimate_state=...",
    "parameters": "run with estimate_parameters=True",
    "standard_errors_unscaled": "run with estimate_parameters=True",
    "t_arrival": "only a live camera reports arrival times: pass one to robsim.Experiment",
    "t_sent": "no input was sent: pass send=... to robsim.Experiment",
}
# Why a group that was recorded has no number.
_WHY_UNKNOWN = {
    "pose_true": _TRUTH,
    "pose_measured": _UNSEEN,
    "pose_held": _UNSEEN,
    "parameters": "let estimate_parameters return the parameters, (3, 5)",
    "covariance": "let estimate_state return Estimate(pose, covariance)",
    "standard_errors_unscaled": "an estimator of your own reports no standard errors",
}


class NotRecordedError(ValueError):
    """A run lacks required records.

    Attributes
    ----------
    columns : tuple of str
        The missing columns of the trace: ``("pose_estimated",)``.
    remedy : str
        How to record them, or why they are not known: ``"run with estimate_state=..."``.
    """

    def __init__(self, columns: tuple[str, ...], remedy: str) -> None:
        super().__init__(columns, remedy)
        self.columns = columns
        self.remedy = remedy

    def __str__(self) -> str:
        return f"the trace has no {', '.join(self.columns)}: {self.remedy}"


def how_recorded(name: str) -> str:
    return _HOW.get(name, "it was not recorded in this run")


def not_recorded(missing: Mapping[str, bool], *, steps: int) -> NotRecordedError:
    """Return the error for `missing` columns; True = recorded, but without known values."""
    if not steps:
        return NotRecordedError(tuple(missing), "it has no steps")
    remedies = (
        _WHY_UNKNOWN.get(name, "it is not known in any step") if is_recorded else how_recorded(name)
        for name, is_recorded in missing.items()
    )
    return NotRecordedError(tuple(missing), "; ".join(dict.fromkeys(remedies)))
