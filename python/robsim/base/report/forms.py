"""A report as data, as HTML and as text."""

from __future__ import annotations

import html
import math
import textwrap
from collections.abc import Iterable, Iterator
from itertools import repeat
from typing import TYPE_CHECKING, Any

from robsim.base.report.optional import import_optional
from robsim.base.report.problem import Problem
from robsim.base.report.table import Table, plain
from robsim.base.text import one_line, printable

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
    """Return the units of quantities and columns that have one; rows carry their own units."""
    units: dict[str, Any] = {one.key: one.unit for one in report.quantities if one.unit}
    for table in report.tables:
        if columns := {column.key: column.unit for column in table.columns if column.unit}:
            units[table.key] = columns
    return units


def as_frame(report: Report) -> pandas.DataFrame:
    """Return the first table of a report, or else its problems or quantities."""
    pd = import_optional("pandas", "to_pandas needs")
    name, rows = _rows(report)
    known = [
        {key: math.nan if value is None else value for key, value in row.items()} for _, row in rows
    ]
    index = pd.Index([label for label, _ in rows], name=name or None)
    frame: pandas.DataFrame = pd.DataFrame(known, index=index)
    frame.attrs = {"title": report.title, "verdict": report.verdict}
    return frame


def _rows(report: Report) -> tuple[str, list[tuple[Any, dict[str, Any]]]]:
    """Return the kind of the rows, their labels and their values."""
    if report.tables:
        return report.tables[0].row_title, list(report.tables[0].records())
    if report.problems is not None:
        problems = enumerate(report.problems, 1)
        return "problem", [(number, problem.to_dict()) for number, problem in problems]
    quantities = report.quantities
    return "quantity", [(one.key, {"value": one.value, "unit": one.unit}) for one in quantities]


# JupyterLab centres tables, and the sentences below them stand at the left.
_TABLE = '<table style="margin: 0 0 1em 0">'


def as_html(report: Report) -> str:
    """Return a report as HTML."""
    tables = []
    if report.quantities:
        rows = [[quantity.title_with_unit, quantity.text] for quantity in report.quantities]
        tables.append(_body(rows, ["left", "left"], group=0))
    for table in report.tables:
        head = map(_cell, repeat("th"), table.column_titles, table.alignments)
        body = _body(table.texts(), table.alignments, table.group)
        tables.append(f"<thead><tr>{''.join(head)}</tr></thead>{body}")
    start = f"<p><b>{escape(report.headline)}</b></p>"
    middle = "".join(f"{_TABLE}{content}</table>" for content in tables)
    problems = _listed("ol", map(_problem_html, report.problems or ()))
    return f"<div>{start}{middle}{problems}{_listed('ul', map(escape, report.remarks))}</div>"


def escape(text: str) -> str:
    """Return a text that is only shown: no tag, and nothing that turns the text around it."""
    return html.escape(printable(text))


def _body(rows: Iterable[list[str]], alignments: list[str], group: int) -> str:
    """Return the rows, with a rule above each group but the first."""
    kinds = ("th", *repeat("td", len(alignments) - 1))
    lines = []
    for number, row in enumerate(rows):
        is_first = bool(group and number and number % group == 0)
        start = '<tr style="border-top: 1px solid">' if is_first else "<tr>"
        lines.append(f"{start}{''.join(map(_cell, kinds, row, alignments))}</tr>")
    return f"<tbody>{''.join(lines)}</tbody>"


def _cell(tag: str, text: str, align: str) -> str:
    return f'<{tag} style="text-align: {align}">{escape(text)}</{tag}>'


def _listed(tag: str, items: Iterable[str]) -> str:
    content = "".join(f"<li>{item}</li>" for item in items)
    return f"<{tag}>{content}</{tag}>" if content else ""


def _problem_html(problem: Problem) -> str:
    where = f"<br><small>{escape(problem.where)}</small>" if problem.where else ""
    code = f"<br><code>{escape(problem.code)}</code>" if problem.code else ""
    return f"{escape(problem.sentence)}{where}{code}"


_WIDTH = 100


def as_text(report: Report) -> str:
    """Return a report as lines of text."""
    lines = [one_line(report.headline), *_quantities(report)]
    for table in report.tables:
        lines += [""] * (len(lines) > 1) + [*_table(table)]
    for number, problem in enumerate(report.problems or (), 1):
        lines += _problem(number, problem)
    for remark in report.remarks:
        lines += _wrapped("  - ", remark)
    return "\n".join(lines)


def as_line(report: Report, width: float = math.inf) -> str:
    """Return the headline, and as many single numbers as fit."""
    line = one_line(report.headline)
    for quantity in report.quantities:
        longer = f"{line}, {one_line(quantity.line)}"
        if len(longer) > width:
            return f"{line}, ..."
        line = longer
    return line


def _quantities(report: Report) -> Iterator[str]:
    rows = [(one_line(one.title_with_unit), one_line(one.text)) for one in report.quantities]
    width = max((len(title) for title, _ in rows), default=0)
    for title, text in rows:
        yield f"  {title:<{width}}   {text}"


def _table(table: Table) -> Iterator[str]:
    rows = [[one_line(cell) for cell in row] for row in (table.column_titles, *table.texts())]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    rule = "  " + "-" * (sum(widths) + 3 * (len(widths) - 1))
    for number, cells in enumerate(rows):
        if number and (number - 1) % (table.group or len(rows)) == 0:
            yield rule
        aligned = (
            cell.ljust(width) if align == "left" else cell.rjust(width)
            for cell, width, align in zip(cells, widths, table.alignments, strict=True)
        )
        yield f"  {'   '.join(aligned)}".rstrip()


def _problem(number: int, problem: Problem) -> Iterator[str]:
    yield from _wrapped(f"  {number}. ", problem.sentence)
    if problem.where:
        yield f"     {one_line(problem.where)}"
    if problem.code:
        yield f"     > {one_line(problem.code)}"


def _wrapped(start: str, sentence: str) -> list[str]:
    return textwrap.wrap(
        printable(sentence),
        _WIDTH,
        initial_indent=start,
        subsequent_indent=" " * len(start),
        break_long_words=False,
        break_on_hyphens=False,
    )
