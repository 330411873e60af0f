"""The work of ``robsim grade`` on a class, and its output."""

from __future__ import annotations

import json
import shlex
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from robsim.base.text import one_line
from robsim.cli import errors
from robsim.cli.outcome import show_panel
from robsim.cli.results import check_file, check_folder
from robsim.teach.assignments import (
    Assignment,
    ClassResult,
    SubmissionResult,
    grade_class,
    grade_submission,
    play_run,
)
from robsim.teach.reports import for_student, student_text
from robsim.teach.reports.similarity import read_comparison
from robsim.teach.reports.words import alike, person
from robsim.teach.reports.writing import CLASS, PAGE, SIMILAR, folder_name
from robsim.teach.results import number

_MOST_NAMED = 4


def graded_alone(
    assignment: Assignment, submission: Path, out: Path, gradescope: Path | None, **options: Any
) -> ClassResult:
    """Grade a file, or a folder of any layout, as a single submission."""
    if gradescope is not None:
        check_file(gradescope)
    with _kept_in(out):
        one = grade_submission(assignment, submission, out, gradescope=gradescope, **options)
    return ClassResult(name=assignment.name, results=(one,))


def graded_class(
    assignment: Assignment, submissions: Path, out: Path, *, is_quiet: bool, **options: Any
) -> ClassResult:
    """Grade a class, and print a line for each finished submission."""
    tell = None if is_quiet else _tell
    with _kept_in(out):
        return grade_class(assignment, submissions, out, on_result=tell, **options)


@contextmanager
def _kept_in(out: Path) -> Iterator[None]:
    check_folder(out)
    try:
        yield
    except KeyboardInterrupt:
        errors.print_note(f"the finished results are in {out}; rerun the same command to continue")
        raise


def _tell(result: SubmissionResult, changed: str) -> None:
    errors.say(_line(result, changed))
    sys.stdout.flush()


def _line(result: SubmissionResult, changed: str) -> str:
    if not result.submission_digest:
        return f"{person(result.student)}  {_points(result)}  {result.tests[0].sentence}"
    # Results without a digest were not requested, or could not be graded.
    lost = [test.name for test in result.tests if test.digest and test.status != "passed"]
    names = ", ".join(lost[:_MOST_NAMED]) + (", ..." if len(lost) > _MOST_NAMED else "")
    what = f"  loses points in {names}" if lost else ""
    why = f"  (regraded: {changed})" if changed else ""
    return f"{person(result.student)}  {_points(result)}{what}{why}"


def _points(result: SubmissionResult) -> str:
    """Return the points of all tests with a result or a failure, and their maximum."""
    most = sum(test.most for test in result.tests if test.digest or test.by_hand)
    return f"{number(result.points)} of {number(most)}"


def show(
    assignment: Assignment, result: ClassResult, out: Path, *, public: bool, as_json: bool
) -> None:
    """Print the result: details of a single submission, or a table of a class."""
    if as_json:
        errors.show(json.dumps([json.loads(one.to_json()) for one in result.results], indent=2))
        return
    if result.changes is not None:
        errors.show(_changes(result.changes))
    if len(result.results) > 1:
        errors.show(f"\n{result}\n")
        if line := next((one.isolation for one in result.results if one.isolation), ""):
            errors.say(line)
        if (found := read_comparison(out / SIMILAR)) and found.alike:
            names = "; ".join(map(alike, found.alike))
            errors.say(f"similar programs, at the end of the page {CLASS}: {names}")
        errors.say(f"pages and tables: {out / CLASS}, with a folder for each student next to them")
        return
    (one,) = result.results
    errors.show(student_text(for_student(one) if public else one))
    if public and assignment.points is not None and assignment.points > one.most:
        errors.say(
            f"public tests only: {number(one.most)} of {number(assignment.points)} points shown"
        )
    errors.say(f"with pictures: {out / folder_name(one.student) / PAGE}")


def _changes(changes: Mapping[str, tuple[float, float]]) -> str:
    lines = [f"{name}: {number(old)} -> {number(new)}" for name, (old, new) in changes.items()]
    return "\n".join(["points have changed:", *lines] if lines else ["no points have changed"])


def played(
    assignment: Assignment,
    submission: Path,
    test: str,
    run: int | None,
    out: Path,
    student: str | None,
    *,
    is_shown: bool,
) -> None:
    """Repeat a run, print its scores, write its trace and picture, and show it in the panel."""
    check_folder(out)
    again = play_run(assignment, submission, test, run, out, student=student)
    trace, picture = again.files
    errors.show(again)
    if again.output:
        errors.show(f"it printed:\n{again.output}")
    errors.say(f"picture: {one_line(picture)}")
    if not is_shown:
        shown = f"robsim gui {shlex.quote(one_line(trace))}"
        errors.say(f"in the panel: the same command with --gui, or {shown}")
        return
    from robsim.gui import panel

    if again.test.task.scenario.noise is not None:
        errors.print_note(
            "the panel draws the pictures again, with other noise than in the submission's run; "
            "measurements, estimates and paths come from that run"
        )
    with panel(again.trace, goals=again.test.task.goals) as opened:
        show_panel(opened)
