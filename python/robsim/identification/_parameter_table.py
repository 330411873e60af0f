"""The table of the model's 15 parameters, which the reports on them share."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robsim._base.checks import Floats
from robsim._base.report import Column, Row, Table
from robsim.trace import PARAMETER_NAMES


def parameter_table(columns: Mapping[Column, NDArray[Any]]) -> Table:
    """Return a table with a row for each parameter.

    Parameters
    ----------
    columns : mapping of Column to array (3, 5)
        The columns and their values.
    """
    values = zip(*(array.ravel().tolist() for array in columns.values()), strict=True)
    rows = [Row(name, numbers) for name, numbers in zip(PARAMETER_NAMES, values, strict=True)]
    return Table(
        key="parameters", columns=tuple(columns), rows=rows, row_title="parameter", group=5
    )


def equation_noise(sigma: Floats, spec: str = ".3g") -> str:
    """Return standard deviations of x, y (px) and heading (rad) as people read them."""
    x, y, heading = sigma
    return f"{x:{spec}} px, {y:{spec}} px, {np.rad2deg(heading):{spec}} deg"
