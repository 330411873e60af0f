"""`grade_submission`, `grade_class`, `regrade_class`: the grading of submissions."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import Executor
from contextlib import closing
from dataclasses import replace
from os import PathLike
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from robsim.base.checks import check_bool, check_callable, check_choice, check_text
from robsim.base.files import as_path
from robsim.base.spelling import suggestion
from robsim.base.text import listed, one_line, quoted
from robsim.base.warn import warn_user
from robsim.campaigns.engines.engine import Engine, engine_value, rows_by
from robsim.campaigns.engines.executors import DaskClient
from robsim.teach.assignments.assignment import Assignment, check_is_assignment
from robsim.teach.assignments.class_result import ClassResult
from robsim.teach.assignments.classes.by_hand import take_table
from robsim.teach.assignments.classes.plan import Plan, names_of, plan_of
from robsim.teach.assignments.classes.progress import Schedule, again
from robsim.teach.assignments.classes.store import ResultFolder, other_programs, write_class_files
from robsim.teach.assignments.classes.submissions import (
    Handed,
    check_is_one,
    one_submission,
    submissions_in,
)
from robsim.teach.assignments.marking.references import key_for
from robsim.teach.assignments.marking.work import Unit
from robsim.teach.reports.tables import COLUMNS
from robsim.teach.reports.words import person
from robsim.teach.reports.writing import folder_name
from robsim.teach.results import ERROR, SubmissionResult, TestResult
from robsim.teach.submissions.archive import class_zips


def grade_submission(
    assignment: Assignment,
    submission: str | PathLike[str],
    out: str | PathLike[str] | None = None,
    *,
    student: str | None = None,
    public: bool = False,
    only: Iterable[str] | None = None,
    gradescope: str | PathLike[str] | None = None,
    teacher_pages: bool = False,
) -> SubmissionResult:
    """Grade a submission.

    Parameters
    ----------
    assignment : Assignment
        The assignment, with its tests and rules.
    submission : path
        A folder, a Python file, a notebook, or a zip of these.
    out : path, optional
        The folder for the result, see `grade_class`. Default: the result is not kept.
    student : str, optional
        The student's name, from which the worlds of hidden tests are derived. Default: the name
        of the folder or file, without its suffix.
    public : bool
        Run only the public tests.
    only : sequence of str, optional
        The names of the tests to run. Default: all.
    gradescope : path, optional
        The path of Gradescope's ``results.json``, written after each test.
    teacher_pages
        See `grade_class`.

    Returns
    -------
    SubmissionResult
        Points, sentences and numbers, including faults of the submission. A test that fails for
        another reason has the status ``"error"``.

    Raises
    ------
    AssignmentError
        If the assignment is incomplete or broken; then nothing runs.
    FileNotFoundError
        If the submission is missing.
    TypeError, ValueError
        If an argument is wrong; the message names it.
    OSError
        If the result cannot be written.

    Examples
    --------
    >>> import pathlib
    >>> assignment = robsim.teach.new_assignment("measure", "hw1", seed=1)
    >>> pathlib.Path("ann").mkdir()
    >>> size = pathlib.Path("ann/measure.py").write_text("def measure(step): return None")
    >>> result = robsim.teach.grade_submission(assignment, "ann", public=True)
    >>> [(test.name, test.points, test.most) for test in result.tests]
    [('public', 0.0, 3.0), ('test_a_hidden_robot_has_no_pose', 1.0, 1.0)]
    """
    check_is_assignment(assignment)
    handed = one_submission(submission, assignment)
    if student is not None:
        if not check_text("student", student):
            raise ValueError("student must be a name, got ''")
        handed = replace(handed, student=student, members=())
    file = None if gradescope is None else as_path(gradescope, "gradescope")
    if file is not None and student is None:
        check_is_one(handed, assignment)
    with TemporaryDirectory(prefix="robsim-graded-") as scratch:
        place = as_path(scratch if out is None else out, "out")
        check_bool("teacher_pages", teacher_pages)
        folder = ResultFolder(place, file, assignment.leaderboard, teacher_pages)
        plan = plan_of(assignment, only=only, public=public, waits=True)
        _check_apart(folder.folder, [handed])
        folder.by_hand = {} if public else take_table(plan, folder, [handed.student])
        (result,) = grade_all(Schedule(plan, [handed], folder)).results
    return result


def grade_class(
    assignment: Assignment,
    submissions: str | PathLike[str],
    out: str | PathLike[str],
    *,
    executor: int | str | Executor | DaskClient | None = None,
    public: bool = False,
    only: Iterable[str] | None = None,
    groups: str | PathLike[str] | None = None,
    columns: str = "robsim",
    pseudonyms: bool = False,
    teacher_pages: bool = False,
    on_result: Callable[[SubmissionResult, str], Any] | None = None,
) -> ClassResult:
    """Grade a class, and write the results.

    The function writes results after each test. A test with a result in `out` runs again only if
    the test or the submission has changed. So the same call continues a cancelled grading.

    The teacher edits ``by_hand.csv`` in `out`: late days, points that replace the tests' points, a
    comment, and the points of `Assignment.by_hand`. This function adds students to the table, and
    all results contain the table's marks.

    Parameters
    ----------
    assignment : Assignment
        The assignment, with its tests and rules.
    submissions : path
        The folder with the submissions, or a platform's zip of them, which is not unpacked; or a
        single submission.
    out : path
        The folder for the results: one folder for each student, and, of several students,
        ``class.html``, ``class.csv`` and ``by_hand.csv``.
    executor : int, "threads", concurrent.futures.Executor or Dask Client, optional
        The executor of the grading, as for `robsim.campaign`: a number of processes, or others,
        which must have access to the same folders. Default: this process.
    public
        See `grade_submission`.
    only : sequence of str, optional
        The names of tests to run, and of students to grade; other results are taken from `out`.
        Default: all.
    groups : path, optional
        A table with the columns group and student, or a grading worksheet of Moodle with a column
        group: each member gets the marks of the group.
        Default: ``groups.csv`` next to the submissions, if it exists.
    columns : {"robsim", "moodle", "canvas", "blackboard"}
        The learning platform that sets the columns of ``class.csv``.
    pseudonyms : bool
        Whether page and table of the class have pseudonyms instead of names.
    teacher_pages : bool
        Whether to write ``teacher.html`` of each submission, which also shows hidden tests. An
        old page is always overwritten.
    on_result : callable, optional
        Called with the result of each finished submission, and the reason of a repeated grading,
        or ``""``.

    Returns
    -------
    ClassResult
        All results.

    Raises
    ------
    AssignmentError, FileNotFoundError, TypeError, ValueError
        As for `grade_submission`, or if ``by_hand.csv`` is wrong. Then nothing runs.
    OSError
        If a result cannot be written.

    Warns
    -----
    UserWarning
        If the folder has files other than submissions, such as tables. If a student's results are
        in a folder with another name. If groups have no submission. If `out` has results of
        students without a submission.

    Examples
    --------
    >>> import pathlib
    >>> assignment = robsim.teach.new_assignment("measure", "hw1", seed=1)
    >>> pathlib.Path("class/ann").mkdir(parents=True)
    >>> size = pathlib.Path("class/ann/measure.py").write_text("def measure(step): return None")
    >>> result = robsim.teach.grade_class(assignment, "class", "marks", public=True)
    >>> pathlib.Path("marks/ann/index.html").exists()
    True
    """
    check_is_assignment(assignment)
    engine_value(executor)
    folder = _folder(assignment, out, columns, pseudonyms, teacher_pages)
    check_callable("on_result", on_result)
    asked = None if only is None else names_of(only)
    table = None if groups is None else as_path(groups, "groups")
    with class_zips():
        handed = submissions_in(submissions, assignment, warn_user, table)
        others = other_programs(assignment) if len(handed) > 1 else {}
        plan = plan_of(assignment, public=public, waits=True)
        students = None
        if asked is not None:
            plan, students = _only(plan, handed, asked)
        _check_apart(folder.folder, handed)
        folder.by_hand = take_table(plan, folder, [one.student for one in handed])
        _tell_others(folder, handed)
        done = grade_all(Schedule(plan, handed, folder, on_result, students), executor)
    results = sorted(done.results, key=lambda result: result.student)
    if left := [one.student for one in handed if one.student not in {r.student for r in results}]:
        warn_user(f"not graded yet, and not in the table: {listed(left)}")
    write_class_files(assignment, done.programs, others, folder, results)
    return ClassResult(name=assignment.name, results=tuple(results))


def regrade_class(
    assignment: Assignment,
    out: str | PathLike[str],
    *,
    columns: str = "robsim",
    pseudonyms: bool = False,
    teacher_pages: bool = False,
) -> ClassResult:
    """Recompute the marks after limits, points or ``by_hand.csv`` have changed.

    No test runs: the function uses the stored numbers, and the page of the class shows the stored
    similar programs.

    Parameters
    ----------
    assignment : Assignment
        The current assignment.
    out : path
        The folder of `grade_class`, whose files are overwritten.
    columns, pseudonyms, teacher_pages
        See `grade_class`.

    Returns
    -------
    ClassResult
        All results, and the students with changed points.

    Raises
    ------
    AssignmentError
        If the assignment is incomplete or broken.
    FileNotFoundError
        If no results exist.
    TypeError, ValueError
        If an argument is wrong, or more than limits and points has changed; then nothing is
        written.

    Examples
    --------
    >>> import pathlib
    >>> assignment = robsim.teach.new_assignment("measure", "hw1", seed=1)
    >>> pathlib.Path("class/ann").mkdir(parents=True)
    >>> size = pathlib.Path("class/ann/measure.py").write_text("def measure(step): return None")
    >>> graded = robsim.teach.grade_class(assignment, "class", "marks", public=True)
    >>> again = robsim.teach.regrade_class(assignment, "marks")
    >>> again.results[0].points == graded.results[0].points
    True
    """
    check_is_assignment(assignment)
    folder = _folder(assignment, out, columns, pseudonyms, teacher_pages)
    plan = plan_of(assignment)
    units = {name: unit for unit in plan.work.units for name in unit.names}
    students = folder.students()
    if not students:
        raise FileNotFoundError(2, "no results to regrade", str(out))
    old = [_old(folder, student) for student in students]
    title, digest = assignment.title, plan.digest
    results = [
        replace(one, title=title, tests=_tests(units, one), assignment_digest=digest) for one in old
    ]
    folder.by_hand = take_table(plan, folder, [one.student for one in old])
    results = [folder.write(result) for result in results]  # all of them can be
    write_class_files(assignment, None, {}, folder, results)
    changes = {
        one.student: (one.points, now.points)
        for one, now in zip(old, results, strict=True)
        if one.points != now.points
    }
    return ClassResult(name=assignment.name, results=tuple(results), changes=changes)


def _only(
    plan: Plan, handed: Sequence[Handed], only: Sequence[str]
) -> tuple[Plan, set[str] | None]:
    """Return a plan with the tests in `only`, and the names of the students in it."""
    students: dict[str, set[str]] = {}
    for one in handed:
        for name in (one.student, *one.members):
            for alias in (name, person(name)):
                students.setdefault(alias, set()).add(one.student)
    known = [*plan.wanted, *students]
    for name in only:
        if name not in known:
            what = f"{plan.assignment.name} has no test or student {quoted(name)}"
            raise ValueError(what + suggestion(name, known))
        if known.count(name) + len(students.get(name, "1")) > 2:
            raise ValueError(
                f"only: {quoted(name)} is ambiguous: several tests and students have this name, "
                f"{listed(sorted(students.get(name, ())))}"
            )
    tests = plan.wanted.intersection(only) or plan.wanted
    chosen = set().union(*(students.get(name, ()) for name in only))
    return replace(plan, wanted=tests), chosen or None


def _folder(
    assignment: Assignment, out: Any, columns: str, pseudonyms: bool, teacher_pages: bool
) -> ResultFolder:
    folder = ResultFolder(as_path(out, "out"))
    folder.teacher_pages = check_bool("teacher_pages", teacher_pages)
    folder.columns = check_choice("columns", columns, COLUMNS)
    if check_bool("pseudonyms", pseudonyms):
        folder.pseudonym = key_for(assignment, public=False).pseudonym
    return folder


def grade_all(schedule: Schedule, executor: Engine = None) -> Schedule:
    """Grade submissions, write each result after each test, and return the schedule at the end."""
    schedule.folder.folder.mkdir(parents=True, exist_ok=True)
    with closing(rows_by(engine_value(executor), schedule.plan.work, schedule)) as chunks:
        for rows in chunks:
            for row in rows:
                schedule.done(row)
    return schedule


def _check_apart(out: Path, handed: list[Handed]) -> None:
    place = Path(os.path.abspath(out))
    inside = {Path(one.path) for one in handed}
    if len(handed) > 1:
        inside |= {Path(one.path).parent for one in handed if not one.files}
    if place in inside or not inside.isdisjoint(place.parents):
        raise ValueError(
            f"out must be outside the submissions, got {one_line(out)}: robsim would "
            "mistake its own results for a submission"
        )


def _tell_others(folder: ResultFolder, handed: Sequence[Handed]) -> None:
    own = {folder_name(one.student) for one in handed}
    if len(handed) > 1 and (others := [name for name in folder.students() if name not in own]):
        warn_user(
            f"{one_line(folder.folder)} has results of students without a submission, which "
            f"--regrade includes: remove the folders of {', '.join(others)}"
        )


def _old(folder: ResultFolder, student: str) -> SubmissionResult:
    if (old := folder.read(student)) is None:
        raise ValueError(f"{one_line(folder.of(student))}: unreadable result")
    return old


def _tests(units: dict[str, Unit], old: SubmissionResult) -> tuple[TestResult, ...]:
    return tuple(_test(units, test, old.student) for test in old.tests if not test.by_hand)


def _test(units: dict[str, Unit], test: TestResult, student: str) -> TestResult:
    unit = units.get(test.name)
    if unit is None:
        raise ValueError(f"test {quoted(test.name)} no longer exists: grade again")
    if not test.digest or test.status == ERROR:  # not run yet
        return test
    if test.digest != unit.digest:
        raise ValueError(
            f"the test {test.name} has changed since the grading of {one_line(student)}. Its task, "
            "reference, rules or key differ, not only its limits and points: grade again"
        )
    return again(unit, test)
