"""The command ``robsim grade``: how the submissions of others are shut in on this machine."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from robsim.cli import errors
from robsim.cli.shared import SWITCH, Json

if TYPE_CHECKING:
    from robsim.grading import IsolationReport

EXAMPLE = "Example: robsim grade --check-isolation"
HELP = (
    "Check how submissions are shut in on this machine.\n\n"
    "A submission is run in a process of its own, which sees the frames and none of the truth. "
    "With --check-isolation such a process tries to get out in each way that is known: files, "
    "processes, network, the grader's memory. What held is printed, and what nothing protects "
    "from. The exit status is 0 if the level can be had, 3 if --isolation strict cannot, 2 if no "
    "process can be started at all.\n\n"
    "To grade: python -m pytest --robsim-submission=PATH TESTS.py; see README, For teachers."
)
_NOT_STRICT = 3


def grade(
    check_isolation: Annotated[
        bool,
        typer.Option(
            "--check-isolation",
            metavar=SWITCH,
            help="Let a process try to get out, and say what held.",
        ),
    ] = False,
    isolation: Annotated[
        str,
        typer.Option(
            "--isolation",
            metavar="LEVEL",
            help="auto: all that works here; strict: the same, and files, processes, network and "
            "memory must be closed; process: limits alone; none: a process, and nothing else.",
        ),
    ] = "auto",
    as_json: Json = False,
) -> None:
    """Check how submissions are shut in."""
    from robsim.grading import GraderError, IsolationError

    if not check_isolation:
        errors.print_error(
            "what is to be checked? --check-isolation. To grade: "
            "python -m pytest --robsim-submission=PATH TESTS.py"
        )
        raise typer.Exit(2)
    missing: object = None
    try:
        try:
            report = _checked(isolation)
        except IsolationError as error:
            missing, report = error, _checked("auto")
    except GraderError as error:
        errors.print_error(error)
        raise typer.Exit(2) from None
    errors.show(report.to_json() if as_json else report)
    if missing is not None:
        errors.print_error(missing)
    if missing is not None or (isolation == "strict" and not report.strict):
        raise typer.Exit(_NOT_STRICT)


def _checked(isolation: str) -> IsolationReport:
    from robsim.grading import check_isolation

    with errors.report_errors():
        return check_isolation(isolation=isolation)  # type: ignore[arg-type]
