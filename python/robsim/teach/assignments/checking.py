"""`check_assignment`: whether an assignment is fit to grade by."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from os import PathLike
from pathlib import Path

from robsim.base.check_report import CheckReport, Problem
from robsim.base.checks import check_bool
from robsim.base.report import Column, Row, Table
from robsim.base.text import listed
from robsim.campaigns.engines.engine import Engine, engine_value
from robsim.campaigns.engines.executors import DaskClient
from robsim.simulation.runner import progress_bar
from robsim.teach.assignments.assignment import Assignment, TaskTest
from robsim.teach.assignments.assignment_file import FILE, load_assignment
from robsim.teach.assignments.classes.plan import Plan, plan_of
from robsim.teach.assignments.limits_file import RecordedTest, read_limits
from robsim.teach.assignments.packing.public_part import public_part
from robsim.teach.assignments.rehearsal import FULL, LESS, NOTHING, Part, cast_of, graded
from robsim.teach.assignments.sheet import SHEET, compare_sheet, told_task
from robsim.teach.errors import AssignmentError
from robsim.teach.results import ERROR, SubmissionResult, TestResult, number
from robsim.teach.tasks.marks.calibration import MOST_OF_WRONG, TaskCalibration, changes

#: A submission with an unexpected result is graded twice more with other seeds: two of three count.
_TRIES = 3
#: A smaller share of the points counts as no points: a wrong solution gets some by chance.
_LITTLE = 0.1
_ALL = 1 - 1e-9
PROVISIONAL = "provisional"


def check_assignment(
    folder: str | PathLike[str],
    *,
    executor: int | str | Executor | DaskClient | None = None,
    progress: bool = True,
) -> CheckReport:
    """Check whether an assignment is ready for grading: read it, and grade known submissions.

    The limits must belong to the tasks and solutions, the sheet must name each slot, and the
    students' files must not reveal hidden parts. Then a class is graded. Right solutions, one of
    them as a notebook, must get full points, and wrong solutions fewer points. Empty and hostile
    submissions must get no points: hostile submissions exit, hang, patch the scoring, or search the
    memory for the truth. Grading must continue after each submission.

    Parameters
    ----------
    folder : path
        The folder of the assignment.
    executor, progress
        As for `robsim.campaign`.

    Returns
    -------
    CheckReport
        The problems, and a table of the checks.

    Raises
    ------
    AssignmentError
        If the assignment is unreadable or incomplete.
    TypeError, ValueError
        If an argument is wrong.

    Notes
    -----
    A right solution sometimes loses points (at the calibrated rate), and a wrong solution sometimes
    passes. So a submission with an unexpected result is graded two more times, with other seeds.
    The report has a problem if two of three results are unexpected.

    Examples
    --------
    A check takes minutes, but refuses an incomplete assignment at once:

    >>> assignment = robsim.teach.new_assignment("park", "hw1", seed=1)
    >>> (assignment.folder / "own_tests.py").unlink()
    >>> robsim.teach.check_assignment("hw1")
    Traceback (most recent call last):
        ...
    robsim.teach.AssignmentError: assignment.toml, line 66: [files.1] file own_tests.py is missing
    """
    engine = engine_value(executor)
    assignment = load_assignment(folder)
    check_bool("progress", progress)
    findings = [*_still(assignment)]
    plan = plan_of(assignment)
    with tempfile.TemporaryDirectory(prefix="robsim-check-") as scratch:
        findings += _rehearsed(plan, Path(scratch), engine, progress)
    rows = [
        Row(one.what, [one.expected, one.got, "FAILED" if one.wrong else one.note or "passed"])
        for one in findings
    ]
    columns = [Column("expected", "should be"), Column("got", "is"), Column("verdict", "")]
    return CheckReport(
        name=assignment.name,
        problems=tuple(Problem(kind=f.what, sentence=f.wrong) for f in findings if f.wrong),
        remarks=(
            *dict.fromkeys(test.provisional for test in assignment.tests if test.provisional),
            *(f"{f.what}: {f.got}, {f.note}" for f in findings if f.note not in ("", PROVISIONAL)),
        ),
        tables=(Table(key="checks", columns=columns, rows=rows, row_title="check"),),
    )


@dataclass(frozen=True)
class Finding:
    """The result of one check."""

    what: str
    expected: str
    got: str
    wrong: str = ""  # the fault and its remedy; "" = no fault
    note: str = ""  # for the teacher; no fault


def _still(assignment: Assignment) -> Iterator[Finding]:
    """Yield the checks that run no code."""
    is_needed = any(not test.public for test in assignment.all_tests)
    key = assignment.key
    got = "missing" if key is None else "public" if key.is_public else "secret"
    wrong = "" if got == "secret" or not is_needed else "hidden tests need a key: Key.new().save"
    yield Finding("key", "secret", got, wrong)
    recorded = read_limits(assignment.folder)
    for test in assignment.tests:
        yield _limits(test, recorded.get(test.name, RecordedTest()).calibration)
        told, own = told_task(assignment), test.task
        if told.name == own.name and (changed := changes(own.parameters, told.parameters)):
            yield Finding(f"numbers of {test.name}", "as in the sheet", "others", note=changed)
    yield _sheet(assignment)
    yield _public(assignment)


def _limits(test: TaskTest, made: TaskCalibration | None) -> Finding:
    what, expected = f"limits of {test.name}", "calibrated for it"
    if made is None:
        wrong = f"{what} are not calibrated: run robsim assignment calibrate"
        return Finding(what, expected, "written by hand", wrong)
    if test.stale:
        return Finding(what, expected, "of others", f"{what}: {test.stale}")
    got = f"right ones fail in {100 * made.false_fail:g} % at most"
    return Finding(what, expected, got, note=PROVISIONAL if test.provisional else "")


def _sheet(assignment: Assignment) -> Finding:
    file = assignment.folder / SHEET
    text = file.read_text("utf-8", "replace") if file.is_file() else ""
    expected = "names slots and numbers"
    if missing := listed(slot for slot in assignment.slots if slot not in text):
        wrong = f"{SHEET} does not mention {missing}: describe each slot"
        return Finding(SHEET, expected, f"not {missing}", wrong)
    wrong, names = compare_sheet(assignment)
    if wrong:
        return Finding(SHEET, expected, "other numbers", f"{SHEET} differs from {FILE}: {wrong}")
    note = f"no row for {listed(f'`{name}`' for name in names)}" if names else ""
    return Finding(SHEET, expected, "names them", note=note)


def _public(assignment: Assignment) -> Finding:
    try:
        got, wrong = f"{len(public_part(assignment))} files", ""
    except AssignmentError as error:
        got, wrong = "refused", str(error)
    return Finding("for students", "nothing hidden", got, wrong)


def _rehearsed(plan: Plan, scratch: Path, executor: Engine, progress: bool) -> Iterator[Finding]:
    parts = cast_of(plan.assignment)
    bar = progress_bar(total=len(parts), unit="submission") if progress else None
    tell = (lambda: None) if bar is None else bar.update
    tries: dict[str, list[SubmissionResult]] = {part.name: [] for part in parts}
    # Solutions may use masked names, but one of the right ones must not.
    free = plan_of(replace(plan.assignment, masked=(), defaults=True))
    for again in range(_TRIES):
        asked = [part for part in parts if not again or not _is_expected(part, tries[part.name][0])]
        for by, name in ((plan, "ruled"), (free, "free")):
            some = [part for part in asked if part.is_free == (by is free)]
            place = scratch / f"{again}/{name}"
            results = graded(by, some, place, executor=executor, tell=tell, again=again)
            for part in some:
                tries[part.name].append(results[part.name])
    if bar is not None:
        bar.close()
    for part in parts:
        yield _finding(part, tries[part.name])


def _counted(part: Part, result: SubmissionResult) -> list[TestResult]:
    """Return the results that count; right ones must pass the teacher's own tests, too.

    The assignment's rules hold for these tests, so solutions without the rules cannot pass.
    """
    counts_all = part.expected == FULL and not part.is_free
    return [test for test in result.tests if counts_all or test.name in part.tests]


def _points(part: Part, result: SubmissionResult) -> tuple[float, float]:
    tests = _counted(part, result)
    return sum(test.points for test in tests), sum(test.most for test in tests)


def _is_expected(part: Part, result: SubmissionResult) -> bool:
    if any(test.status == ERROR for test in result.tests):
        return False
    points, most = _points(part, result)
    if part.expected == FULL:
        return points >= _ALL * most
    if part.expected == LESS:
        return points < _ALL * most
    return points <= _LITTLE * most


_REMEDIES = {
    FULL: "is right and should get all points: check the solution, the limits of this task, and "
    "the requirements of your own tests",
    LESS: "is wrong and should get fewer points: use more runs or steps",
    NOTHING: "should get no points",
}


def _finding(part: Part, results: list[SubmissionResult]) -> Finding:
    bad = [one for one in results if not _is_expected(part, one)]
    points, most = _points(part, (bad or results)[0])
    got = f"{number(points)} of {number(most)}"
    if len(results) > 1:
        got += f", in {len(bad)} of {len(results)} gradings"
    wrong = ""
    if 2 * len(bad) > len(results):
        wrong = f"{part.name} {_REMEDIES[part.expected]}; it got {got}{_lost(part, bad[0])}"
    is_near = part.expected == LESS and points > MOST_OF_WRONG * most
    return Finding(part.name, part.expected, got, wrong, "more than half" if is_near else "")


def _lost(part: Part, result: SubmissionResult) -> str:
    if part.expected != FULL:
        return ""
    lost = [test for test in _counted(part, result) if test.points < _ALL * test.most]
    return f"; {lost[0].name}: {lost[0].sentence}" if lost else ""
