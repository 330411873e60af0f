"""The steps of a session: their values, as JSON to the last bit."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np

from robsim._core import Estimate, PlaneMap
from robsim.base.checks import Floats, check_bool, check_float, check_int, check_text
from robsim.base.files import codec
from robsim.base.files.reading import parse_json
from robsim.base.text import one_line, quoted
from robsim.trace.columns import GROUPS
from robsim.vision.imaging.calibration_file import PLANE_MAP

MOST_ROWS = 20_000_000
MOST_LINE = 4096  # bytes
_MOST_VALUES = 400  # of a line, and signs of a text that look like them
_MOST_TEXT = 200  # characters

_NAN = math.nan


@dataclass(frozen=True, kw_only=True, slots=True)
class Row:
    """A step of a recorded run, without its picture; NaN and None = not known.

    The times `t` of the step, `t_arrival` of its frame at this computer and `t_sent` of its input
    are in s. `u` (2,) is the sent input (V), `last_u` the input received since the last step, if
    different. `pose_measured` is x, y (work-area px), heading (rad). `interrupted`: the robot was
    stopped after the last step. `reason`: why the robot was not detected.
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
    # Of the picture, by the writer: why it is missing, the number of its frame, its plane map
    # unless the set-up has the same.
    left_out: str = ""
    frame_index: int | None = None
    plane_map: PlaneMap | None = field(default=None, compare=False)
    headings: int | None = None  # that the robot is drawn in, of a frame that knows it
    # For the messages alone.
    covariance: Any = field(default=None, compare=False)  # (3, 3) of pose_measured
    estimate: Estimate | None = field(default=None, compare=False)


ARRAYS = {name: tuple(GROUPS[name].units) for name in ("u", "last_u", "pose_measured")}


def _array(name: str, value: Any) -> tuple[float, ...]:
    if not isinstance(value, list) or len(value) != len(ARRAYS[name]):
        raise ValueError(f"{name} must be {len(ARRAYS[name])} numbers, got {quoted(value)}")
    return tuple(_NAN if one is None else check_float(name, one) for one in value)


_WHOLE = partial(check_int, minimum=0, maximum=2**63 - 1)
_TIME = partial(check_float, unit="s", minimum=-1e15, maximum=1e15)
_STEP = codec.Table(
    Row,
    {
        **dict.fromkeys(("k", "frame_index"), _WHOLE),
        **dict.fromkeys(("t", "t_arrival", "t_sent"), _TIME),
        **dict.fromkeys(ARRAYS, _array),
        **dict.fromkeys(("reason", "left_out"), check_text),
        **{"interrupted": check_bool, "headings": partial(_WHOLE, minimum=1)},
        "plane_map": PLANE_MAP,
    },
    ignores_others=True,
)
KEYS = (*_STEP.keys,)


def row_of(table: Mapping[str, Any]) -> Row:
    """Return the step with these values, None = not known; an error names a wrong one."""
    given = {name: one for name, one in table.items() if one is not None}
    return _STEP.read("a step", given)  # type: ignore[no-any-return]


def row_of_json(line: bytes) -> Row:
    """Return the step of a line of JSON; else TypeError or ValueError."""
    if len(line) > MOST_LINE:
        raise ValueError(f"a step must have at most {MOST_LINE} bytes")
    return row_of(codec.as_table("a step", parse_json(line.decode(), _MOST_VALUES)))


def json_of(row: Row) -> bytes:
    """Return a step as a line of JSON, without unknown values."""
    values = {name: _plain(getattr(row, name)) for name in KEYS}
    given = {name: one for name, one in values.items() if one not in (None, "")}
    return json.dumps(given, allow_nan=False).encode()


def _plain(value: Any) -> Any:
    if isinstance(value, str):
        return one_line(value)[:_MOST_TEXT]
    if isinstance(value, PlaneMap):
        lens, plain = value.intrinsics, {"matrix": value.matrix.tolist()}
        parts = lens and {"matrix": lens.matrix.tolist(), "distortion": lens.distortion.tolist()}
        return plain | ({"intrinsics": parts} if parts else {})
    if isinstance(value, (tuple, list, np.ndarray)):
        numbers = [_plain(one) for one in value]
        return numbers if any(one is not None for one in numbers) else None
    if isinstance(value, np.generic):
        value = value.item()
    return None if isinstance(value, float) and not math.isfinite(value) else value


def columns_of(rows: Iterable[Row], *names: str) -> dict[str, Floats]:
    """Return fields of rows as arrays (N,) or (N, width)."""
    rows = list(rows)
    shapes = {name: (len(rows), len(ARRAYS[name])) if name in ARRAYS else -1 for name in names}
    return {
        name: np.array([getattr(row, name) for row in rows], dtype=np.float64).reshape(shape)
        for name, shape in shapes.items()
    }
