"""Options that several commands of assignments share, and how an assignment is read."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import typer

from robsim.cli import errors
from robsim.cli.option import argument

Folder = Annotated[Path, argument("FOLDER", "The assignment, as robsim assignment new makes it.")]


@contextmanager
def report_errors() -> Iterator[None]:
    """Print an error as a sentence, and exit with 2; those of an assignment, too."""
    from robsim.teach.errors import GradingError

    with errors.report_errors():
        try:
            yield
        except GradingError as error:
            errors.print_error(error)
            raise typer.Exit(2) from None
