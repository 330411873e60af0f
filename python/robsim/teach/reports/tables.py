"""The marks of a class as a table, with the columns that learning platforms take."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Callable, Iterable, Sequence
from typing import Any

from robsim.base.checks import check_choice
from robsim.base.text import as_cell
from robsim.teach.assignments.results import (
    ERROR,
    NOT_RUN,
    SubmissionResult,
    TestResult,
    fraction_of,
    number,
)
from robsim.teach.reports import words
from robsim.teach.texts import clean_line

_Rows = list[list[Any]]
_MOST_FEEDBACK = 1000  # characters
# How the platforms name what they give to download.
_OF_CANVAS = re.compile(r"(?P<name>[^_]+)_(LATE_)?(?P<number>\d+)_\d+_.+")
_OF_BLACKBOARD = re.compile(r".+_(?P<name>[^_]+)_attempt_\d{4}(-\d\d){5}(_.*)?")


def marks_table(
    results: Sequence[SubmissionResult], *, columns: str = "robsim", title: str | None = None
) -> str:
    """Return the points of a class as CSV.

    Parameters
    ----------
    results : sequence of SubmissionResult
        Those of all submissions.
    columns : {"robsim", "moodle", "canvas", "blackboard"}
        Which columns, in which order:

        - ``"robsim"``: student, points, most, percent, the points of each test, notes.
        - ``"moodle"``: those of a grading worksheet of an assignment (offline grading), which the
          import of grades takes, too: Identifier, Full name, Grade, Maximum grade, Last modified
          (grade), Feedback comments, for a site in English. In the dialog, allow updating records
          that have been modified.
        - ``"canvas"``: Student, ID, SIS User ID, SIS Login ID, Section, and the points.
        - ``"blackboard"``: Username, and the points.

        Folders and files that were downloaded from these platforms have names that say who it is:
        these go into the right columns. Other names are taken for names to log in with.
    title : str, optional
        Heading of the column of points, for Canvas and Blackboard: for an assignment that is there
        as the platform exports it, such as ``"Homework 3 (1234)"``. Default: the title of the
        assignment.

    Returns
    -------
    str
        The table. All of it is quoted, and no text in it is taken for a formula.

    Raises
    ------
    ValueError
        If there are no such columns.
    """
    check_choice("columns", columns, COLUMNS)
    heading = clean_line(title if title is not None else results[0].title if results else "")
    rows = _COLUMNS[columns](results, heading)
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
    head = ["student", "points", "most", "percent", *names, "is_done", "notes"]
    return [head, *(_row(result, names) for result in results)]


def _row(result: SubmissionResult, names: Sequence[str]) -> list[Any]:
    points, most = result.points, result.most
    tests = {test.name: test for test in result.tests}
    each = [_points(tests.get(name)) for name in names]
    share = round(100 * fraction_of(points, most), 2)
    done = "yes" if result.is_done else "no"
    return [result.student, points, most, share, *each, done, " ".join(result.notes)]


def _points(test: TestResult | None) -> float | None:
    return None if test is None or test.status in (ERROR, NOT_RUN) else test.points


def _for_moodle(results: Sequence[SubmissionResult], _: str) -> _Rows:
    grade = ("Grade", "Maximum grade", "Last modified (grade)", "Feedback comments")
    rows: _Rows = [["Identifier", "Full name", *grade]]
    for result in results:
        match = words.OF_MOODLE.fullmatch(result.student)
        who = [f"Participant {match['number']}", match["name"]] if match else [result.student] * 2
        points = result.points, result.most
        rows.append([*who, *points, None, _feedback(result)])
    return rows


def _for_canvas(results: Sequence[SubmissionResult], title: str) -> _Rows:
    rows: _Rows = [["Student", "ID", "SIS User ID", "SIS Login ID", "Section", title]]
    most = max((result.most for result in results), default=0.0)
    rows.append(["    Points Possible", None, None, None, None, most])
    for result in results:
        match = _OF_CANVAS.fullmatch(result.student)
        who = [match["name"], match["number"], None] if match else [result.student, None, None]
        login = None if match else result.student
        rows.append([*who, login, None, result.points])
    return rows


def _for_blackboard(results: Sequence[SubmissionResult], title: str) -> _Rows:
    rows: _Rows = [["Username", title]]
    for result in results:
        match = _OF_BLACKBOARD.fullmatch(result.student)
        rows.append([match["name"] if match else result.student, result.points])
    return rows


def _feedback(result: SubmissionResult) -> str:
    """Return the points of each test, and the sentences of those without all points."""
    return " ".join(_parts(result.tests))


def _parts(tests: Iterable[TestResult]) -> Iterable[str]:
    told = set()  # of a submission that cannot be read all tests say the same
    for test in tests:
        yield f"{words.heading(test)}: {words.result_text(test)}."
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
