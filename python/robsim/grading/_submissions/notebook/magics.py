"""Python out of a cell: lines that are commands of the notebook are left out."""

from __future__ import annotations

import ast
import re
import warnings

from robsim.grading._errors import SubmissionError
from robsim.grading._submissions.notebook.cells import Cell
from robsim.grading._submissions.python_text import check_extent, not_python

# Cell commands that run the cell as it is; all others make something else of it.
_TRANSPARENT = re.compile(r"%%(time|capture)\b")
_COMMAND = re.compile(r"[%!?]|[\w.]+\s*(?:,\s*[\w.]+\s*)*=\s*[%!]|.*\?\s*$")
_MOST_COMMANDS = 100  # in a cell: each is found by parsing it once more

#: Flags for `compile`: a notebook may await outside of functions.
AWAIT = ast.PyCF_ALLOW_TOP_LEVEL_AWAIT


def parsed(cell: Cell) -> list[ast.stmt]:
    """Return the statements of a cell without commands, such as ``%matplotlib`` and ``!ls``.

    Raises
    ------
    SubmissionError
        If a cell is no Python.
    """
    lines = cell.source.split("\n")
    first = next((i for i, line in enumerate(lines) if line.strip()), None)
    if first is not None and lines[first].lstrip().startswith("%%"):
        if not _TRANSPARENT.match(lines[first].lstrip()):
            return []
        lines[first] = ""
    check_extent(cell.source, cell.place)
    for _ in range(_MOST_COMMANDS):
        try:
            return _statements("\n".join(lines), cell.place)
        except SyntaxError as error:
            line = _command_at(lines, error.lineno)
            if line is None:
                raise _told(error, cell) from None
            indent = len(lines[line]) - len(lines[line].lstrip())
            lines[line] = f"{' ' * indent}pass"
        except (ValueError, OverflowError, RecursionError, MemoryError) as error:
            raise _told(error, cell) from None
    raise SubmissionError(
        f"{cell.place} has more than {_MOST_COMMANDS} commands: tag it robsim-skip", file=cell.place
    )


def _statements(text: str, place: str) -> list[ast.stmt]:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
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
