"""The time base of a session: a line of text for each step, readable by any spreadsheet."""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Iterable
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from robsim._core import Intrinsics, PlaneMap
from robsim.base.checks import Floats
from robsim.base.files import open_file
from robsim.base.text import as_cell, cut, one_line, quoted
from robsim.trace.columns import GROUPS

_MOST_ROWS = 20_000_000
_MOST_LINE = 4096  # bytes
_MOST = 2**63  # of a whole number
_LONGEST_TIME = 1e15  # s

_NAN = math.nan


@dataclass(frozen=True, kw_only=True, slots=True)
class Row:
    """A step of a recorded run, but for its picture; NaN and None = not known.

    The times `t` of the step, `t_arrival` of its frame at this computer and `t_sent` of its input
    are in s. `u` (2,) is the sent input (V), `last_u` the received one since the last step, if it
    is another. `pose_measured` is x, y (work-area px), heading (rad). `interrupted`: the robot was
    stopped after the last step. `reason`: why it was not detected.
    """

    k: int
    t: float
    t_arrival: float = _NAN
    t_sent: float = _NAN
    u: Any = (_NAN, _NAN)
    last_u: Any = (_NAN, _NAN)
    pose_measured: Any = (_NAN, _NAN, _NAN)
    interrupted: bool = False
    reason: str = ""
    # Of the picture, by the writer: its number in the video, or why it is not in there; the
    # frame's own number, and its plane map where it is another than that of the set-up.
    video_frame: int | None = None
    left_out: str = ""
    frame_index: int | None = None
    plane_map: PlaneMap | None = field(default=None, compare=False)
    headings: int | None = None  # that the robot is drawn in, of a frame that knows it


# Columns of the arrays; the other fields are a column each.
_ARRAYS = {name: tuple(GROUPS[name].units) for name in ("u", "last_u", "pose_measured")}
_FIELDS = tuple(entry.name for entry in fields(Row))
_COLUMNS = tuple(column for name in _FIELDS for column in _ARRAYS.get(name, (name,)))
_COLUMNS_BY_FORMAT = {1: _COLUMNS[:-1], 2: _COLUMNS}


def _header(columns: tuple[str, ...]) -> bytes:
    return (",".join(columns) + "\n").encode()


HEADER = _header(_COLUMNS)


def line_of(row: Row) -> bytes:
    cells: list[str] = []
    for name in _FIELDS:
        value = getattr(row, name)
        cells += map(_cell, value) if name in _ARRAYS else [_cell(value)]
    return (",".join(cells) + "\n").encode()


def _cell(value: Any) -> str:
    if isinstance(value, str):
        text = one_line(value)[:200]
        return '"' + as_cell(text).replace('"', '""') + '"' if text else ""
    if isinstance(value, PlaneMap):
        return " ".join(map(repr, _numbers_of(value)))
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, bool):
        return str(int(value))
    if value is None or (isinstance(value, float) and not math.isfinite(value)):
        return ""
    return repr(value)


def read_rows(file: Path) -> tuple[list[Row], bool]:
    """Return the rows of a time base, and whether its last line is torn; else ValueError."""
    with open_file(file) as stream:
        head = stream.readline(_MOST_LINE)
        by_header = {_header(columns): columns for columns in _COLUMNS_BY_FORMAT.values()}
        if head in by_header:
            return _rows_below(by_header[head], stream, file)
    if any(header.startswith(head) for header in by_header):
        return [], bool(head)
    raise ValueError(f"{one_line(file)} is not the time base of a session, or damaged")


def _rows_below(columns: tuple[str, ...], stream: BinaryIO, file: Path) -> tuple[list[Row], bool]:
    rows: list[Row] = []
    for line in iter(lambda: stream.readline(_MOST_LINE + 2), b""):
        if not line.endswith(b"\n") and len(line) <= _MOST_LINE:
            return rows, True
        try:
            row = _row_of(line.removesuffix(b"\n"), columns)
            if rows and row.k != rows[-1].k + 1:
                raise ValueError(f"step {row.k} follows step {rows[-1].k}")
            if len(rows) == _MOST_ROWS:
                raise ValueError(f"a session must have at most {_MOST_ROWS} steps")
        except (ValueError, OverflowError, csv.Error) as error:
            raise ValueError(f"{one_line(file)}, line {len(rows) + 2}: {cut(error)}") from error
        rows.append(row)
    return rows, False


