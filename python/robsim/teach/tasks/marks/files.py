"""Calibrations in files, and those that ship with robsim: of each kind of task, as it is."""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import cache
from pathlib import Path

from robsim.base.files import write_whole
from robsim.base.text import one_line
from robsim.teach.tasks.marks.calibration import TaskCalibration

SHIPPED = Path(__file__).parents[1] / "limits.json"


def read_calibrations(file: Path) -> dict[str, TaskCalibration]:
    """Return what `write_calibrations` wrote.

    Raises
    ------
    OSError
        If it cannot be read.
    ValueError
        If it is something else; the message names the file.
    """
    try:
        records = json.loads(file.read_text(encoding="utf-8"))
        if not isinstance(records, dict):
            raise ValueError("it must have names and calibrations")
        return {name: TaskCalibration.from_record(record) for name, record in records.items()}
    except (ValueError, RecursionError) as error:
        raise ValueError(f"{one_line(file)} has no calibrations: {error}") from None


def write_calibrations(file: Path, calibrations: Mapping[str, TaskCalibration]) -> None:
    """Write calibrations by name, as JSON; readers never get half of the file.

    Raises
    ------
    OSError
        If it cannot be written.
    """
    records = {name: calibration.as_record() for name, calibration in calibrations.items()}
    write_whole(file, (json.dumps(records, indent=1, allow_nan=False) + "\n").encode())


@cache
def shipped_calibrations() -> Mapping[str, TaskCalibration]:
    return read_calibrations(SHIPPED)
