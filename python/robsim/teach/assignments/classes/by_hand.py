"""The table ``by_hand.csv`` of a teacher, next to the results of a class."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence

from robsim.base.spelling import suggestion
from robsim.base.text import as_cell, quoted
from robsim.teach.assignments.assignment import BY_HAND, Assignment, LateRule
from robsim.teach.assignments.classes.plan import Plan
from robsim.teach.assignments.classes.store import Marks, ResultFolder
from robsim.teach.assignments.classes.table import EXTRA, Table
from robsim.teach.errors import AssignmentError
from robsim.teach.reports.writing import TABLE
from robsim.teach.results import FAILED, NOT_RUN, PARTIAL, PASSED, ByHand, TestResult, number
from robsim.teach.texts import clean_text

_MOST_COMMENT = 2000  # characters
_NUMBER = re.compile(r"-?[0-9]+([.,][0-9]*)?")


def take_table(plan: Plan, folder: ResultFolder, students: Sequence[str]) -> dict[str, Marks]:
    """Return the marks by hand of students, and add missing students to the table.

    A single submission needs no table. Raise AssignmentError with all faults of the table.
    """
    file = folder.folder / TABLE
    if len(students) < 2 and not file.exists():
        return {}
    try:
        table = Table.read(file) if file.exists() else Table(file, ["student"], [])
    except ValueError as error:
        raise AssignmentError(str(error), file=TABLE) from None
    limits = _limits(plan)
    known = {as_cell(student) for student in (*folder.students(), *students)}
    rows = [row for row in table.rows if any(row.values())]
    faults = [*_of_columns(table, limits)] or [*_of_students(rows, known), *_of_cells(rows, limits)]
    if faults:
        raise AssignmentError(f"{TABLE}: {'; '.join(faults)}", file=TABLE)
    found = {row["student"].strip(): row for row in rows}
    new = [cell for cell in map(as_cell, students) if cell not in found]
    table.complete([*BY_HAND, *plan.assignment.by_hand], new)
    return {one: _marks(found.get(as_cell(one), {}), plan.assignment) for one in students}


def _limits(plan: Plan) -> dict[str, float]:
    """Return the numeric columns, and their maxima."""
    units = (unit.unmarked(status=NOT_RUN) for unit in plan.work.units)
    most = sum(test.most for tests in units for test in tests)
    days = math.inf if plan.assignment.late else 0.0
    return {"late_days": days, "points": most, **plan.assignment.by_hand}


def _marks(row: Mapping[str, str], assignment: Assignment) -> Marks:
    days = _value(row, "late_days") or 0.0
    late = assignment.late or LateRule(per_day=0.0)
    kept = 1 - min(late.per_day * max(days - late.free_days, 0.0), 1.0)
    kept = 0.0 if days > late.most_days else kept
    points = _value(row, "points")
    comment = clean_text(row.get("comment", "").strip(), _MOST_COMMENT)
    parts = [_part(name, _value(row, name), most) for name, most in assignment.by_hand.items()]
    return ByHand(late_days=days, kept=kept, points=points, comment=comment), tuple(parts)


def _part(name: str, points: float | None, most: float) -> TestResult:
    status = PASSED if (points or 0) >= most else PARTIAL if points else FAILED
    return TestResult(
        name=name,
        title=name,
        points=points or 0.0,
        most=most,
        status=NOT_RUN if points is None else status,
        sentence="These points are not given yet." if points is None else "",
        by_hand=True,
    )


def _value(row: Mapping[str, str], name: str) -> float | None:
    cell = row.get(name, "").strip().replace(",", ".")
    return float(cell) if cell else None


def _of_columns(table: Table, limits: Mapping[str, float]) -> Iterator[str]:
    known = (*BY_HAND, *limits)
    if "student" not in table.columns:
        yield "the column student is missing"
    for name in dict.fromkeys(filter(None, table.columns)):
        if name not in known:
            yield f"unknown column {quoted(name)}{suggestion(name, known)}"
        elif table.columns.count(name) > 1:
            yield f"duplicate column {name}"
    if any(any(row.get(EXTRA, ())) for row in table.rows):
        yield "a row has more cells than columns: put a comment in quotes"


def _of_students(rows: Sequence[Mapping[str, str]], known: set[str]) -> Iterator[str]:
    told = [row["student"].strip() for row in rows]
    for student in dict.fromkeys(told):
        if student not in known:
            yield f"unknown student {quoted(student)}{suggestion(student, known)}"
        elif told.count(student) > 1:
            yield f"{student} has {told.count(student)} rows"


def _of_cells(rows: Sequence[Mapping[str, str]], limits: Mapping[str, float]) -> Iterator[str]:
    for row in rows:
        for name, most in limits.items():
            cell = row.get(name, "").strip()
            if cell and not _NUMBER.fullmatch(cell):
                yield f"{row['student']}: {name} must be a number, got {quoted(cell)}"
            elif not 0 <= (_value(row, name) or 0.0) <= most:
                words = {0.0: "0, because assignment.toml has no [late]", math.inf: "at least 0"}
                limit = words.get(most, f"0 to {number(most)}")
                yield f"{row['student']}: {name} must be {limit}, got {cell}"
