"""The fit of a floor, its file, and its messages to browsers."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from robsim.base.text import one_line
from robsim.gui._link import lens_of, numbers
from robsim.gui.tools.floor.points import FEWEST, FloorDraft
from robsim.lab.calibration.floor import calibrate_floor
from robsim.lab.calibration.floor_report import FloorCalibration
from robsim.lab.calibration.grid import grid_step
from robsim.vision.imaging import images
from robsim.vision.imaging.calibration import Calibration
from robsim.vision.imaging.calibration_file import load_calibration

Size = tuple[int, int]


def fitted(
    draft: FloorDraft, lens: Calibration | None, size: Size, picture: images.Pixels | None = None
) -> FloorCalibration:
    """Return the calibration from the points with known places."""
    if len(draft.complete) < FEWEST:
        raise ValueError("; ".join(draft.problems()))
    return calibrate_floor(
        draft.pixels,
        draft.places,
        names=[str(one.number) for one in draft.complete],
        area=draft.area,
        mm_per_px=draft.mm_per_px,
        marker_height=draft.marker_height,
        lens=lens,
        size=size,
        picture=picture,
    )


def on_work_area(calibration: Calibration, draft: FloorDraft) -> Calibration:
    """Return a calibration with the work area and the height of a draft, of the same floor."""
    floor, scale = calibration.floor, calibration.mm_per_px
    if floor is None or scale is None:
        return calibration
    if (calibration.area, scale, calibration.marker_height) == (
        draft.area,
        draft.mm_per_px,
        draft.marker_height,
    ):
        return calibration
    ratio = scale / draft.mm_per_px
    matrix = np.diag([ratio, ratio, 1]) @ floor.matrix
    return replace(
        calibration,
        floor=type(floor)(matrix),
        area=draft.area,
        mm_per_px=draft.mm_per_px,
        marker_height=draft.marker_height,
    )


def grid_of(calibration: Calibration) -> dict[str, Any] | None:
    """Return the data for drawing the grid; None without a floor."""
    floor, area = calibration.floor, calibration.area
    if floor is None or area is None:
        return None
    scale = calibration.mm_per_px
    step = grid_step(calibration)
    high = calibration.plane_map.matrix if calibration.marker_height else None
    return {
        "size": [*calibration.size],
        "area": [*area],
        "scale": scale or 1.0,
        "unit": "mm" if scale else "px",
        "step": step,
        "map": floor.matrix.ravel().tolist(),
        "high": None if high is None else high.ravel().tolist(),
        "intrinsics": lens_of(floor),
    }


def fit_of(report: FloorCalibration) -> dict[str, Any]:
    """Return the quality of a calibration: figures, and each point with its mapped position."""
    floor, scale = report.calibration.floor, report.calibration.mm_per_px
    assert floor is not None
    assert scale is not None
    places = np.array([one.place for one in report.points])
    mapped = floor.to_pixel(places / scale)
    expected = numbers(report.expected_errors)
    return {
        "rms": report.rms,
        "rms_mm": report.rms_mm,
        "worst": report.worst.name,
        "worst_px": report.worst.px,
        "worst_mm": report.worst.mm,
        "count": sum(one.is_used for one in report.points),
        "expected": None if expected is None else max(expected),
        "verdict": report.verdict,
        "points": [
            {
                "name": one.name,
                "at": [*one.pixel],
                "to": numbers(to) or [*one.pixel],
                "mm": one.mm,
                "px": one.px,
                "used": one.is_used,
            }
            for one, to in zip(report.points, mapped, strict=True)
        ],
    }


def replaced(file: Path, calibration: Calibration, *, is_known: bool) -> Calibration | None:
    """Return the calibration in a file before overwriting; None = no such file."""
    if not file.exists():
        return None
    name = one_line(file)
    try:
        there = load_calibration(file)
    except ValueError as error:
        raise ValueError(f"{name} is not a calibration: save under another name") from error
    if there.intrinsics is not None and calibration.intrinsics is None:
        raise ValueError(
            f"{name} has a lens, but this floor was calibrated without a lens: load {name}, or "
            "save under another name"
        )
    if not is_known:
        raise ValueError(
            f"{name} already exists, but is not loaded here: load or remove {name}, or save under "
            "another name"
        )
    return there
