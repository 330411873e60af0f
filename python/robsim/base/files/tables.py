"""Writing columns as CSV, for spreadsheets and programs."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from robsim.base.files.writing import open_whole
from robsim.base.text import as_cell, is_plain


def write_csv(path: Path, columns: Mapping[str, Iterable[Any]]) -> None:
    """Write columns by name; None and NaN stay empty.

    A text that a spreadsheet would take for a formula gets a ' before it.

    Raises
    ------
    OSError
        If it cannot be written; an old file of that name is unchanged then.
    """
    with open_whole(path) as stream:
        file = io.TextIOWrapper(stream, encoding="utf-8", newline="")
        writer = csv.writer(file)
        head = writer if all(map(is_plain, columns)) else csv.writer(file, quoting=csv.QUOTE_ALL)
        head.writerow(map(as_cell, columns))
        for row in zip(*columns.values(), strict=True):
            writer.writerow(map(_cell, row))
        file.flush()
        file.detach()


def _cell(value: Any) -> Any:
    if isinstance(value, str):
        return as_cell(value)
    return "" if value is None or value != value else value
