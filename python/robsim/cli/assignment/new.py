"""The command ``robsim assignment new``: the folder of a new assignment."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from robsim.cli import errors
from robsim.cli.assignment.calibrate import calibrate_and_print
from robsim.cli.assignment.options import report_errors
from robsim.cli.option import argument, integer_option, option, switch
from robsim.cli.shared import Jobs

EXAMPLE = "Example: robsim assignment new park hw1"
HELP = (
    "Make the folder of a new assignment.\n\n"
    "TEMPLATE is park, follow, identify, measure or estimate. The folder gets a key of "
    "its own, numbers drawn for it, sheet, solutions right and wrong, a public and a hidden test, "
    "and limits that are calibrated for it, which takes 10 to 30 minutes: Ctrl-C leaves a "
    "folder that robsim assignment calibrate completes. Its README.md says what is what."
)


def new(
    template: Annotated[str, argument("TEMPLATE", "What students are to do.")],
    folder: Annotated[Path, argument("FOLDER", "The folder, which is made.")],
    name: Annotated[
        str | None, option("--name", "TEXT", "Name of the assignment. Default: that of the folder.")
    ] = None,
    no_calibrate: Annotated[
        bool, switch("--no-calibrate", "Leave that to robsim assignment calibrate.")
    ] = False,
    seed: Annotated[
        int | None,
        integer_option(
            "--seed",
            "N",
            "What the numbers are drawn from; the key is always new. Default: another one "
            "each time.",
        ),
    ] = None,
    jobs: Jobs = 1,
) -> None:
    """Make the folder of a new assignment."""
    from robsim.teach.assignments.making.folder import new_assignment

    with report_errors():
        made = new_assignment(template, folder, name=name, seed=seed)
        errors.say(f"written to {folder}: {made.title}, {_drawn(made.tests[0].task.parameters)}")
        if not no_calibrate:
            calibrate_and_print(folder, jobs=jobs)
            errors.say(f"next: robsim assignment check {folder}")
            return
    errors.say(f"next: robsim assignment calibrate {folder}")


def _drawn(parameters: dict[str, object]) -> str:
    return ", ".join(f"{key} {value}" for key, value in parameters.items())
