"""The code cells of a notebook, out of its JSON."""

from __future__ import annotations

import ast
import json
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from robsim.base.text import one_line, quoted
from robsim.teach.errors import SubmissionError
from robsim.teach.submissions.folder import size_text
from robsim.teach.submissions.names import refusal
from robsim.teach.submissions.python_text import check_extent, not_python, quiet

#: The tags of cells that go in whole, and of those that never count.
WHOLE, SKIP = "robsim", "robsim-skip"
_MOST_CELLS = 1000
_MOST_BRACKETS = 200_000  # 100 bytes of memory each
_UNREADABLE = re.compile("[\0\ud800-\udfff]")  # null characters, and halves of characters
_MARK = re.compile(r"#\s*(robsim-skip\b|robsim\s*:)", re.IGNORECASE)


@dataclass(frozen=True)
class Cell:
    """A code cell."""

    #: What messages and tracebacks call it: ``"s003.ipynb, cell 5"``; all cells count, from 1.
    place: str
    number: int
    source: str  # its code
    tag: str  # `WHOLE`, `SKIP` or empty

    @property
    def title(self) -> str:
        first = next((line for line in self.source.split("\n") if line.strip()), "")
        return f"cell {self.number} ({one_line(first.strip()[:40])})"


def cells_of(content: bytes, file: str) -> list[Cell]:
    """Return the code cells of a notebook; raise SubmissionError for another format."""
    notebook = _parsed(content, file)
    _check_format(notebook, file)
    cells = notebook.get("cells")
    if not isinstance(cells, list) or not all(isinstance(cell, dict) for cell in cells):
        raise refusal(file, " is not a notebook: it has no list of cells")
    if len(cells) > _MOST_CELLS:
        raise refusal(file, f" has more than {_MOST_CELLS} cells: hand in what counts")
    return list(_code_cells(cells, file))


def reduced(content: bytes, file: str, most: int) -> bytes:
    """Return a notebook's code and tags; SubmissionError as `cells_of`, or over `most` bytes."""
    cells: list[dict[str, Any]] = []
    for cell in cells_of(content, file):
        while len(cells) < cell.number - 1:  # so that the others keep their numbers
            cells.append({"cell_type": "markdown", "metadata": {}, "source": ""})
        metadata = {"tags": [cell.tag]} if cell.tag else {}
        cells.append({"cell_type": "code", "metadata": metadata, "source": cell.source})
    text = json.dumps({"nbformat": 4, "nbformat_minor": 5, "metadata": {}, "cells": cells})
    if len(text) > most:
        said = f"{size_text(most)} of code: put large tables into another file"
        raise refusal(file, f" has more than {said}")
    return text.encode("ascii")


def _parsed(content: bytes, file: str) -> Any:
    try:
        text = content.decode("utf-8-sig")
        if text.count("[") + text.count("{") > _MOST_BRACKETS:
            raise refusal(file, " is too involved: clear its outputs")
        return json.loads(text)
    except (ValueError, RecursionError, MemoryError):
        said = " is not a notebook: it is no JSON text; save it in Jupyter again"
        raise refusal(file, said) from None


def _check_format(notebook: Any, file: str) -> None:
    if not isinstance(notebook, dict) or "nbformat" not in notebook:
        said = "it does not say its format; save it in Jupyter again"
        raise refusal(file, f" is not a notebook: {said}")
    number = notebook["nbformat"]
    if type(number) is not int or number != 4:
        said = f"{quoted(number)}, and 4 is read: open it in Jupyter and save it again"
        raise refusal(file, f" is a notebook of format {said}")
    metadata = notebook.get("metadata")
    kernel = metadata.get("kernelspec") if isinstance(metadata, dict) else None
    language = kernel.get("language", "python") if isinstance(kernel, dict) else "python"
    if not isinstance(language, str) or language.lower() not in ("python", "ipython", ""):
        raise refusal(file, f" is a notebook in {quoted(language)}: it must be in Python")


def _code_cells(cells: list[dict[str, Any]], file: str) -> Iterator[Cell]:
    for number, cell in enumerate(cells, 1):
        if cell.get("cell_type") != "code":
            continue
        place = f"{file}, cell {number}"
        source = cell.get("source", "")
        if isinstance(source, list) and all(isinstance(line, str) for line in source):
            source = "".join(source)
        if not isinstance(source, str):
            raise refusal(place, " has no text: save the notebook in Jupyter again")
        source = source.replace("\r\n", "\n").replace("\r", "\n")
        if _UNREADABLE.search(source):
            raise refusal(place, ": it is not UTF-8 text: write the cell again")
        yield Cell(place, number, source, _tag(cell, source))


def _tag(cell: dict[str, Any], source: str) -> str:
    metadata = cell.get("metadata")
    tags = metadata.get("tags") if isinstance(metadata, dict) else None
    given = (
        {t.strip().lower().replace("_", "-") for t in tags or () if isinstance(t, str)}
        if isinstance(tags, list)
        else set()
    )
    mark = _MARK.match(source.lstrip())
    if SKIP in given or (mark and mark[1].lower() == SKIP):
        return SKIP
    return WHOLE if WHOLE in given or mark else ""


# Cell commands that run the cell as it is; all others make something else of it.
_TRANSPARENT = re.compile(r"%%(time|capture)\b")
_COMMAND = re.compile(r"[%!?]|[\w.]+\s*(?:,\s*[\w.]+\s*)*=\s*[%!]|.*\?\s*$")
_MOST_PARSED = 2**23  # characters: each command is found by parsing its cell once more
_MOST_STATEMENTS = 5000
#: Flags for `compile`: a notebook may await outside of functions.
AWAIT = ast.PyCF_ALLOW_TOP_LEVEL_AWAIT


def parsed(cells: Sequence[Cell], file: str) -> list[tuple[Cell, ast.stmt]]:
    """Return the statements of cells without commands, such as ``%matplotlib`` and ``!ls``.

    Raise SubmissionError for invalid Python, or for too much of it.
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
                raise refusal(file, " has too many commands: remove some")
            nodes = _statements_or_fewer_commands(lines, cell)
        statements += [(cell, node) for node in nodes]
    if len(statements) > _MOST_STATEMENTS:
        raise refusal(file, f" has more than {_MOST_STATEMENTS} statements: hand in what counts")
    return statements


def is_command(cell: Cell) -> bool:
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
        flags = ast.PyCF_ONLY_AST | AWAIT
        with quiet():
            tree = compile("\n".join(lines), cell.place, "exec", flags, dont_inherit=True)
        assert isinstance(tree, ast.Module)
        return tree.body
    except SyntaxError as error:
        line = _command_at(lines, error.lineno)
        if line is None:
            raise _told(error, cell) from None
        indent = len(lines[line]) - len(lines[line].lstrip())
        lines[line] = f"{' ' * indent}pass"
        return None
    except (ValueError, OverflowError, RecursionError, MemoryError) as error:
        raise _told(error, cell) from None


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
