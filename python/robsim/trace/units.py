"""Lengths of a trace in px, mm, cm or m."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from robsim.base.checks import Floats, check_choice, check_mm_per_px
from robsim.base.text import quoted
from robsim.trace.columns import GROUPS, fields_of

if TYPE_CHECKING:
    from robsim.trace.run_info import RunInfo

_MM = {"mm": 1.0, "cm": 10.0, "m": 1000.0}

UNITS = ("px", *_MM)
"""The units of lengths; px are pixels of the work area."""


def px_length(unit: str, mm_per_px: float | None) -> float:
    """Return the length of a px of the work area in a unit: px, mm, cm or m.

    `mm_per_px` is that length on the floor (mm). If it is None, a unit other than px raises
    ValueError.
    """
    check_choice("unit", unit, UNITS)
    if unit == "px":
        return 1.0
    if mm_per_px is None:
        raise ValueError(
            f"unit must be 'px', got {quoted(unit)}: without a calibration, the length of a px on "
            "the floor is unknown; give mm_per_px=..., or give the run a calibration"
        )
    return check_mm_per_px(mm_per_px) / _MM[unit]


def length_format(unit: str, digits: int) -> str:
    """Return the format of lengths: with so many decimals in px and mm."""
    return f".{digits + {'cm': 1, 'm': 3}.get(unit, 0)}f"


def in_unit(text: str, unit: str) -> str:
    """Return a unit such as ``"px/V"`` with another unit of length."""
    return text.replace("px", unit)


def parameter_units(unit: str) -> dict[str, str]:
    """Return the units of the 15 parameters, by their names, with another unit of length."""
    return {name: in_unit(of, unit) for name, of in GROUPS["parameters"].units.items()}


def converted(
    groups: Mapping[str, Floats], info: RunInfo, *, unit: str, mm_per_px: float | None
) -> tuple[dict[str, Floats], RunInfo]:
    """Return groups (N, width) and info with lengths in another unit, as in `Trace.in_unit`."""
    if mm_per_px is None:
        mm_per_px = info.mm_per_px
    elif info.mm_per_px not in (None, check_mm_per_px(mm_per_px)):
        raise ValueError(
            f"mm_per_px must be {info.mm_per_px:g}, as in the run, or omitted, got "
            f"{quoted(mm_per_px)}"
        )
    factor = px_length(unit, mm_per_px) / info.px_length
    theta = scaled("parameters", np.array(info.theta_true), factor)
    info = replace(info, unit=unit, mm_per_px=mm_per_px, theta_true=theta)
    return {name: scaled(name, values, factor) for name, values in groups.items()}, info


def scaled(group: str, values: Floats, factor: float) -> Floats:
    """Return a group's values, (N, width) or parameters (3, 5), with lengths times a factor."""
    rows = values.reshape(1, -1) if values.shape == (3, 5) else values
    units = fields_of(group, rows.shape[1]).values()
    # powers of Python, which are the same on all processors
    factors = np.array([factor ** _exponent(unit) for unit in units])
    return values if (factors == 1).all() else (rows * factors).reshape(values.shape)


def _exponent(unit: str) -> int:
    """Return the exponent of length in a unit: 2 for ``"px px"``, -1 for ``"1/px"``."""
    above, _, below = unit.partition("/")
    return above.split().count("px") - below.split().count("px")
