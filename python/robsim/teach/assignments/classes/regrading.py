"""Points anew from numbers that are there, after limits or points were changed."""

from __future__ import annotations

from os import PathLike

from robsim.base.files import as_path
from robsim.base.text import one_line, quoted
from robsim.teach.assignments.assignment import Assignment
from robsim.teach.assignments.class_result import ClassResult
from robsim.teach.assignments.classes.plan import Plan, plan_of
from robsim.teach.assignments.classes.progress import again
from robsim.teach.assignments.classes.store import ResultFolder
from robsim.teach.assignments.grading.work import Unit
from robsim.teach.assignments.results import ERROR, SubmissionResult, TestResult


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
