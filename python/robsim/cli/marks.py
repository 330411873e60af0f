"""The work of ``robsim grade`` on a class, and its output."""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from robsim.base.checks import check_choice
from robsim.base.files import write_whole
from robsim.base.text import one_line
from robsim.cli import errors
from robsim.cli.outcome import show_panel
from robsim.cli.results import check_file, check_folder
from robsim.teach.assignments.classes.class_run import grade_all, regrade
from robsim.teach.assignments.classes.plan import plan_of
from robsim.teach.assignments.classes.store import ClassTables, ResultFolder, write_class_files
from robsim.teach.assignments.classes.submissions import (
    Handed,
    check_is_one,
    one_submission,
    submissions_in,
)
from robsim.teach.assignments.grading.references import key_for
from robsim.teach.assignments.results import PASSED, SubmissionResult, number
from robsim.teach.reports.gradescope import write_gradescope
from robsim.teach.reports.student_text import for_student, student_text
from robsim.teach.reports.tables import COLUMNS
from robsim.teach.reports.writing import CLASS, PAGE

if TYPE_CHECKING:
    from robsim.teach.assignments.assignment import Assignment
    from robsim.teach.assignments.class_result import ClassResult
_MOST_NAMED = 4


@dataclass(frozen=True, kw_only=True)
class Chosen:
    """What the options of the command say."""

    submissions: Path
    out: Path
    public: bool
    only: Sequence[str] | None
    jobs: int
    student: str | None
    gradescope: Path | None
    columns: str
    pseudonyms: bool
    is_quiet: bool

    @property
    def is_single(self) -> bool:
        """Whether it is a single submission, whatever the folder looks like."""
        return self.public or self.student is not None or self.gradescope is not None


def graded(assignment: Assignment, chosen: Chosen) -> ClassResult:
    """Grade, and print a line for each submission as it is done."""
    if chosen.jobs < 1:
        raise ValueError(f"--jobs must be at least 1, got {chosen.jobs}")
    check_choice("columns", chosen.columns, COLUMNS)
    if chosen.pseudonyms:
        key_for(assignment, public=False)
    handed = _handed(assignment, chosen)
    check_folder(chosen.out)
    if chosen.gradescope is not None:
        check_file(chosen.gradescope)
    plan = plan_of(assignment, only=chosen.only, public=chosen.public)
    folder = ResultFolder(chosen.out)
    is_class = len(handed) > 1

    def tell(result: SubmissionResult, changed: str) -> None:
        if is_class and not chosen.is_quiet:
            errors.say(_line(result, changed))
            sys.stdout.flush()

    def keep(result: SubmissionResult) -> None:
        if chosen.gradescope is not None:
            write_gradescope(chosen.gradescope, result, pictures=folder.pictures(result))

    try:
        result = grade_all(
            plan,
            handed,
            chosen.out,
            executor=chosen.jobs if chosen.jobs > 1 else None,
            tell=tell,
            keep=keep,
        )
    except KeyboardInterrupt:
        errors.print_note(
            f"what is done is in {chosen.out}: the same command goes on with the rest"
        )
        raise
    if is_class:
        tables = ClassTables(columns=chosen.columns, pseudonyms=chosen.pseudonyms)
        write_class_files(assignment, handed, folder, result.results, tables)
    return result


def _handed(assignment: Assignment, chosen: Chosen) -> list[Handed]:
    if not chosen.is_single:
        return submissions_in(chosen.submissions, assignment)
    one = one_submission(chosen.submissions)
    if chosen.student is not None:
        return [Handed(chosen.student, one.path)]
    if chosen.gradescope is not None:
        check_is_one(one, assignment)
    return [one]


def marked_anew(
    assignment: Assignment, out: Path, columns: str, *, pseudonyms: bool
) -> ClassResult:
    """Mark results anew; of programs that resemble each other nothing is said."""
    result = regrade(assignment, out)
    if len(result.results) > 1:
        tables = ClassTables(columns=columns, pseudonyms=pseudonyms)
        write_class_files(assignment, None, ResultFolder(out), result.results, tables)
    return result


def _line(result: SubmissionResult, changed: str) -> str:
    if not result.submission_digest:
        return f"{result.student}  {_points(result)}  {result.tests[0].sentence}"
    # Those without a digest were not asked for, or could not be graded.
    lost = [test.name for test in result.tests if test.digest and test.status != PASSED]
    names = ", ".join(lost[:_MOST_NAMED]) + (", ..." if len(lost) > _MOST_NAMED else "")
    what = f"  not all of {names}" if lost else ""
    why = f"  (graded anew: {changed})" if changed else ""
    return f"{result.student}  {_points(result)}{what}{why}"


def _points(result: SubmissionResult) -> str:
    """Return the points of the tests that were run or could not be, of how many."""
    most = sum(test.most for test in result.tests if test.digest)
    return f"{number(result.points)} of {number(most)}"


def show(
    assignment: Assignment, result: ClassResult, out: Path, *, public: bool, as_json: bool
) -> None:
    """Print the result: that of a single submission whole, of a class as a table."""
    if as_json:
        errors.show(json.dumps([json.loads(one.to_json()) for one in result.results], indent=2))
        return
    if len(result.results) > 1:
        errors.show(f"\n{result}\n")
        if line := next((one.isolation for one in result.results if one.isolation), ""):
            errors.say(line)
        errors.say(f"pages and tables: {out / CLASS}, and a folder for each student beside it")
        return
    (one,) = result.results
    errors.show(student_text(for_student(one) if public else one))
    if public and assignment.points is not None and assignment.points > one.most:
        errors.say(
            f"public tests only: {number(one.most)} of {number(assignment.points)} points shown"
        )
    errors.say(f"with pictures: {out / one.student / PAGE}")


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
    """Do a run again, print its scores, write its trace and picture, and show it in the panel."""
    name = one_submission(submission).student if student is None else student
    folder = ResultFolder(out)
    if run is None:
        old = folder.read(name)
        worst = {} if old is None else {one.name: one.worst for one in old.tests}
        run = worst.get(test) or 0
        if old is None:
            errors.print_note(
                f"run {run}, as {out} has no results of {name} that tell the worst one; another "
                "one: --run N"
            )
    again = assignment.play(submission, test, run, student=student)
    place = folder.of(name)
    check_folder(place)
    place.mkdir(parents=True, exist_ok=True)
    trace, picture = (place / f"{test}-run{run}{suffix}" for suffix in (".npz", ".png"))
    again.trace.save(trace)
    write_whole(picture, again.picture())
    errors.show(again)
    if again.output:
        errors.show(f"it printed:\n{again.output}")
    errors.say(f"picture: {one_line(picture)}")
    if not is_shown:
        errors.say(f"in the panel: the same command with --gui, or robsim gui {one_line(trace)}")
        return
    from robsim.gui import panel

    if again.test.task.scenario.noise is not None:
        errors.print_note(
            "the panel draws the pictures again, with other noise than the submission has seen; "
            "measurements, estimates and paths are those of the run"
        )
    with panel(again.trace, goals=again.test.task.goals) as opened:
        show_panel(opened)
