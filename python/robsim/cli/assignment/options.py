"""Options that several commands of assignments share, and how an assignment is read."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import typer

from robsim.cli import errors
from robsim.cli.text import whole_number

Folder = Annotated[
    Path,
    typer.Argument(metavar="FOLDER", help="The assignment, as robsim assignment new makes it."),
]
Jobs = Annotated[
    int,
    typer.Option("--jobs", parser=whole_number, metavar="N", help="Number of processes."),
]


@contextmanager
def report_errors() -> Iterator[None]:
    """Print an error as a sentence, and exit with 2; those of an assignment, too."""
    from robsim.grading import GradingError

    with errors.report_errors():
        try:
            yield
        except GradingError as error:
            errors.print_error(error)
            raise typer.Exit(2) from None


def engine_of(jobs: int) -> int | None:
    """Return the executor of a number of processes."""
    if jobs < 1:
        raise ValueError(f"--jobs must be at least 1, got {jobs}")
    return jobs if jobs > 1 else None
