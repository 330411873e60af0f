"""What a command says when it fails."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import typer
from rich.console import Console


@contextmanager
def told() -> Iterator[None]:
    """Tell the user of a wrong input in a sentence, and end with status 2."""
    try:
        yield
    except (ValueError, TypeError, OSError, ImportError) as error:
        tell(error)
        raise typer.Exit(code=2) from error


def tell(error: object) -> None:
    """Print an error message."""
    console = Console(stderr=True, soft_wrap=True)
    console.print("[bold red]error:[/] ", end="")
    console.print(str(error), markup=False, highlight=False)
