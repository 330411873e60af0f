"""The commands ``robsim tasks list`` and ``show``."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

from robsim.cli import errors
from robsim.cli.option import argument, option

SHOW_EXAMPLE = "Example: robsim tasks show park --to parking"
SHOW_HELP = (
    "Show a task: what it asks, what is given, how it is scored.\n\n"
    "With --to it is written to a folder as sheet.md, with a file for each callback to write, and "
    "task.py with the values that they are told. Nothing is overwritten there."
)

Name = Annotated[
    str, argument("TASK", "Name of the task, as of robsim tasks list.", show_default=False)
]


def list_tasks() -> None:
    """List the tasks, and which callbacks they ask for."""
    from robsim.teach.tasks.by_name import TASKS

    rows = [(name, kind.title, ", ".join(kind.slots)) for name, kind in TASKS.items()]
    errors.print_rows(("task", "what is to be done", "callbacks"), rows)


def show(
    name: Name,
    to: Annotated[
        Path | None,
        option(
            "--to", "FOLDER", "Write the sheet and files to start from there; created if needed."
        ),
    ] = None,
) -> None:
    """Show a task."""
    from robsim.teach.tasks.by_name import task

    with errors.report_errors():
        one = task(name)
        if to is None:
            _print(one.sheet)
            return
        files = one.begin(to)
    errors.say(f"written to {to}: {', '.join(file.name for file in files)}")
    errors.say(f"read {to / 'sheet.md'}; then: robsim tasks try {name} {to}")


def _print(sheet: str) -> None:
    """Print Markdown, in a terminal as it is meant to look."""
    if not sys.stdout.isatty():
        errors.show(sheet)
        return
    from rich.markdown import Markdown

    errors.print_page([Markdown(sheet)])
