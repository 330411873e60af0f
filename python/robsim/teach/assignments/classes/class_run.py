"""`grade_submission`, `grade_class`, `regrade_class`: from submissions to marks."""

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
        The folder for the result, as of `grade_class`. Default: it is not kept.
    student : str, optional
        The student's name, which the worlds of tests that are not public come from. Default:
        that of the folder or file, without its ending.
    public : bool
        Only the tests that students have, too.
    only : sequence of str, optional
        The names of the tests to run. Default: all.
    gradescope : path, optional
        Where the result is written after each test as Gradescope reads it, ``results.json``.
    teacher_pages
        As for `grade_class`.

    Returns
    -------
    SubmissionResult
        Points, sentences and numbers. What is the submission's fault is in it; a test that
        failed by a fault of others has the status ``"error"``.

    Raises
    ------
    AssignmentError
        If the assignment is not complete, or broken: nothing is run then.
    FileNotFoundError
        If there is no such submission.
    TypeError, ValueError
        If an argument is wrong; the message names it.
    OSError
        If the result cannot be written.
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
    """Grade a class, and write what came of it.

    Results are written after each test. What `out` has already of submissions and tests that
    have not changed is not run again: the same call goes on where one was ended.

    ``by_hand.csv`` in `out` is the teacher's: late days, points that replace the tests' points,
    a comment, and the points of `Assignment.by_hand`. This function adds students to it, and
    all results contain its marks.

    Parameters
    ----------
    assignment : Assignment
        The assignment, with its tests and rules.
    submissions : path
        The folder with the submissions, or the zip of them as a platform packs it, which is not
        unpacked; or a single one.
    out : path
        The folder for the results: one for each student, and of several ``class.html``,
        ``class.csv`` and ``by_hand.csv``.
    executor : int, "threads", concurrent.futures.Executor or Dask Client, optional
        What grades, as for `robsim.campaign`: so many processes, or others, which must see the
        same folders. Default: this process.
    public
        As for `grade_submission`.
    only : sequence of str, optional
        The names of tests to run, and of students to grade; the results of others are those in
        `out`. Default: all.
    groups : path, optional
        A table with the columns group and student, or a grading worksheet of Moodle with a column
        group: each member gets the marks of the group.
        Default: ``groups.csv`` beside the submissions, if there is one.
    columns : {"robsim", "moodle", "canvas", "blackboard"}
        The learning platform whose columns ``class.csv`` has.
    pseudonyms : bool
        Whether page and table of the class have pseudonyms instead of names.
    teacher_pages : bool
        Whether to write ``teacher.html`` of each submission, which also shows hidden tests. An
        old one is always replaced.
    on_result : callable, optional
        Is called with the result of each finished submission, and the reason why it was graded
        again, ``""`` if it was not.

    Returns
    -------
    ClassResult
        The results of all.

    Raises
    ------
    AssignmentError, FileNotFoundError, TypeError, ValueError
        As `grade_submission`; also if ``by_hand.csv`` is wrong: nothing is run then.
    OSError
        If a result cannot be written.

    Warns
    -----
    UserWarning
        If files in the folder are no submissions, such as tables: they are left out. If results
        are in folders with other names than the students. About groups without a submission.
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

    Nothing is run: the numbers of the runs are those in the folder, and so are the similar programs
    on the page of the class.

    Parameters
    ----------
    assignment : Assignment
        The assignment as it is now.
    out : path
        The folder that `grade_class` has written, whose files are written anew.
    columns, pseudonyms, teacher_pages
        As for `grade_class`.

    Returns
    -------
    ClassResult
        The results of all, and whose points have changed.

    Raises
    ------
    AssignmentError
        If the assignment is not complete, or broken.
    FileNotFoundError
        If there are no results.
    TypeError, ValueError
        If an argument is wrong, or more than limits and points has changed: nothing is written
        then.
    """
    check_is_assignment(assignment)
    folder = _folder(assignment, out, columns, pseudonyms, teacher_pages)
    plan = plan_of(assignment)
    units = {name: unit for unit in plan.work.units for name in unit.names}
    students = folder.students()
    if not students:
        raise FileNotFoundError(2, "there are no results to be marked anew", str(out))
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
                f"only: {quoted(name)} is not clear: several tests and students have it"
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
            f"out must be apart from the submissions, got {one_line(out)}: what is written there "
            "would be taken for one"
        )


def _old(folder: ResultFolder, student: str) -> SubmissionResult:
    if (old := folder.read(student)) is None:
        raise ValueError(f"{one_line(folder.of(student))}: its result cannot be read")
    return old


def _tests(units: dict[str, Unit], old: SubmissionResult) -> tuple[TestResult, ...]:
    return tuple(_test(units, test, old.student) for test in old.tests if not test.by_hand)


def _test(units: dict[str, Unit], test: TestResult, student: str) -> TestResult:
    unit = units.get(test.name)
    if unit is None:
        raise ValueError(f"there is no test {quoted(test.name)} any more: grade anew")
    if not test.digest or test.status == ERROR:  # it is still to be run
        return test
    if test.digest != unit.digest:
        raise ValueError(
            f"the test {test.name} is not the one that {one_line(student)} was graded by: its "
            "task, reference, rules or key have changed, and not its limits and points alone; "
            "grade anew"
        )
    return again(unit, test)
