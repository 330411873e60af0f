"""The output of commands, and their exit codes: 1 = error in a callback, 2 = other errors."""

from __future__ import annotations

import errno
import traceback
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING

import typer
from rich.console import Console, RenderableType
from rich.measure import Measurement
from rich.text import Text

from robsim.base.source_line import line_of_error
from robsim.base.text import one_line, printable, said_by

if TYPE_CHECKING:
    from rich.table import Table

# The shell's names of the arguments of the running command.
_names: ContextVar[Mapping[str, str]] = ContextVar("names", default=MappingProxyType({}))
_WIDEST = 1000  # characters
_WIDEST_PAGE = 100


@contextmanager
def names(given: Mapping[str, str]) -> Iterator[None]:
    """Replace the argument's name at the start of messages by the shell's name."""
    token = _names.set({**_names.get(), **given})
    try:
        yield
    finally:
        _names.reset(token)


def in_shell_words(message: str) -> str:
    """Return a message that begins with an argument's name, ``name must`` or ``name:``, renamed."""
    first, _, rest = message.partition(" ")
    name = first.removesuffix(":").partition("[")[0]
    begins = first.endswith(":") or rest.startswith(("must ", "has "))
    shown = _names.get().get(name) if begins else None
    return message if shown is None else shown + message.removeprefix(name)


@contextmanager
def report_errors(folder: Path | None = None) -> Iterator[None]:
    """Print an error as one sentence and exit with code 2.

    An error in the user's callbacks, in `folder`, is printed with a traceback of these files, and
    exits with code 1.
    """
    try:
        yield
    except KeyboardInterrupt:
        raise
    except BaseException as error:
        from robsim.simulation.callbacks.errors import callback_of
        from robsim.simulation.slots import SLOTS

        if isinstance(error, typer.Exit) or _is_of_output(error):
            raise
        if folder is not None and (text := _in_callbacks(error, folder)):
            print_error(text)
            raise typer.Exit(code=1) from error
        if not isinstance(error, Exception):  # a module of the user ended Python
            print_error(f"{line_of_error(error)}: {said_by(error)}")
            raise typer.Exit(code=1) from error
        if not isinstance(error, (ValueError, TypeError, OSError, ImportError, RuntimeError)):
            raise
        print_error(_sentence(error))
        failed = callback_of(error)
        is_callback = failed is not None and failed.slot in SLOTS
        raise typer.Exit(code=1 if is_callback else 2) from error


def _is_of_output(error: BaseException) -> bool:
    if not isinstance(error, OSError) or error.filename is not None:
        return False
    return error.errno in (errno.EPIPE, errno.ENOSPC)


def _sentence(error: BaseException) -> str:
    """Return the message and the notes of an error."""
    text = in_shell_words(str(error))
    if isinstance(error, OSError) and error.filename and error.strerror:
        text = f"{error.filename}: {error.strerror}"
    return "\n".join(map(one_line, [text, *getattr(error, "__notes__", [])]))


def _in_callbacks(error: BaseException, folder: Path) -> str | None:
    """Return the traceback of an error within the user's files; None if outside them."""
    root = folder.resolve()
    frames = [
        frame
        for frame in traceback.extract_tb(error.__traceback__)
        if root in Path(frame.filename).resolve().parents
    ]
    if not frames and not isinstance(error, SyntaxError):
        return None
    notes = "; ".join(getattr(error, "__notes__", []))
    summary = traceback.format_list(frames)
    kind = traceback.TracebackException(type(error), error, None)
    kind.__notes__ = None
    told = kind.format_exception_only()
    return "".join([f"{notes or 'in a callback'}:\n", *summary, *told]).rstrip()


def print_error(error: object) -> None:
    """Print an error message to stderr."""
    console = Console(stderr=True, soft_wrap=True)
    console.print("[bold red]error:[/] ", end="")
    console.print(printable(error), markup=False, highlight=False)


# All that goes to stdout goes through here: no text from outside may command the terminal.


def say(line: object) -> None:
    """Print a line to stdout."""
    print(one_line(line))


def show(text: object) -> None:
    """Print a result of several lines to stdout."""
    print(printable(text))


def print_rows(titles: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """Print a table of texts to stdout."""
    from rich.box import SIMPLE_HEAD
    from rich.markup import escape
    from rich.table import Table

    table = Table(box=SIMPLE_HEAD, pad_edge=False)
    for title in titles:
        table.add_column(title, no_wrap=True)
    for row in rows:
        table.add_row(*(escape(one_line(cell)) for cell in row))
    print_table(table)


def print_table(table: Table) -> None:
    """Print a table to stdout; in a narrow terminal, lines wrap instead of being cut."""
    console = Console()
    width = Measurement.get(console, console.options.update(width=_WIDEST), table).maximum
    console.width = max(console.width, width)
    console.print(table)


def print_page(parts: Iterable[RenderableType]) -> None:
    """Print texts and tables one below the other to stdout, in lines of a readable length."""
    console = Console(highlight=False, markup=False, emoji=False)
    console.width = min(console.width, _WIDEST_PAGE)
    for part in parts:
        console.print(part)


def styled(text: str, style: str = "") -> Text:
    """Return a text in a style for a page."""
    return Text(printable(text), style)


def print_note(text: str) -> None:
    """Print a remark to stderr, separate from the results."""
    Console(stderr=True, soft_wrap=True).print(printable(text), markup=False, highlight=False)
