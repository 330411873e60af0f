"""Reads sessions of an earlier robsim: a folder with a video, rows and the set-up."""

from __future__ import annotations

import csv
import os
import struct
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, BinaryIO

from robsim.base.files import codec, open_file, read_text
from robsim.base.text import cut, one_line
from robsim.trace.sessions._file import Place, Recorded
from robsim.trace.sessions.rows import ARRAYS, MOST_LINE, MOST_ROWS, Row, row_of

SETUP, FORMAT = "setup.toml", 2
_ROWS, _VIDEO, _END, _TRACE = "steps.csv", "frames.mkv", "end.toml", "trace.npz"
_CLUSTER = struct.Struct(">I Q BBQ BQ BHB")  # of Matroska, with one picture to its end
_MOST_HEAD, _MOST_PICTURE = 512, 2**28  # bytes
_LONG = 1 << 56  # marks a size of eight bytes
_INTS = ("k", "video_frame", "frame_index", "headings")


def read_folder(folder: Path) -> Recorded:
    """Return the content of a folder; ValueError names a damaged file."""
    found = Recorded(folder / _VIDEO, folder / _TRACE, read_text(folder / SETUP))
    pictures = _read(folder / _VIDEO, _pictures)
    rows = _read(folder / _ROWS, _rows)
    found.rows = [row for row, _ in rows]
    found.places = [pictures[n] if n is not None and n < len(pictures) else None for _, n in rows]
    if missing := sum(n is not None and n >= len(pictures) for _, n in rows):
        found.problems.append(f"{_VIDEO} is cut off: {missing} steps have no frame")
    if not (end := folder / _END).is_file():
        found.problems.append("the recording was not ended: it was killed")
    elif type(steps := codec.load_table(end).get("steps")) is int:
        found.steps = steps
    if found.trace_file.is_file():
        found.trace = Place(0, found.trace_file.stat().st_size)
    return found


def _read(path: Path, read: Callable[[BinaryIO], Iterator[Any]]) -> list[Any]:
    """Return the result of `read` for a file; nothing if the run was killed first."""
    try:
        with open_file(path) as file:
            return [*read(file)]
    except FileNotFoundError:
        return []
    except (ValueError, TypeError, OverflowError, csv.Error) as error:
        raise ValueError(f"{one_line(path)}: {cut(error)}") from error


def _rows(file: BinaryIO) -> Iterator[tuple[Row, int | None]]:
    """Give the whole rows, and the number of their picture."""
    names, last, k = file.readline(MOST_LINE).decode().rstrip("\n").split(","), -1, None
    for number, line in enumerate(iter(lambda: file.readline(MOST_LINE + 2), b"")):
        if not line.endswith(b"\n") and len(line) <= MOST_LINE:
            return
        if len(line) > MOST_LINE + 1 or number == MOST_ROWS:
            raise ValueError(f"it must have at most {MOST_ROWS} lines, of {MOST_LINE} bytes each")
        (cells,) = csv.reader([line.decode().rstrip("\n")], strict=True)
        table = {name: _value(name, cell) for name, cell in zip(names, cells, strict=True)}
        arrays = {name: [table.get(part) for part in parts] for name, parts in ARRAYS.items()}
        row, picture = row_of(table | arrays), table.get("video_frame")
        if (k is not None and row.k != k + 1) or picture not in (None, last + 1):
            raise ValueError(
                f"step {row.k} with picture {picture} must not follow step {k} with picture {last}"
            )
        k, last = row.k, last if picture is None else picture
        yield row, picture


def _value(name: str, cell: str) -> Any:
    if not cell or name in ("reason", "left_out"):
        return cell or None
    if name == "interrupted":
        return cell == "1"
    if name == "plane_map":
        numbers = [float(part) for part in cell.split(" ")]
        fx, fy, cx, cy, *distortion = numbers[9:] or (1, 1, 0, 0)
        lens = {"matrix": [[fx, 0, cx], [0, fy, cy], [0, 0, 1]], "distortion": distortion}
        matrix = {"matrix": [numbers[row : row + 3] for row in (0, 3, 6)]}
        return matrix | ({"intrinsics": lens} if distortion else {})
    return int(cell) if name in _INTS else float(cell)


def _pictures(file: BinaryIO) -> Iterator[Place]:
    """Give the places of the whole pictures."""
    size = file.seek(0, os.SEEK_END)
    file.seek(0)
    place = file.read(_MOST_HEAD).find(b"\x1f\x43\xb6\x75")  # the first cluster
    while place >= 0:
        file.seek(place)
        if len(start := file.read(_CLUSTER.size)) < _CLUSTER.size:
            return
        kind, length, *_, block, _, _, _ = _CLUSTER.unpack(start)
        n = (block & ~_LONG) - 4
        place += _CLUSTER.size
        is_whole = kind == 0x1F43B675 and 0 < n <= _MOST_PICTURE and place + n <= size
        if not is_whole or length & ~_LONG != _CLUSTER.size - 12 + n:
            return
        yield Place(place, n)
        place += n