def _row_of(line: bytes, columns: tuple[str, ...]) -> Row:
    if len(line) > _MOST_LINE:
        raise ValueError(f"a line must have at most {_MOST_LINE} bytes")
    (cells,) = csv.reader([line.decode()], strict=True) if line else [[]]
    if len(cells) != len(columns):
        raise ValueError(f"there must be {len(columns)} columns, got {len(cells)}")
    texts = dict(zip(columns, cells, strict=True))
    values: dict[str, Any] = {name: texts[name] for name in ("reason", "left_out")}
    for name in ("t", "t_arrival", "t_sent"):
        values[name] = _time(name, texts[name])
    for name, parts in _ARRAYS.items():
        if any(texts[part] for part in parts):  # else the default, which all rows share
            values[name] = tuple(_float(part, texts[part]) for part in parts)
    for name in ("video_frame", "frame_index", "headings"):
        values[name] = _int(name, texts[name]) if texts.get(name) else None
    if values["headings"] == 0:
        raise ValueError("headings must be at least 1 or empty, got 0")
    if texts["interrupted"] not in ("0", "1"):
        raise ValueError(f"interrupted must be 0 or 1, got {quoted(texts['interrupted'])}")
    if texts["plane_map"]:
        values["plane_map"] = _plane_map(texts["plane_map"])
    if math.isnan(values["t"]):
        raise ValueError("a step must have a time t")
    return Row(k=_int("k", texts["k"]), interrupted=texts["interrupted"] == "1", **values)


def _float(name: str, text: str) -> float:
    if not text:
        return _NAN
    try:
        value = float(text)
    except ValueError:
        value = math.inf
    if not math.isfinite(value):
        raise ValueError(f"{name} must be a finite number or empty, got {quoted(text)}")
    return value


def _time(name: str, text: str) -> float:
    value = _float(name, text)
    if abs(value) > _LONGEST_TIME:
        raise ValueError(f"{name} must be at most {_LONGEST_TIME:g} s, got {quoted(text)}")
    return value


def _int(name: str, text: str) -> int:
    if not re.fullmatch("[0-9]{1,19}", text) or int(text) >= _MOST:
        raise ValueError(f"{name} must be a whole number of at least 0, got {quoted(text)}")
    return int(text)


def _numbers_of(plane_map: PlaneMap) -> list[float]:
    """Return the nine numbers of a homography, and those of the lens where there is one."""
    numbers: list[float] = plane_map.matrix.ravel().tolist()
    lens = plane_map.intrinsics
    if lens is not None:
        (fx, _, cx), (_, fy, cy), _ = lens.matrix.tolist()
        numbers += [fx, fy, cx, cy, *lens.distortion.tolist()]
    return numbers


def _plane_map(text: str) -> PlaneMap:
    numbers = [_float("plane_map", part) for part in text.split(" ")]
    if len(numbers) not in (9, 18):
        raise ValueError(f"plane_map must be 9 numbers, or 18 with a lens, got {len(numbers)}")
    lens = None
    if len(numbers) == 18:
        fx, fy, cx, cy, *distortion = numbers[9:]
        lens = Intrinsics(((fx, 0, cx), (0, fy, cy), (0, 0, 1)), distortion)
    return PlaneMap(np.reshape(numbers[:9], (3, 3)), lens)


def columns_of(rows: Iterable[Row], *names: str) -> dict[str, Floats]:
    """Return fields of rows as arrays (N,) or (N, width)."""
    rows = list(rows)
    shapes = {name: (len(rows), len(_ARRAYS[name])) if name in _ARRAYS else -1 for name in names}
    return {
        name: np.array([getattr(row, name) for row in rows], dtype=np.float64).reshape(shape)
        for name, shape in shapes.items()
    }


def with_frame(row: Row, number: int | None, left_out: str) -> Row:
    return replace(row, video_frame=number, left_out=left_out)
