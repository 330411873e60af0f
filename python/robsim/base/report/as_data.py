"""A report for programs: plain values, and a data frame."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from robsim.base.report.optional import import_optional
from robsim.base.report.table import plain

if TYPE_CHECKING:
    import pandas

    from robsim.base.report.report import Report


def as_dict(report: Report) -> dict[str, Any]:
    """Return name -> value, as JSON has it."""
    content: dict[str, Any] = {"title": report.title}
    if report.verdict is not None:
        content["verdict"] = report.verdict
    if report.at_limit is not None:
        content["at_limit"] = report.at_limit
    content |= {quantity.key: quantity.value for quantity in report.quantities}
    content |= {table.key: dict(table.records()) for table in report.tables}
    if units := _units(report):
        content["units"] = units
    if report.problems is not None:
        content["problems"] = [problem.to_dict() for problem in report.problems]
    if report.remarks:
        content["remarks"] = list(report.remarks)
    values: dict[str, Any] = plain(content)
    return values


def _units(report: Report) -> dict[str, Any]:
    """Return the units of quantities and columns that have one; rows have theirs beside them."""
    units: dict[str, Any] = {one.key: one.unit for one in report.quantities if one.unit}
    for table in report.tables:
        if columns := {column.key: column.unit for column in table.columns if column.unit}:
            units[table.key] = columns
    return units


def as_frame(report: Report) -> pandas.DataFrame:
    """Return the first table of a report, or else its problems or quantities."""
    pd = import_pandas()
    name, rows = _rows(report)
    known = [
        {key: math.nan if value is None else value for key, value in row.items()} for _, row in rows
    ]
    index = pd.Index([label for label, _ in rows], name=name or None)
    frame: pandas.DataFrame = pd.DataFrame(known, index=index)
    frame.attrs = {"title": report.title, "verdict": report.verdict}
    return frame


def _rows(report: Report) -> tuple[str, list[tuple[Any, dict[str, Any]]]]:
    """Return what the rows are, and their labels and values."""
    if report.tables:
        return report.tables[0].row_title, list(report.tables[0].records())
    if report.problems is not None:
        problems = enumerate(report.problems, 1)
        return "problem", [(number, problem.to_dict()) for number, problem in problems]
    quantities = report.quantities
    return "quantity", [(one.key, {"value": one.value, "unit": one.unit}) for one in quantities]


def import_pandas() -> Any:
    return import_optional("pandas", "to_pandas needs")
