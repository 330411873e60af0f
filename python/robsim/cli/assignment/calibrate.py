"""The command ``robsim assignment calibrate``: from which score on there are points."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from robsim.cli import errors
from robsim.cli.assignment.options import Folder, report_errors
from robsim.cli.option import number_option
from robsim.cli.shared import Jobs, engine_of

if TYPE_CHECKING:
    from robsim.teach.tasks.marks.calibration import TaskCalibration

EXAMPLE = "Example: robsim assignment calibrate hw1 --jobs 2"
HELP = (
    "Find from which score on there are points, and write limits.json.\n\n"
    "The right solutions in solutions/ are run as often as it takes for a limit that as good a "
    "solution hardly ever misses, whatever the scores are distributed like. Then the wrong ones "
    "are run: in how many tests each has less than full points is printed. Ctrl-C loses nothing: "
    "the same command goes on."
)


def calibrate(
    folder: Folder,
    false_fail: Annotated[
        float,
        number_option(
            "--false-fail",
            "SHARE",
            "How often a right solution may have less than full points in a test, at most. A "
            "tenth of it takes ten times as long.",
        ),
    ] = 0.01,
    confidence: Annotated[
        float, number_option("--confidence", "SHARE", "In how many calibrations of 1 that is kept.")
    ] = 0.95,
    jobs: Jobs = 1,
) -> None:
    """Find from which score on there are points, and write limits.json."""
    with report_errors():
        calibrate_and_print(folder, jobs=jobs, false_fail=false_fail, confidence=confidence)


def calibrate_and_print(
    folder: Path, *, jobs: int, false_fail: float = 0.01, confidence: float = 0.95
) -> None:
    """Calibrate, and say beforehand how long it takes, afterwards what came of it."""
    from robsim.teach.assignments.assignment import Assignment
    from robsim.teach.assignments.calibration import (
        KEPT,
        calibrate_assignment,
        seconds_to_calibrate,
    )

    executor = engine_of(jobs)
    seconds = seconds_to_calibrate(
        Assignment.load(folder), false_fail=false_fail, confidence=confidence, processes=jobs
    )
    goes_on = (folder / KEPT).is_dir()
    begin = "what was done is kept; all of it takes" if goes_on else "calibrating takes"
    errors.print_note(f"{begin} about {_duration(seconds)}; Ctrl-C keeps what is done")
    sys.stderr.flush()
    try:
        found = calibrate_assignment(
            folder, false_fail=false_fail, confidence=confidence, executor=executor
        )
    except KeyboardInterrupt:
        errors.print_note(f"to go on: robsim assignment calibrate {folder}")
        raise
    for calibration, names in _together(found):
        errors.show(f"{', '.join(names)}: {calibration}")
        _warn(calibration)
    errors.say(f"written to {folder / 'limits.json'}")


def _duration(seconds: float) -> str:
    return f"{max(seconds, 1):.0f} s" if seconds < 90 else f"{seconds / 60:.0f} minutes"


def _together(found: dict[str, TaskCalibration]) -> list[tuple[TaskCalibration, list[str]]]:
    """Return each calibration with the names of its tests."""
    return [
        (one, [name for name, other in found.items() if other is one])
        for one in {id(one): one for one in found.values()}.values()
    ]


def _warn(calibration: TaskCalibration) -> None:
    for one in calibration.missed:
        errors.print_note(
            f"warning: wrong/{one.name} gets full points in {100 * (1 - one.rate):.0f} % of the "
            "tests: give the task more runs or steps, or take the solution out"
        )
