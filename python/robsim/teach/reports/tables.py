"""The marks of a class as a table, with the columns of learning platforms."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Any

from robsim.base.checks import check_choice
from robsim.base.text import as_cell
from robsim.teach.reports import words
from robsim.teach.results import ERROR, NOT_RUN, SubmissionResult, fraction_of, number
from robsim.teach.texts import clean_line

_Rows = Iterator[list[Any]]
_MOST_FEEDBACK = 1000  # characters


def marks_table(
    results: Sequence[SubmissionResult], *, columns: str = "robsim", title: str | None = None
) -> str:
    """Return the points of a class as CSV, quoted and without formulas.

    The columns are one of these; other values raise ValueError:

    - ``"robsim"``: student, points, most, percent, the points of each test, notes.
    - ``"moodle"``: the columns of a grading worksheet of an assignment (offline grading), also
      accepted by the import of grades: Identifier, Full name, Grade, Maximum grade, Last modified
      (grade), Feedback comments, for a site in English. In the dialog, allow updating records
      that have been modified.
    - ``"canvas"``: Student, ID, SIS User ID, SIS Login ID, Section, and the points.
    - ``"blackboard"``: Username, and the points.

    Folders and files from these platforms have names and numbers of students, which fill the
    right columns. Other names count as login names. Each member of a group has a row. `title` is
    the heading of the points for Canvas and Blackboard, such as ``"Homework 3 (1234)"``. Its
    default is the title of the assignment.
    """
    check_choice("columns", columns, COLUMNS)
    heading = clean_line(title if title is not None else results[0].title if results else "")
    each = [
        replace(result, student=student)
        for result in results
        for student in result.members or [result.student]
    ]
    rows = _COLUMNS[columns](each, heading)
    content = io.StringIO()
    writer = csv.writer(content, quoting=csv.QUOTE_ALL, lineterminator="\r\n")
    writer.writerows([_cell(value) for value in row] for row in rows)
    return content.getvalue()


def _cell(value: Any) -> Any:
    if isinstance(value, str):
        return as_cell(clean_line(value, _MOST_FEEDBACK))
    return "" if value is None else number(value)


def _for_robsim(results: Sequence[SubmissionResult], _: str) -> _Rows:
    names = list(dict.fromkeys(test.name for result in results for test in result.tests))
    yield ["student", "points", "most", "percent", *names, "is_done", "notes"]
    for result in results:
        points, most = result.points, result.most
        graded = (test for test in result.tests if test.status not in (ERROR, NOT_RUN))
        tests = {test.name: test.points for test in graded}
        each = [tests.get(name) for name in names]
        share = round(100 * fraction_of(points, most), 2)
        done = "yes" if result.is_done else "no"
        yield [result.student, points, most, share, *each, done, " ".join(words.notes(result))]


def _for_moodle(results: Sequence[SubmissionResult], _: str) -> _Rows:
    grade = ("Grade", "Maximum grade", "Last modified (grade)", "Feedback comments")
    yield ["Identifier", "Full name", *grade]
    for result in results:
        match = words.OF_MOODLE.fullmatch(result.student)
        who = [f"Participant {match['number']}", match["name"]] if match else [result.student] * 2
        yield [*who, result.points, result.most, None, " ".join(_feedback(result))]


def _for_canvas(results: Sequence[SubmissionResult], title: str) -> _Rows:
    yield ["Student", "ID", "SIS User ID", "SIS Login ID", "Section", title]
    most = max((result.most for result in results), default=0.0)
    yield ["    Points Possible", None, None, None, None, most]
    for result in results:
        match = words.OF_CANVAS.fullmatch(result.student)
        name = result.student
        who = [match["name"], match["number"], None, None] if match else [name, None, None, name]
        yield [*who, None, result.points]


def _for_blackboard(results: Sequence[SubmissionResult], title: str) -> _Rows:
    yield ["Username", title]
    for result in results:
        match = words.OF_BLACKBOARD.fullmatch(result.student)
        yield [match["student"] if match else result.student, result.points]


def _feedback(result: SubmissionResult) -> Iterator[str]:
    yield from (*words.by_hand(result), *words.provisional(result))
    told = set()  # all tests of an unreadable submission have the same sentence
    for test in result.tests:
        yield f"{words.test_title(test)}: {words.result_text(test)}."
        if test.sentence and test.points < test.most and test.sentence not in told:
            yield test.sentence if test.sentence.endswith(".") else f"{test.sentence}."
            told.add(test.sentence)


_COLUMNS: dict[str, Callable[[Sequence[SubmissionResult], str], _Rows]] = {
    "robsim": _for_robsim,
    "moodle": _for_moodle,
    "canvas": _for_canvas,
    "blackboard": _for_blackboard,
}
#: The columns that a table of marks can have.
COLUMNS = tuple(_COLUMNS)
