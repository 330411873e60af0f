"""Tables of a teacher: the cells of a CSV file from a spreadsheet program."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from robsim.base.files import content_of, read_text, write_whole
from robsim.base.text import one_line

_MOST = 2**24  # bytes
#: The key of cells without a column.
EXTRA = "\0"
_ENCODINGS = {b"\xff\xfe": "utf-16", b"\xfe\xff": "utf-16", b"\xef\xbb": "utf-8-sig"}


@dataclass
class Table:
    """The cells of the file, and its format."""

    file: Path
    columns: list[str]
    rows: list[dict[str, Any]]
    delimiter: str = ","
    encoding: str = "utf-8-sig"  # without its mark Excel assumes another encoding

    @classmethod
    def read(cls, file: Path) -> Table:
        """Return the table of a file; raise ValueError if the file is broken."""
        text = read_text(file, _MOST)
        delimiter = max(",;\t", key=text.partition("\n")[0].count)
        content = io.StringIO(text, newline="")
        rows = csv.DictReader(content, None, EXTRA, "", delimiter=delimiter)
        try:
            rows.fieldnames = [name.strip() for name in rows.fieldnames or ()]
            encoding = _ENCODINGS.get(content_of(file, 2), "utf-8")
            return cls(file, [*rows.fieldnames], [*rows], delimiter, encoding)
        except csv.Error as error:
            raise ValueError(f"{one_line(file)}: {error}") from None

    def complete(self, columns: Sequence[str], students: Sequence[str]) -> None:
        """Add columns and rows, and change nothing else."""
        lacking = [name for name in columns if name not in self.columns]
        if not lacking and not students:
            return
        content = io.StringIO()
        names, delimiter = self.columns + lacking, self.delimiter
        table = csv.DictWriter(content, names, delimiter=delimiter, extrasaction="ignore")
        table.writeheader()
        table.writerows([*self.rows, *({"student": student} for student in students)])
        self.file.parent.mkdir(parents=True, exist_ok=True)
        write_whole(self.file, content.getvalue().encode(self.encoding, "backslashreplace"))
