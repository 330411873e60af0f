"""The place of a slot's code: file and line."""

from __future__ import annotations

import inspect
import textwrap
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from robsim.base.source_line import inner_of, users_line_of_callable
from robsim.base.text import one_line
from robsim.simulation import Experiment, Simulation
from robsim.simulation.slots import SLOTS
from robsim.simulation.slotted import is_code

_MOST_TEXT = 200_000  # characters that a browser is sent


@dataclass(frozen=True)
class Place:
    """The place of a user's code for a slot."""

    file: Path | None  # None = no file, such as in a cell
    line: int | None  # number of its first line


def name_in(runner: Simulation | Experiment, slot: str) -> str | None:
    """Return the name of the callback in a slot; None = the stage is off."""
    value, row = runner._callbacks[slot], SLOTS[slot]
    if value is False or (value is None and row.is_optional):
        return None
    if value is None or value is True:
        return row.default or None
    value = inner_of(value)
    return str(getattr(value, "__name__", type(value).__name__))


def place_in(runner: Simulation | Experiment, slot: str) -> Place:
    """Return the place of the user's code of a slot; also a folder's file that is off."""
    value = runner._callbacks[slot]
    line = users_line_of_callable(value) if is_code(value) else None
    if (file := _file_in_folder(runner, slot)) is not None:
        return Place(file, line.number if line and line.file == str(file) else 1)
    if line is None:
        return Place(None, None)
    file = Path(line.file)
    return Place(file.absolute() if file.is_file() else None, line.number)


def source_in(runner: Simulation | Experiment, slot: str) -> tuple[str, int]:
    """Return the text of a slot and the number of its first line.

    A file of a folder is shown as a whole, other user code from its first line. Defaults of robsim
    show an example instead. OSError if a file cannot be read.
    """
    value = runner._callbacks[slot]
    if (file := _file_in_folder(runner, slot)) is not None:
        text, first = file.read_text("utf-8", errors="replace"), 1
    elif is_code(value) and not is_ours(value):
        text, first = _code_of(value)
    else:
        text, first = _example(runner, slot), 1
    return text[:_MOST_TEXT], first


def _code_of(value: Callable[..., Any]) -> tuple[str, int]:
    value = inspect.unwrap(inner_of(value))
    is_object = not (inspect.isroutine(value) or inspect.isclass(value))
    # For a class in a cell, Python knows only the methods.
    for code in (type(value), type(value).__call__) if is_object else (value,):
        try:
            lines, first = inspect.getsourcelines(code)
        except (OSError, TypeError):  # typed at a prompt, or made by exec
            continue
        return textwrap.dedent("".join(lines)), first
    return f"# The source of {one_line(value)} is not known.\n", 1


def _example(runner: Simulation | Experiment, slot: str) -> str:
    row = SLOTS[slot]
    name = name_in(runner, slot)
    now = "This stage is off." if name is None else f"In the slot: {name}."
    text = row.template.read_text("utf-8")
    return (
        f"# {row.signature} -> {row.result}\n# {now} A callback of your own may begin as:\n\n{text}"
    )


def _file_in_folder(runner: Simulation | Experiment, slot: str) -> Path | None:
    folder = runner._folder
    if folder is None or slot not in runner._from_folder:
        return None
    file = folder._absolute / f"{slot}.py"
    return file if file.is_file() else None


def is_ours(value: object) -> bool:
    module = getattr(inner_of(value), "__module__", None) or ""
    return module.partition(".")[0] == "robsim"
