"""`limits.json`: the limits of each test, and its reference's numbers in public runs."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from robsim.base.checks import as_float_array, check_text
from robsim.base.files import codec, read_text, write_whole
from robsim.base.files.reading import parse_json
from robsim.teach.errors import AssignmentError
from robsim.teach.tasks.marks.calibration import TaskCalibration
from robsim.teach.tasks.score import ScoreLimit

FILE = "limits.json"
FORMAT = 1
_MOST = 2**24  # bytes


@dataclass(frozen=True, kw_only=True)
class RecordedTest:
    """The record of a test in `limits.json`."""

    limits: Mapping[str, ScoreLimit] = field(default_factory=dict)  # by score
    #: The numbers of the reference in each run, by score; for users without the reference.
    reference: Mapping[str, tuple[float, ...]] = field(default_factory=dict)
    #: The source of the limits; None = written by hand, or unknown here.
    calibration: TaskCalibration | None = None
    provisional: str = ""  # a sentence; "" = the limits are exact


def read_limits(folder: Path) -> dict[str, RecordedTest]:
    """Return the records in the file of a folder, by test; empty without a file.

    The file is JSON: ``{"format": 1, "tests": {TEST: {"limits": {SCORE: {"full": ..., "zero": ...,
    "low": ..., "low_zero": ...}}, "provisional": "...", "reference": {SCORE: [...]}, "calibration":
    {...}}}}``. Other content raises AssignmentError.
    """
    try:
        text = read_text(folder / FILE, _MOST)
        return codec.read_table(text, _read, FILE, _MOST, parse_json)  # type: ignore[no-any-return]
    except FileNotFoundError:
        return {}
    except (OSError, ValueError) as error:
        raise AssignmentError(str(error), file=FILE) from None


def write_limits(folder: Path, made: Mapping[str, TaskCalibration]) -> None:
    """Write the limits of each test, and their source."""
    tests = {}
    for name, one in made.items():
        record = one.as_record()
        limits = {"limits": record["limits"], "provisional": one.why_provisional}
        tests[name] = limits | {"calibration": record}
    text = json.dumps({"format": FORMAT, "tests": tests}, indent=1, allow_nan=False)
    write_whole(folder / FILE, f"{text}\n".encode())


def _read(data: Any) -> dict[str, RecordedTest]:
    table = codec.as_table("the file", data)
    codec.check_format(table, FORMAT)
    return codec.named(_TEST).read("tests", table.get("tests", {}))  # type: ignore[no-any-return]


def _calibration(name: str, record: Any) -> TaskCalibration | None:
    return None if record is None else TaskCalibration.from_record(record)


def _numbers(name: str, value: Any) -> tuple[float, ...]:
    if not isinstance(value, list) or as_float_array(name, value).ndim != 1:
        raise TypeError(f"{name} must be a list of numbers, got {codec.in_words(value)}")
    return tuple(as_float_array(name, value).tolist())


_SCORE = codec.Table(ScoreLimit, dict.fromkeys(("full", "zero", "low", "low_zero"), ""))
_TEST = codec.Table(
    RecordedTest,
    {
        "limits": codec.named(_SCORE),
        "reference": codec.named(_numbers),
        "calibration": _calibration,
        "provisional": check_text,
    },
    ignores_others=True,
)
