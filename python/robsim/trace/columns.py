"""What the columns of a trace are: groups, names, units, widths."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

import numpy as np

from robsim._core import trace_schema
from robsim.base.checks import Floats, check_name
from robsim.base.text import quoted

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
    """Raise a ValueError unless a group, of blobs of a colour too, can have this name."""
    check_name("the name of a group", name.removeprefix("blobs_"))


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
    """Return the group that a single column belongs to; None if there is none of fixed width."""
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
    """Return a read-only array (N, width) of a group's numbers, which may come as (N, 3, 5)."""
    array = as_numbers(name, values)
    if array.ndim < 1 or (array.ndim > 2 and array.shape[1:] != _shape_of(name)):
        raise ValueError(f"{name} must have a row for each step, got shape {array.shape}")
    rows = array.reshape(len(array), math.prod(array.shape[1:])).view()
    rows.setflags(write=False)
    width = len(fields_of(name, rows.shape[1]))
    if rows.shape[1] != width:
        raise ValueError(f"{name} must have {width} columns, got shape {array.shape}")
    return rows
