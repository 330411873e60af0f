"""The command ``robsim assignment check``: whether an assignment is fit to grade by."""

from __future__ import annotations

import typer

from robsim.cli import errors
from robsim.cli.assignment.options import Folder, report_errors
from robsim.cli.shared import Jobs, Json, engine_of

EXAMPLE = "Example: robsim assignment check hw1"
HELP = (
    "Check an assignment before you rely on it.\n\n"
    "A class is graded that is made of all that is known: right solutions, one also as a notebook, "
    "must get all points, wrong ones fewer, and none what is empty, ends its process, hangs, "
    "patches what scores it, or looks for the truth. The key must be secret, the limits those of "
    "this task; the sheet must name what is to be written; students must get nothing hidden.\n\n"
    "It takes a minute or two. The exit status is 0 if all is well, 1 if something is wrong, 2 if "
    "the assignment cannot be used at all."
)


def check(folder: Folder, jobs: Jobs = 1, as_json: Json = False) -> None:
    """Check an assignment before you rely on it."""
    from robsim.teach.assignments.checking.check import check_assignment

    with report_errors():
        report = check_assignment(folder, executor=engine_of(jobs), progress=not as_json)
    errors.show(report.to_json() if as_json else report)
    if not report.ok:
        raise typer.Exit(1)
