"""A report for a notebook: plain tables in the notebook's own colours, every text escaped."""

from __future__ import annotations

import html
from collections.abc import Iterable
from itertools import repeat
from typing import TYPE_CHECKING

from robsim.base.report.problem import Problem
from robsim.base.text import printable

if TYPE_CHECKING:
    from robsim.base.report.report import Report

# JupyterLab centres tables, and the sentences below them stand at the left.
_TABLE = '<table style="margin: 0 0 1em 0">'


def as_html(report: Report) -> str:
    """Return a report as HTML."""
    tables = []
    if report.quantities:
        rows = [[quantity.heading, quantity.text] for quantity in report.quantities]
        tables.append(_body(rows, ["left", "left"], group=0))
    for table in report.tables:
        head = map(_cell, repeat("th"), table.headings, table.alignments)
        body = _body(table.texts(), table.alignments, table.group)
        tables.append(f"<thead><tr>{''.join(head)}</tr></thead>{body}")
    start = f"<p><b>{escape(report.heading)}</b></p>"
    middle = "".join(f"{_TABLE}{content}</table>" for content in tables)
    problems = _listed("ol", map(_problem, report.problems or ()))
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


def _problem(problem: Problem) -> str:
    where = f"<br><small>{escape(problem.where)}</small>" if problem.where else ""
    code = f"<br><code>{escape(problem.code)}</code>" if problem.code else ""
    return f"{escape(problem.sentence)}{where}{code}"
