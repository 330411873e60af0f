"""Python out of a cell: lines that are commands of the notebook are left out."""

from __future__ import annotations

import ast
import re
from collections.abc import Sequence

from robsim.teach.errors import SubmissionError
from robsim.teach.submissions.notebook.cells import Cell
from robsim.teach.submissions.python_text import check_extent, not_python, quiet

# Cell commands that run the cell as it is; all others make something else of it.
_TRANSPARENT = re.compile(r"%%(time|capture)\b")
_COMMAND = re.compile(r"[%!?]|[\w.]+\s*(?:,\s*[\w.]+\s*)*=\s*[%!]|.*\?\s*$")
_MOST_PARSED = 2**23  # characters: each command is found by parsing its cell once more
_MOST_STATEMENTS = 5000

#: Flags for `compile`: a notebook may await outside of functions.
AWAIT = ast.PyCF_ALLOW_TOP_LEVEL_AWAIT


def parsed(cells: Sequence[Cell], file: str) -> list[tuple[Cell, ast.stmt]]:
    """Return the statements of cells without commands, such as ``%matplotlib`` and ``!ls``.

    Raises
    ------
    SubmissionError
        If a cell is no Python, or all of them are too much.
    """
    check_extent("\n".join(cell.source for cell in cells), file)
    statements: list[tuple[Cell, ast.stmt]] = []
    spent = 0
    for cell in cells:
        lines = _without_cell_command(cell)
        nodes = None
        while nodes is None:
            spent += len(cell.source)
            if spent > _MOST_PARSED:
                raise SubmissionError(f"{file} has too many commands: remove some", file=file)
            nodes = _statements_or_fewer_commands(lines, cell)
        statements += [(cell, node) for node in nodes]
    if len(statements) > _MOST_STATEMENTS:
        raise SubmissionError(
            f"{file} has more than {_MOST_STATEMENTS} statements: hand in what counts", file=file
        )
    return statements


def is_command(cell: Cell) -> bool:
    """Return whether a whole cell is a command, such as ``%%bash``."""
    first = _first_line(cell.source.split("\n"))
    return first.startswith("%%") and not _TRANSPARENT.match(first)


def _first_line(lines: list[str]) -> str:
    return next((line for line in lines if line.strip()), "").lstrip()


def _without_cell_command(cell: Cell) -> list[str]:
    """Return the lines of a cell that Python gets, where the first one may be a cell's command."""
    if is_command(cell):
        return []
    lines = cell.source.split("\n")
    first = _first_line(lines)
    if not first.startswith("%%"):
        return lines
    return ["" if line.lstrip() == first else line for line in lines]


def _statements_or_fewer_commands(lines: list[str], cell: Cell) -> list[ast.stmt] | None:
    """Return the statements of a cell; or take one command out of its lines, and return None."""
    try:
        return _statements("\n".join(lines), cell.place)
    except SyntaxError as error:
        line = _command_at(lines, error.lineno)
        if line is None:
            raise _told(error, cell) from None
        indent = len(lines[line]) - len(lines[line].lstrip())
        lines[line] = f"{' ' * indent}pass"
        return None
    except (ValueError, OverflowError, RecursionError, MemoryError) as error:
        raise _told(error, cell) from None


def _statements(text: str, place: str) -> list[ast.stmt]:
    with quiet():
        tree = compile(text, place, "exec", ast.PyCF_ONLY_AST | AWAIT, dont_inherit=True)
    assert isinstance(tree, ast.Module)
    return tree.body


def _command_at(lines: list[str], number: int | None) -> int | None:
    """Return the line, from 0, of a command that Python does not understand; None = it is none."""
    if number is None or not 1 <= number <= len(lines):
        return None
    return number - 1 if _COMMAND.match(lines[number - 1].lstrip()) else None


def _told(error: BaseException, cell: Cell) -> SubmissionError:
    told = not_python(error, cell.source, cell.place)
    return SubmissionError(
        f"{told}; mend the cell, or tag it robsim-skip", file=told.file, line=told.line
    )
