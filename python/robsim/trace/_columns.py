"""What the columns of a trace are: groups, names, units, widths. A new column is added here."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from robsim._base.checks import Floats

#: The 15 parameters of the robot model, row by row of theta (3, 5).
PARAMETER_NAMES = tuple(f"{p}{axis}" for axis in "XYP" for p in ("a1", "a2", "b1", "b2", "d1"))

_POSE_UNITS = ("px", "px", "rad")


def _poses(suffix: str) -> dict[str, str]:
    return {
        f"{q}_{suffix}": unit for q, unit in zip(("x", "y", "heading"), _POSE_UNITS, strict=True)
    }


# What each group of columns consists of: name -> unit, in the order of the numbers of a row.
_FIXED_GROUPS: dict[str, dict[str, str]] = {
    "t": {"t": "s"},
    "pose_true": _poses("true"),
    "u": {"u1": "V", "u2": "V"},
    "bounced": {"bounced": ""},
    "pose_measured": _poses("measured"),
    "pose_held": _poses("held"),
    "pose_estimated": _poses("estimated"),
    "covariance": {
        f"cov_{a}_{b}": f"{ua} {ub}"
        for a, ua in zip(("x", "y", "heading"), _POSE_UNITS, strict=True)
        for b, ub in zip(("x", "y", "heading"), _POSE_UNITS, strict=True)
    },
    "parameters": dict.fromkeys(PARAMETER_NAMES, ""),
    "standard_errors_unscaled": {f"standard_error_unscaled_{name}": "" for name in PARAMETER_NAMES},
    "view": {"x_view": "px", "y_view": "px"},
}

#: The groups that the trace of a simulated run, or of recorded frames, must have.
SIMULATED = ("pose_true", "u", "bounced")
RECORDED = ("pose_measured",)
_SHAPES = {
    "covariance": (3, 3),
    "parameters": (3, 5),
    "standard_errors_unscaled": (3, 5),
    "state": (),
}


def fields_of(group: str, width: int) -> dict[str, str]:
    """Return name -> unit of the single columns of a group."""
    if group.startswith("blobs_") and group != "blobs_":
        color = group.removeprefix("blobs_")
        return {f"{color}{i}_{q}": "px" for i in (1, 2) for q in "xy"}
    if group == "state":
        return {f"state{i}": "" for i in range(width)}
    if group not in _FIXED_GROUPS:
        raise ValueError(f"there is no group of columns {group!r}")
    return _FIXED_GROUPS[group]


def as_numbers(name: str, values: Any) -> Floats:
    """Return real numbers as float64."""
    try:
        array = np.asarray(values)
    except ValueError:
        raise ValueError(f"{name} must be an array of numbers, got {values!r}") from None
    if array.dtype.kind not in "biuf":
        raise ValueError(f"{name} must be numbers, got {array.dtype} of shape {array.shape}")
    return array.astype(np.float64, copy=False)


def as_rows(name: str, values: Any) -> Floats:
    """Return a read-only array (N, width) of a group's numbers, which may come as (N, 3, 5)."""
    array = as_numbers(name, values)
    if array.ndim < 1 or (array.ndim > 2 and array.shape[1:] != _SHAPES.get(name, (2, 2))):
        raise ValueError(f"{name} must have a row for each step, got shape {array.shape}")
    rows = array.reshape(len(array), math.prod(array.shape[1:])).view()
    rows.setflags(write=False)
    width = len(fields_of(name, rows.shape[1]))
    if rows.shape[1] != width:
        raise ValueError(f"{name} must have {width} columns, got shape {array.shape}")
    return rows
