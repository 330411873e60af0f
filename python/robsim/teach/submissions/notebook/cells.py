"""The code cells of a notebook, from its JSON, and their Python statements."""

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
from robsim.teach.submissions.python_text import check_extent, compiled

#: The tags of cells that count as a whole, and of cells that never count.
WHOLE, SKIP = "robsim", "robsim-skip"
#: Flags for `compile`: a notebook may await outside of functions.
AWAIT = ast.PyCF_ALLOW_TOP_LEVEL_AWAIT
_MOST_CELLS = 1000
_MOST_BRACKETS = 200_000  # 100 bytes of memory each
_MOST_PARSED = 2**23  # characters: each command needs another parse of its cell
_MOST_STATEMENTS = 5000
_LONGEST_LINE = 50  # characters, in a message
_UNREADABLE = re.compile("[\0\ud800-\udfff]")  # null characters, and halves of characters
_MARK = re.compile(r"\s*#\s*(robsim-skip\b|robsim(?=\s*:))", re.IGNORECASE)
_OTHER_LANGUAGE = re.compile(r"\s*%%(?!(time|capture)\b)")
_COMMAND = re.compile(r"(\s*)(?:[%!?]|[\w.]+\s*(?:,\s*[\w.]+\s*)*=\s*[%!]|.*\?\s*$)")


@dataclass(frozen=True)
class Cell:
    """A code cell."""

    #: Its name in messages and tracebacks: ``"s003.ipynb, cell 5"``; numbers include all cells.
    place: str
    number: int
    source: str  # its code
    tag: str  # `WHOLE`, `SKIP` or empty

    def told(self, line: int) -> str:
        """Return a line of the cell for a message: ``"cell 5, line 2 (K = 3)"``."""
        text = self.source.split("\n")[line - 1].strip()
        shown = text if len(text) <= _LONGEST_LINE else f"{text[:_LONGEST_LINE]}..."
        return f"cell {self.number}, line {line} ({one_line(shown)})"

    @property
    def command(self) -> str:
        """The line that turns the cell into a command, for a message, or an empty text."""
        found = _OTHER_LANGUAGE.match(self.source)
        return self.told(found[0].count("\n") + 1) if found else ""


def cells_of(content: bytes, file: str) -> list[Cell]:
    """Return the code cells of a notebook; raise SubmissionError for another format."""
    cells = _parsed(content, file).get("cells")
    if not isinstance(cells, list) or not all(isinstance(cell, dict) for cell in cells):
        raise refusal(file, " is not a notebook: it has no list of cells")
    if len(cells) > _MOST_CELLS:
        raise refusal(file, f" has more than {_MOST_CELLS} cells: delete unused ones")
    numbered = enumerate(cells, 1)
    return [_cell(cell, file, n) for n, cell in numbered if cell.get("cell_type") == "code"]


def reduced(content: bytes, file: str, most: int) -> bytes:
    """Return a notebook's code and tags; SubmissionError as `cells_of`, or over `most` bytes."""
    cells: list[dict[str, Any]] = []
    for cell in cells_of(content, file):
        cells += [{"cell_type": "markdown"}] * (cell.number - 1 - len(cells))  # keeps the numbers
        cells.append({"cell_type": "code", "metadata": {"tags": [cell.tag]}, "source": cell.source})
    text = json.dumps({"nbformat": 4, "cells": cells})
    if len(text) > most:
        said = f"{size_text(most)} of code: put large tables into another file"
        raise refusal(file, f" has more than {said}")
    return text.encode("ascii")


def _parsed(content: bytes, file: str) -> dict[str, Any]:
    try:
        text = content.decode("utf-8-sig")
        if text.count("[") + text.count("{") > _MOST_BRACKETS:
            raise refusal(file, " is too complex: clear its outputs")
        notebook = json.loads(text)
    except (ValueError, RecursionError, MemoryError):
        said = " is not a notebook: it is no JSON text; save it in Jupyter again"
        raise refusal(file, said) from None
    number = notebook.get("nbformat") if isinstance(notebook, dict) else None
    if type(number) is not int or number != 4:
        said = f"{quoted(number)}, but only 4 is supported: open it in Jupyter and save it again"
        raise refusal(file, f" is a notebook of format {said}")
    language = _inner(_inner(notebook, "metadata"), "kernelspec").get("language", "python")
    if str(language)[:9].lower() not in ("python", "ipython", ""):
        raise refusal(file, f" is a notebook in {quoted(language)}: it must be in Python")
    return dict(notebook)


def _inner(data: dict[str, Any], key: str) -> dict[str, Any]:
    found = data.get(key)
    return found if isinstance(found, dict) else {}


def _cell(cell: dict[str, Any], file: str, number: int) -> Cell:
    place = f"{file}, cell {number}"
    source = cell.get("source", "")
    if isinstance(source, list) and all(isinstance(line, str) for line in source):
        source = "".join(source)
    if not isinstance(source, str):
        raise refusal(place, " has no text: save the notebook in Jupyter again")
    source = source.replace("\r\n", "\n").replace("\r", "\n")
    if _UNREADABLE.search(source):
        raise refusal(place, ": it is not UTF-8 text: write the cell again")
    tags = _inner(cell, "metadata").get("tags")
    given = [tag for tag in tags if isinstance(tag, str)] if isinstance(tags, list) else []
    if mark := _MARK.match(source):
        given.append(mark[1])
    tidy = {tag.strip().lower().replace("_", "-") for tag in given}
    return Cell(place, number, source, next((tag for tag in (SKIP, WHOLE) if tag in tidy), ""))


def parsed(cells: Sequence[Cell], file: str) -> Iterator[tuple[Cell, ast.stmt]]:
    """Yield the statements of cells without commands, such as ``%matplotlib`` and ``!ls``.

    Raise SubmissionError for invalid Python, or for too much of it.
    """
    check_extent("\n".join(cell.source for cell in cells), file)
    spent = count = 0
    for cell in cells:
        lines = [] if cell.command else cell.source.split("\n")
        tree = None
        while tree is None:
            spent += len(cell.source)
            if spent > _MOST_PARSED:
                raise refusal(file, " has too many commands: remove some")
            try:
                tree = compiled(
                    "\n".join(lines), cell.source, cell.place, ast.PyCF_ONLY_AST | AWAIT
                )
            except SubmissionError as error:
                at = (error.line or 1) - 1
                if error.line is None or not (command := _COMMAND.match(lines[at])):
                    said = f"{error}; correct the cell, or tag it robsim-skip"
                    raise SubmissionError(said, file=error.file, line=error.line) from None
                lines[at] = f"{command[1]}pass"
        count += len(tree.body)
        if count > _MOST_STATEMENTS:
            said = f" has more than {_MOST_STATEMENTS} statements: delete unused ones"
            raise refusal(file, said)
        yield from ((cell, node) for node in tree.body)
