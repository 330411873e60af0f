"""One kind of result: numbers with a title, tables, remarks and a verdict, in all formats."""

from robsim.base.report.problem import Problem
from robsim.base.report.report import Report
from robsim.base.report.table import Column, Quantity, Row, Table, count, interval, percent

__all__ = [
    "Column",
    "Problem",
    "Quantity",
    "Report",
    "Row",
    "Table",
    "count",
    "interval",
    "percent",
]
