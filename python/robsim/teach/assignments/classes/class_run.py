"""Grading a submission, and grading a class."""

from __future__ import annotations

import os
from collections.abc import Iterable
from contextlib import closing
from os import PathLike
from pathlib import Path
from typing import Any

from robsim.base.checks import check_text
from robsim.base.files import as_folder, as_path
from robsim.base.text import one_line, quoted
from robsim.campaigns.engines.engine import Engine, engine_value, rows_by
from robsim.teach.assignments.assignment import Assignment
from robsim.teach.assignments.class_result import ClassResult
from robsim.teach.assignments.classes.plan import Plan, plan_of
from robsim.teach.assignments.classes.progress import Progress, again
from robsim.teach.assignments.classes.schedule import Keep, Schedule, Tell
from robsim.teach.assignments.classes.store import ClassTables, ResultFolder, write_class_files
from robsim.teach.assignments.classes.submissions import Handed, one_submission, submissions_in
from robsim.teach.assignments.grading.work import Unit
from robsim.teach.assignments.results import ERROR, SubmissionResult, TestResult


def grade_one(
    assignment: Assignment,
    submission: str | PathLike[str],
    *,
    student: str | None,
    public: bool,
    only: Iterable[str] | None,
) -> SubmissionResult:
    """Grade a submission; see `Assignment.grade`."""
    handed = one_submission(submission)
    if student is not None:
        handed = Handed(check_text("student", student), handed.path)
    plan = plan_of(assignment, only=only, public=public)
    progress, grader = Progress(0, handed, plan, None), plan.work.doer()
    while (job := progress.next()) is not None:
        progress.take(grader.rows([job])[0])
    return progress.result


def grade_all(
    plan: Plan,
    handed: list[Handed],
    out: str | PathLike[str],
    *,
    executor: Engine = None,
    tell: Tell,
    keep: Keep = lambda result: None,
) -> ClassResult:
    """Grade submissions, and write what came of each after each test.

    Parameters
    ----------
    plan : Plan
        What is graded.
    handed : list of Handed
        The submissions.
    out : path
        Where results are written, and those of before are gone on with.
    executor : int, "threads", concurrent.futures.Executor or Dask Client, optional
        What grades, as for `robsim.campaign`.
    tell : callable
        Is told of each submission that is done.
    keep : callable
        Is given the result so far after each test, when it is written.
    """
    engine = engine_value(executor)
    place = as_folder(out)
    _check_apart(place, handed)
    place.mkdir(parents=True, exist_ok=True)
    schedule = Schedule(plan, handed, ResultFolder(place), tell, keep)
    with closing(rows_by(engine, plan.work, schedule)) as chunks:
        for rows in chunks:
            for row in rows:
                schedule.done(row)
    results = sorted(schedule.results, key=lambda result: result.student)
    return ClassResult(name=plan.assignment.name, results=tuple(results))


def grade_class(
    assignment: Assignment,
    submissions: str | PathLike[str],
    out: str | PathLike[str],
    *,
    executor: Any,
    public: bool,
    only: Iterable[str] | None,
) -> ClassResult:
    """Grade a class; see `Assignment.grade_class`."""
    engine_value(executor)
    as_path(out, "out")
    handed = submissions_in(submissions, assignment)
    plan = plan_of(assignment, only=only, public=public)
    result = grade_all(plan, handed, out, executor=executor, tell=lambda result, changed: None)
    folder = ResultFolder(as_folder(out))
    write_class_files(assignment, handed, folder, result.results, ClassTables())
    return result


def _check_apart(out: Path, handed: list[Handed]) -> None:
    """Raise ValueError where results would lie among submissions."""
    place = Path(os.path.abspath(out))
    folders = {Path(one.path).parent for one in handed} if len(handed) > 1 else set()
    inside = {Path(one.path) for one in handed} | folders
    if place in inside or not inside.isdisjoint(place.parents):
        raise ValueError(
            f"out must be apart from the submissions, got {one_line(out)}: what is written there "
            "would be taken for one"
        )


def regrade(assignment: Assignment, out: str | PathLike[str]) -> ClassResult:
    """Mark anew what is in a folder of results; see `Assignment.regrade`."""
    folder = ResultFolder(as_path(out, "out"))
    plan = plan_of(assignment)
    units = {name: unit for unit in plan.work.units for name in unit.names}
    students = folder.students()
    if not students:
        raise FileNotFoundError(2, "there are no results to be marked anew", str(out))
    results = [_again(plan, units, folder, student) for student in students]
    for result in results:  # all of them can be
        folder.write_whole(result)
    return ClassResult(name=assignment.name, results=tuple(results))


def _again(
    plan: Plan, units: dict[str, Unit], folder: ResultFolder, student: str
) -> SubmissionResult:
    old = folder.read(student)
    if old is None:
        raise ValueError(f"{one_line(folder.of(student))}: its result cannot be read")
    tests = tuple(_test(units, test, student) for test in old.tests)
    return old.replace(title=plan.assignment.title, tests=tests, assignment_digest=plan.digest)


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
