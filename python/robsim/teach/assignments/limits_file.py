"""`limits.json`: the limits of each test, and what its reference comes to in public runs."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NoReturn

from robsim.base.checks import check_float
from robsim.base.spelling import check_names
from robsim.base.text import quoted
from robsim.teach.errors import AssignmentError
from robsim.teach.tasks.marks.calibration import TaskCalibration
from robsim.teach.tasks.score import ScoreLimit

FILE = "limits.json"
FORMAT = 1
_MOST = 2**24  # bytes
_LIMIT = ("full", "zero", "low", "low_zero")


@dataclass(frozen=True, kw_only=True)
class RecordedTest:
    """What `limits.json` has of a test.

    Attributes
    ----------
    limits : mapping of str to ScoreLimit
        By score.
    reference : mapping of str to tuple of float
        The numbers of the reference in each run, by score; for those who do not have it.
    calibration : TaskCalibration or None
        What the limits rest on; None = they were written by hand, or it is not known here.
    """

    limits: Mapping[str, ScoreLimit] = field(default_factory=dict)
    reference: Mapping[str, tuple[float, ...]] = field(default_factory=dict)
    calibration: TaskCalibration | None = None


def read_limits(folder: Path) -> dict[str, RecordedTest]:
    """Return what the file of a folder has, by test; nothing, where there is none.

    The file is JSON: ``{"format": 1, "tests": {TEST: {"limits": {SCORE: {"full": ..., "zero": ...,
    "low": ..., "low_zero": ...}}, "reference": {SCORE: [...]}, "calibration": {...}}}}``.

    Raises
    ------
    AssignmentError
        If it is something else.
    """
    try:
        content = (folder / FILE).read_bytes()
    except FileNotFoundError:
        return {}
    except OSError as error:
        _refuse(f"it cannot be read: {error.strerror}")
    try:
        data = json.loads(content[: _MOST + 1])
    except (ValueError, RecursionError) as error:
        _refuse(f"it is not JSON: {error}")
    if not isinstance(data, dict) or data.get("format") != FORMAT:
        _refuse(f"it is not of format {FORMAT}")
    return {name: _test(name, values) for name, values in _table("tests", data, "tests").items()}


def _test(name: str, values: Any) -> RecordedTest:
    if not isinstance(values, dict):
        _refuse(f"{name} must be an object, got {quoted(values)}")
    limits = _table(name, values, "limits")
    reference = _table(name, values, "reference")
    return RecordedTest(
        limits={score: _limit(f"{name}, {score}", one) for score, one in limits.items()},
        reference={score: _numbers(f"{name}, {score}", one) for score, one in reference.items()},
        calibration=_calibration(name, values.get("calibration")),
    )


def _calibration(name: str, record: Any) -> TaskCalibration | None:
    try:
        return None if record is None else TaskCalibration.from_record(record)
    except ValueError as error:
        _refuse(f"{name}: {error}")


def _table(place: str, values: Mapping[str, Any], key: str) -> Mapping[str, Any]:
    value = values.get(key, {})
    return value if isinstance(value, dict) else _refuse(f"{place}: {key} must be an object")


def _limit(place: str, values: Any) -> ScoreLimit:
    if not isinstance(values, dict) or not {"full", "zero"} <= values.keys():
        _refuse(f"{place} must have full and zero, got {quoted(values)}")
    check_names(f"{FILE}: {place} has no", values, _LIMIT, lambda text: AssignmentError(text))
    given = {key: value for key, value in values.items() if value is not None}
    try:
        numbers = {
            key: check_float(key, value, exclusive_minimum=0) for key, value in given.items()
        }
    except (TypeError, ValueError) as error:
        _refuse(f"{place}: {error}")
    return ScoreLimit(**numbers)


def _numbers(place: str, values: Any) -> tuple[float, ...]:
    if not isinstance(values, list) or not all(
        one is None or isinstance(one, (int, float)) for one in values
    ):
        _refuse(f"{place} must be numbers, got {quoted(values)}")
    return tuple(math.nan if one is None else float(one) for one in values)


def _refuse(message: str) -> NoReturn:
    raise AssignmentError(f"{FILE}: {message}", file=FILE) from None
