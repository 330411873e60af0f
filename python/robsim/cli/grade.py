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
    """Print the isolation of this machine; exit with a status for the requested level."""
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
    """Grade the submissions of an assignment.

    Each submission runs in its own process, which receives frames but never the truth. Results are
    written after each test. The same command continues an interrupted grading, and repeats only
    changed tests. The folder of each student has index.html and result.txt. The folder above has
    class.html, class.csv, and by_hand.csv for your entries: late days, other points, comments.

    With --public, students can run the public tests on their own work.

    The exit status is 0 if all submissions have full points, 1 if points are missing, 3 if
    submissions cannot be isolated. It is 2 if the assignment is incomplete or broken, or if
    something could not be graded.

    robsim grade --check-isolation reports the isolation on this machine. To run your own tests
    without an assignment, use python -m pytest --robsim-submission=PATH TESTS.py.

    ASSIGNMENT: The folder of the assignment.
    SUBMISSIONS: A folder with one submission per student, a zip of submissions from Moodle, Canvas
        or Blackboard, or a single submission. A submission is a folder, a Python file, a notebook
        or a zip.
    --public: Run only the public tests, which students also have.
    --only NAME: Run only this test, or grade only this student. Other results are kept. Can be
        repeated.
    --groups FILE: A table with the columns group and student: each student gets the marks of the
        group. Default: groups.csv next to the submissions, if it exists.
    --isolation LEVEL: auto uses every isolation that works here. strict also requires isolation of
        files, processes, network and memory. process uses only limits. none uses only a separate
        process. Default: the level of the assignment.
    --student NAME: The author of a single submission. Default: the name of its file or folder.
    --columns PLATFORM: Columns of class.csv: robsim, moodle, canvas or blackboard.
    --pseudonyms: Write pseudonyms instead of names to class.html and class.csv.
    --teacher-pages: Also write teacher.html for each student, with hidden tests.
    --feedback ZIP: Write the pages of all students into a zip, in Moodle's format for feedback
        files.
    --gradescope FILE: Write the result of a single submission for Gradescope, results.json. For an
        autograder, use robsim assignment pack.
    --regrade: Run no tests, but mark the results in --out again after a change of limits, points or
        by_hand.csv. Print all students with changed points.
    --play TEST: For an appeal: repeat a run of this test exactly, and write its trace and picture.
    --gui: With --play: also open the run in the panel in the browser, with the goal of the task.
        The panel ends when you close its page, or with Ctrl-C.
    --run N: With --play: number of the run. Default: the worst run in the results.
    --check-isolation: Test the isolation on this machine, report the result, and grade nothing.

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
                "the assignment is missing: use robsim grade ASSIGNMENT SUBMISSIONS, or use "
                "--check-isolation to test this machine"
            )
        level = None if isolation is None else check_choice("isolation", isolation, LEVELS)
        given = load_assignment(assignment, isolation=level)
        if play is None and (gui or run is not None):
            raise ValueError("--gui and --run can only be used with --play: add --play")
        executor = engine_of(jobs)
        if feedback is not None:
            check_file(feedback)
        told: dict[str, Any] = {"teacher_pages": teacher_pages}
        tables: dict[str, Any] = told | {"columns": columns, "pseudonyms": pseudonyms}
        if regrade:
            result = regrade_class(given, out, **tables)
        elif submissions is None:
            raise ValueError("missing submissions: robsim grade ASSIGNMENT SUBMISSIONS")
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
    """Raise ValueError for an option that has no effect with another one."""
    options = signature(grade).parameters.items()
    given = [name for name, one in options if values[name] != one.default]
    for name in given:
        if useless := [f"--{one}" for one in _APART.get(name, "").split() if one in given]:
            said = f"--{name} would ignore {listed(useless)}: leave one out"
            raise ValueError(said.replace("_", "-"))


@contextmanager
def _reported() -> Iterator[None]:
    """Print an error as a sentence, and exit with a status that depends on its cause."""
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
