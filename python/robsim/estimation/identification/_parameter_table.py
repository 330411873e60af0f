"""The table of the model's 15 parameters, shared by the reports."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robsim.base.checks import Floats
from robsim.base.report import Column, Row, Table
from robsim.trace import PARAMETER_NAMES

#: Residuals with a smaller p-value are not white.
LEVEL = 0.05


def parameter_table(columns: Mapping[Column, NDArray[Any]]) -> Table:
    """Return a table with a row for each parameter, of columns with values (3, 5)."""
    values = zip(*(array.ravel().tolist() for array in columns.values()), strict=True)
    rows = [Row(name, numbers) for name, numbers in zip(PARAMETER_NAMES, values, strict=True)]
    return Table(
        key="parameters", columns=tuple(columns), rows=rows, row_title="parameter", group=5
    )


def noise_remarks(identify_from: str) -> tuple[str, ...]:
    """Return the omissions of standard errors from poses of the truth, measurement or estimate."""
    # Measured from 12 runs of 800 steps: true errors over standard errors 0.9 to 1.3 of output
    # error, 0.8 to 1.9 of instrumental variables (tests/statistics/RESULTS.md).
    sentences = {
        "measurement": "the standard errors assume errors of measured poses without correlation "
        "from "
        "step to step; a camera's neighbouring errors are similar, so the estimates may be "
        "up to 1.5 times as far off, and least squares is also biased",
        "estimate": "the standard errors assume errors of estimated poses without correlation from "
        "step to step; a filter's neighbouring errors are similar, so the estimates are farther "
        "off",
    }
    return (sentences[identify_from],) if identify_from in sentences else ()


#: Causes of coloured residuals, by the departure of the robot from its model.
_CAUSES = {
    "unknown": "process noise moves the robot, or the model or the delay of the inputs is wrong",
    "none": "neighbouring errors of the measured poses are similar",
    "process noise": "process noise moves the robot",
    "mismatch": "the robot moves by another model, or its inputs act late",
}


def contradiction_remarks(
    p_value: float,
    errors: Floats,
    white_noise_errors: Floats,
    sigma: Floats,
    correlation: Floats,
    *,
    unit: str = "px",
    departure: str = "unknown",
) -> tuple[str, ...]:
    """Return the remarks on residuals with this p-value; nothing for white residuals.

    `errors` include process noise of `sigma` (3,), or measurement noise of a `correlation` (3,).
    `white_noise_errors` include white measurement noise alone.
    """
    if not p_value < LEVEL:
        return ()
    shown = "p < 0.001" if p_value < 0.001 else f"p = {p_value:.2g}"
    n = mean_ratio(errors, white_noise_errors)
    like = "as " * (departure in ("none", "mismatch"))
    by = f"{like}for process noise of {equation_noise(sigma, unit, '.2g')} in each step"
    if correlation.any():
        departure = "none" if departure == "unknown" else departure
        by = f"for a correlation of {correlation.max():.2g} from step to step"
    limit = "; no correction covers a wrong model" * (departure in ("unknown", "mismatch"))
    return (
        f"the residuals are not white ({shown}): {_CAUSES[departure]}",
        f"standard errors for white measurement noise alone do not hold: they are {n:.2g} times "
        f"too small; the table has corrected ones, {by}{limit}",
    )


def mean_ratio(errors: Floats, others: Floats) -> float:
    """Return the geometric mean of errors over others, for the parameters that have both."""
    is_known = np.isfinite(errors) & np.isfinite(others) & (others > 0) & (errors > 0)
    ratios = errors[is_known] / others[is_known]
    return float(np.exp(np.mean(np.log(ratios)))) if ratios.size else 1.0


def lengths_in(unit: str) -> str:
    """Return the end of a title with the unit of lengths, unless it is the usual px."""
    return "" if unit == "px" else f", lengths in {unit}"


def equation_noise(sigma: Floats, unit: str, spec: str = ".3g") -> str:
    """Return standard deviations of x, y (in `unit`) and heading (rad) as displayed."""
    x, y, heading = sigma
    return f"{x:{spec}} {unit}, {y:{spec}} {unit}, {np.rad2deg(heading):{spec}} deg"
