"""``robsim grade --check-isolation``: how submissions are shut in on this machine."""

from __future__ import annotations

from typing import TYPE_CHECKING

import typer

from robsim.cli import errors

if TYPE_CHECKING:
    from robsim.teach.isolation.check import IsolationReport

NO_WORKER, NOT_STRICT = 2, 3  # exit statuses


def print_isolation(isolation: str, *, as_json: bool) -> None:
    """Print what holds; exit with the status that says whether the level can be had."""
    from robsim.teach.errors import GraderError
    from robsim.teach.isolation.start import IsolationError

    missing: object = None
    try:
        try:
            report = checked_isolation(isolation)
        except IsolationError as error:
            missing, report = error, checked_isolation("auto")
    except GraderError as error:
        errors.print_error(error)
        raise typer.Exit(NO_WORKER) from None
    errors.show(report.to_json() if as_json else report)
    if missing is not None:
        errors.print_error(missing)
    if missing is not None or (isolation == "strict" and not report.strict):
        raise typer.Exit(NOT_STRICT)


def checked_isolation(isolation: str) -> IsolationReport:
    """Return what holds at a level, as it was tried out."""
    from robsim.teach.isolation.check import check_isolation

    with errors.report_errors():
        return check_isolation(isolation=isolation)  # type: ignore[arg-type]
