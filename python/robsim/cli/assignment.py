"""The commands ``robsim assignment``: new, calibrate, check and pack."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

import typer

from robsim.cli import errors
from robsim.cli.command import command, command_group
from robsim.cli.shared import AllJobs, Json, engine_of

Folder = Annotated[Path, "FOLDER: The assignment, from robsim assignment new."]


@contextmanager
def report_errors() -> Iterator[None]:
    """Print an error, also of an assignment, as a sentence, and exit with 2."""
    from robsim.teach.errors import GradingError

    try:
        yield
    except GradingError as error:
        errors.print_error(error)
        raise typer.Exit(2) from None


def calibrate(
    folder: Folder,
    false_fail: float = 0.01,
    confidence: float = 0.95,
    provisional: bool = False,
    jobs: AllJobs = None,
) -> None:
    """Find the score limits for points, and write limits.json.

    The command runs the correct solutions in solutions/ until the limits are known. An equally good
    solution hardly ever misses these limits, for any distribution of the scores. Then the command
    runs the wrong solutions, and prints the number of tests in which each gets less than full
    points. Calibration takes some minutes. After Ctrl-C, the same command continues. Afterwards,
    robsim grade --regrade applies the new limits to results with provisional limits.

    --false-fail SHARE: Largest probability that a correct solution gets less than full points in a
        test. A ten times smaller value takes ten times as long.
    --confidence SHARE: Share of calibrations whose limits respect this probability.
    --provisional: Find provisional limits in less time, from fewer tests.

    Example: robsim assignment calibrate hw1
    """
    with report_errors():
        given = {"false_fail": false_fail, "confidence": confidence, "provisional": provisional}
        calibrate_and_print(folder, jobs=jobs, **given)


def calibrate_and_print(folder: Path, *, jobs: int | None, **options: Any) -> None:
    """Calibrate, and print the expected duration before and the results afterwards."""
    from robsim.teach.assignments import calibrate_assignment

    try:
        found = calibrate_assignment(
            folder, executor=engine_of(jobs), on_begin=_tell_how_long, **options
        )
    except KeyboardInterrupt:
        more = " --provisional" if options.get("provisional") else ""
        errors.print_note(f"to continue: robsim assignment calibrate {folder}{more}")
        raise
    for calibration in {id(one): one for one in found.values()}.values():
        names = [name for name, other in found.items() if other is calibration]
        errors.show(f"{', '.join(names)}: {calibration}")
        for one in calibration.missed:
            errors.print_note(
                f"warning: wrong/{one.name} gets full points in {100 * (1 - one.rate):.0f} % of "
                "the tests: give the task more runs or steps, or remove the solution"
            )
    errors.say(f"written to {folder / 'limits.json'}")


def _tell_how_long(seconds: float, goes_on: bool) -> None:
    begin = "finished runs are kept; all runs take" if goes_on else "calibrating takes"
    duration = f"{max(seconds, 1):.0f} s" if seconds < 90 else f"{seconds / 60:.0f} minutes"
    errors.print_note(f"{begin} about {duration}; Ctrl-C keeps finished runs")
    sys.stderr.flush()


def new(
    template: str,
    folder: Path,
    name: str | None = None,
    no_calibrate: bool = False,
    seed: int | None = None,
    jobs: AllJobs = None,
) -> None:
    """Make the folder of a new assignment.

    TEMPLATE is park, follow, identify, measure, estimate, or a notebook such as 02_park.

    For a task, the folder gets its own key and numbers, a sheet, solutions and provisional limits.
    At first, the folder has the limits of the shipped task; after some minutes, it has its own
    limits. All commands work with provisional limits, and report them. robsim assignment calibrate
    finds exact limits. README.md describes the files.

    For a notebook, the folder gets a key, a sheet and the notebook. Each exercise has a public and
    a hidden test. A notebook needs no calibration.

    TEMPLATE: The task, or the notebook, for students.
    FOLDER: The folder to create.
    --name TEXT: Name of the assignment. Default: the name of the folder.
    --no-calibrate: Keep the limits of the task shipped with robsim.
    --seed N: Seed of the drawn numbers, but not of the key. Default: a new seed each time.

    Example: robsim assignment new park hw1
    """
    from robsim.teach.assignments import new_assignment

    with report_errors():
        made = new_assignment(template, folder, name=name, seed=seed)
        if not made.tests:
            errors.say(f"written to {folder}: {made.title}, {', '.join(made.functions)}")
            errors.say(f"next: robsim assignment check {folder}")
            return
        test = made.tests[0]
        drawn = ", ".join(f"{key} {value}" for key, value in test.task.parameters.items())
        errors.say(f"written to {folder}: {made.title}, {drawn}")
        errors.say(
            f"please read: sheet.md, assignment.toml, start/, solutions/; {test.provisional}"
        )
        sys.stdout.flush()
        if not no_calibrate:
            calibrate_and_print(folder, jobs=jobs, provisional=True)
    errors.say(f"next: robsim assignment check {folder}; robsim assignment calibrate {folder}")


def check(folder: Folder, jobs: AllJobs = None, as_json: Json = False) -> None:
    """Check an assignment before you rely on it.

    The command grades a class of all known kinds of submissions. Correct solutions, one also as a
    notebook, must get all points, and wrong solutions fewer points. A submission must get no points
    if it is empty, ends its process, hangs, patches the scoring, or looks for the truth. The key
    must be secret, and the limits must belong to this task. The sheet must name the callbacks to
    write. The students' files must contain no hidden data.

    The check takes a minute or two. The exit status is 0 if all checks pass, 1 if some fail, 2 if
    the assignment is unusable.

    Example: robsim assignment check hw1
    """
    from robsim.teach.assignments import check_assignment

    with report_errors():
        report = check_assignment(folder, executor=engine_of(jobs), progress=not as_json)
    errors.show(report.to_json() if as_json else report)
    if not report.ok:
        raise typer.Exit(1)


def pack(
    folder: Folder,
    students: Path | None = None,
    gradescope: Path | None = None,
    install: str | None = None,
) -> None:
    """Pack an assignment for students, or for Gradescope.

    Students get the sheet, start files, and the public tests with the reference's scores, but no
    key, no hidden test and no solution. The autograder contains everything for grading, including
    the key: upload it to Gradescope only.

    --students ZIP|FOLDER: Write the files for students to a zip or a folder.
    --gradescope ZIP: Write an autograder for Gradescope.
    --install WHEEL|NAME: With --gradescope: a wheel of robsim to install there, or a requirement
        for pip such as robsim==1.2. Default: this version, as found by pip.

    Example: robsim assignment pack hw1 --students hw1-students.zip
    """
    from robsim.teach.assignments import load_assignment, pack_gradescope, pack_students

    with report_errors():
        if students is None and gradescope is None:
            raise ValueError("no output to pack: give --students ZIP, --gradescope ZIP, or both")
        if install is not None and gradescope is None:
            raise ValueError("--install needs an autograder: add --gradescope ZIP")
        assignment = load_assignment(folder)
        for said in sorted({test.provisional for test in assignment.tests} - {""}):
            errors.print_note(f"warning: {said}")
        if students is not None:
            pack_students(assignment, students)
            errors.say(f"for students: {students}")
        if gradescope is not None:
            pack_gradescope(assignment, gradescope, install=install)
            errors.say(f"for Gradescope, with the secret key: {gradescope}")


HELP = (
    "Use the commands in this order. new writes a folder, with assignment.toml and sheet.md for "
    "you to edit. calibrate finds the score limits for points. check grades all known correct and "
    "wrong submissions. pack writes the students' files, and an autograder for Gradescope."
)
app = command_group("Start with: robsim assignment new park hw1")
for one in (new, calibrate, check, pack):
    command(app)(one)
