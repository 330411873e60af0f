"""A report for a terminal: aligned columns, sentences that end before the edge."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterator
from typing import TYPE_CHECKING

from robsim.base.report.problem import Problem
from robsim.base.report.table import Table
from robsim.base.text import one_line, printable

if TYPE_CHECKING:
    from robsim.base.report.report import Report

_WIDTH = 100


def as_text(report: Report) -> str:
    """Return a report as lines of text."""
    lines = [one_line(report.heading), *_quantities(report)]
    for table in report.tables:
        lines += [""] * (len(lines) > 1) + [*_table(table)]
    for number, problem in enumerate(report.problems or (), 1):
        lines += _problem(number, problem)
    for remark in report.remarks:
        lines += _wrapped("  - ", remark)
    return "\n".join(lines)


def as_line(report: Report, width: float = math.inf) -> str:
    """Return the heading, and as many of the single numbers as there is room for."""
    line = one_line(report.heading)
    for quantity in report.quantities:
        longer = f"{line}, {one_line(quantity.line)}"
        if len(longer) > width:
            return f"{line}, ..."
        line = longer
    return line


def _quantities(report: Report) -> Iterator[str]:
    rows = [(one_line(one.heading), one_line(one.text)) for one in report.quantities]
    width = max((len(heading) for heading, _ in rows), default=0)
    for heading, text in rows:
        yield f"  {heading:<{width}}   {text}"


def _table(table: Table) -> Iterator[str]:
    rows = [[one_line(cell) for cell in row] for row in (table.headings, *table.texts())]
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
