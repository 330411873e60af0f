"""The command ``robsim grade``: submissions graded by an assignment."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from inspect import signature
from pathlib import Path
from typing import Any

import typer

from robsim.base.text import listed
from robsim.cli import errors
from robsim.cli.shared import AllJobs, Json, Out, engine_of

NO_WORKER, NOT_STRICT = 2, 3  # exit statuses


def print_isolation(isolation: str, *, as_json: bool) -> None:
    """Print what holds; exit with the status that says whether the level can be had."""
    from robsim.base.checks import check_choice
    from robsim.teach.errors import GraderError
    from robsim.teach.isolation.check import check_isolation
    from robsim.teach.isolation.limits import LEVELS
    from robsim.teach.isolation.start import IsolationError

    missing: object = None
    level = check_choice("isolation", isolation, LEVELS)
    try:
        try:
            report = check_isolation(isolation=level)
        except IsolationError as error:
            missing, report = error, check_isolation(isolation="auto")
    except GraderError as error:
        errors.print_error(error)
        raise typer.Exit(NO_WORKER) from None
    errors.show(report.to_json() if as_json else report)
    if missing is not None:
        errors.print_error(missing)
    if missing is not None or (isolation == "strict" and not report.strict):
        raise typer.Exit(NOT_STRICT)


_MISSING, _BROKEN = 1, 2  # exit statuses
_OF_CLASS = "columns pseudonyms groups"
#: Options by the name of another one, which would ignore them.
_APART = {
    "play": f"regrade only public gradescope teacher_pages feedback {_OF_CLASS}",
    "regrade": "only public student gradescope groups",
    **dict.fromkeys(("student", "public", "gradescope"), _OF_CLASS),
}


def grade(
    assignment: Path | None = None,
    submissions: Path | None = None,
    public: bool = False,
    only: list[str] | None = None,
    groups: Path | None = None,
    jobs: AllJobs = None,
    isolation: str | None = None,
    out: Out = Path("graded"),
    student: str | None = None,
    columns: str = "robsim",
    pseudonyms: bool = False,
    teacher_pages: bool = False,
    feedback: Path | None = None,
    gradescope: Path | None = None,
    regrade: bool = False,
    play: str | None = None,
    gui: bool = False,
    run: int | None = None,
    check_isolation: bool = False,
    as_json: Json = False,
) -> None:
    """Grade submissions by an assignment.

    Each runs in its own process, which sees the frames and none of the truth. Results are written
    after each test: the same command continues an ended one, and repeats only what changed. In the
    folder of each student are index.html and result.txt for them; beside these class.html,
    class.csv, and by_hand.csv, which is yours: late days, other points, comments.

    With --public, for students: the public tests of their work.

    The exit status is 0 if all have all points, 1 if points are missing, 3 if submissions cannot be
    shut in. It is 2 if the assignment is incomplete or broken, or if something could not be graded.

    robsim grade --check-isolation reports how submissions are shut in on this machine. Tests
    without an assignment: python -m pytest --robsim-submission=PATH TESTS.py.

    ASSIGNMENT: The folder of the assignment.
    SUBMISSIONS: A folder with one for each student: a folder, a Python file, a notebook or a zip;
        or the zip of these as Moodle, Canvas or Blackboard packs it; or a single one.
    --public: Only the tests that students have, too.
    --only NAME: Run only this test, or grade only this student; may be given twice. Results of
        others are kept.
    --groups FILE: A table with the columns group and student: each member of a group gets its
        marks. Default: groups.csv beside the submissions, if there is one.
    --isolation LEVEL: auto = all that works here. strict = the same, and files, processes, network
        and memory must be closed. process = limits alone. none = a process, and nothing else.
        Default: as the assignment says.
    --student NAME: Whose it is, for a single submission. Default: the name of its file or folder.
    --columns PLATFORM: Columns of class.csv: robsim, moodle, canvas or blackboard.
    --pseudonyms: No names of students in class.html and class.csv.
    --teacher-pages: Write teacher.html for each student, too, with hidden tests.
    --feedback ZIP: Write the pages of all students into a zip, as Moodle takes feedback files.
    --gradescope FILE: Write the result of a single submission as Gradescope reads it, results.json.
        An autograder: robsim assignment pack.
    --regrade: Run nothing: mark the results in --out again, after limits, points or by_hand.csv
        changed, and print whose points are others now.
    --play TEST: For an appeal: do a run of this test again, which is the same, and write its trace
        and picture.
    --gui: Also open the run to --play in the panel, in the browser, with the goal of the task; it
        ends when you close its page, or with Ctrl-C.
    --run N: Which run to --play. Default: the worst one in the results.
    --check-isolation: Let a process try to get out, report the result, and grade nothing.

    Example: robsim grade hw3 submissions
    """
    if check_isolation:
        print_isolation(isolation or "auto", as_json=as_json)
        return
    with _reported():
        from robsim.base.checks import check_choice
        from robsim.cli import marks
        from robsim.cli.results import check_file
        from robsim.teach.assignments import load_assignment, pack_feedback, regrade_class
        from robsim.teach.isolation.limits import LEVELS

        _check_together(locals())
        if assignment is None:
            raise ValueError(
                "which assignment? robsim grade ASSIGNMENT SUBMISSIONS; --check-isolation looks "
                "at this machine"
            )
        level = None if isolation is None else check_choice("isolation", isolation, LEVELS)
        given = load_assignment(assignment, isolation=level)
        if play is None and (gui or run is not None):
            raise ValueError("--gui and --run are for the run to --play: give that, too")
        executor = engine_of(jobs)
        if feedback is not None:
            check_file(feedback)
        told: dict[str, Any] = {"teacher_pages": teacher_pages}
        tables: dict[str, Any] = told | {"columns": columns, "pseudonyms": pseudonyms}
        if regrade:
            result = regrade_class(given, out, **tables)
        elif submissions is None:
            raise ValueError("what is to be graded? robsim grade ASSIGNMENT SUBMISSIONS")
        elif play is not None:
            marks.played(given, submissions, play, run, out, student, is_shown=gui)
            return
        elif public or student is not None or gradescope is not None:
            told |= {"student": student, "public": public, "only": only}
            result = marks.graded_alone(given, submissions, out, gradescope, **told)
        else:
            tables |= {"executor": executor, "only": only, "groups": groups}
            result = marks.graded_class(given, submissions, out, is_quiet=as_json, **tables)
        if feedback is not None:
            pack_feedback(result, out, feedback)
        marks.show(given, result, out, public=public, as_json=as_json)
    if not result.is_full or result.has_errors:
        raise typer.Exit(_BROKEN if result.has_errors else _MISSING)


def _check_together(values: Mapping[str, Any]) -> None:
    """Raise ValueError for an option that another one would leave without effect."""
    options = signature(grade).parameters.items()
    given = [name for name, one in options if values[name] != one.default]
    for name in given:
        if useless := [f"--{one}" for one in _APART.get(name, "").split() if one in given]:
            said = f"--{name} would ignore {listed(useless)}: leave one out"
            raise ValueError(said.replace("_", "-"))


@contextmanager
def _reported() -> Iterator[None]:
    """Print an error as a sentence, and exit with the status that says whose it is."""
    from robsim.teach.errors import GradingError, SubmissionError
    from robsim.teach.isolation.start import IsolationError

    try:
        yield
    except (IsolationError, SubmissionError) as error:  # the latter of a single run
        errors.print_error(error)
        raise typer.Exit(_MISSING if isinstance(error, SubmissionError) else NOT_STRICT) from None
    except GradingError as error:
        errors.print_error(f"{error.whose}: {error}")
        raise typer.Exit(_BROKEN) from None
