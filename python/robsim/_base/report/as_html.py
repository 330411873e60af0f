"""A report for a notebook: plain tables in the notebook's own colours, every text escaped."""

from __future__ import annotations

from collections.abc import Iterable
from html import escape
from itertools import repeat
from typing import TYPE_CHECKING

from robsim._base.report.problem import Problem

if TYPE_CHECKING:
    from robsim._base.report.report import Report

_CAPTION = '<caption style="caption-side: top; text-align: left; font-weight: bold">'


def as_html(report: Report) -> str:
    """Return a report as HTML."""
    tables = []
    if report.quantities:
        rows = [[quantity.heading, quantity.text] for quantity in report.quantities]
        tables.append(_body(rows, ["left", "left"]))
    for table in report.tables:
        head = map(_cell, repeat("th"), table.headings, table.alignments)
        body = _body(table.texts(), table.alignments)
        tables.append(f"<thead><tr>{''.join(head)}</tr></thead>{body}")
    if tables:
        tables[0] = f"{_CAPTION}{escape(report.heading)}</caption>{tables[0]}"
        start = "".join(f"<table>{content}</table>" for content in tables)
    else:
        start = f"<p><b>{escape(report.heading)}</b></p>"
    problems = _listed("ol", map(_problem, report.problems or ()))
    return f"<div>{start}{problems}{_listed('ul', map(escape, report.remarks))}</div>"


def _body(rows: Iterable[list[str]], alignments: list[str]) -> str:
    kinds = ("th", *repeat("td", len(alignments) - 1))
    lines = ("".join(map(_cell, kinds, row, alignments)) for row in rows)
    return f"<tbody>{''.join(f'<tr>{line}</tr>' for line in lines)}</tbody>"


def _cell(tag: str, text: str, align: str) -> str:
    return f'<{tag} style="text-align: {align}">{escape(text)}</{tag}>'


def _listed(tag: str, items: Iterable[str]) -> str:
    content = "".join(f"<li>{item}</li>" for item in items)
    return f"<{tag}>{content}</{tag}>" if content else ""


def _problem(problem: Problem) -> str:
    where = f"<br><small>{escape(problem.where)}</small>" if problem.where else ""
    code = f"<br><code>{escape(problem.code)}</code>" if problem.code else ""
    return f"{escape(problem.sentence)}{where}{code}"
