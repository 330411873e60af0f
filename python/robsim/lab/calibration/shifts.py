"""Whether floor sheets lie where a calibration saw them, or the camera was moved."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping

import numpy as np

from robsim._core import Frame
from robsim.base.text import listed, quoted
from robsim.lab.calibration._pictures import pixels_of
from robsim.lab.calibration.patterns.floor_sheet import FloorSheet, find_marks, sheet_of
from robsim.lab.calibration.patterns.pattern import Corners
from robsim.vision.imaging.calibration import Calibration
from robsim.vision.imaging.frames import frame_size
from robsim.vision.imaging.images import Pixels

#: Shifts of a sheet that are good, and poor (px of the frame).
SHIFTS = (1.0, 3.0)


def mark_middles(sheets: Mapping[int, Corners], mark: float) -> dict[int, tuple[float, float]]:
    """Return where the middles of the marks of sheets are in a picture (px), by their numbers."""
    middles = {}
    for sheet, seen in sheets.items():
        for number, positions in FloorSheet(sheet, mark).corners().items():
            is_its = (seen.positions[:, None] == positions).all(axis=2).any(axis=1)
            if is_its.sum() == len(positions):
                u, v = seen.pixels[is_its].mean(axis=0).tolist()
                middles[number] = (u, v)
    return middles


def sheet_shifts(image: Pixels | Frame, calibration: Calibration) -> dict[int, float]:
    """Return by how far floor sheets lie from where they were when a camera was calibrated.

    A sheet that stays where it lies, beside where the robot drives, shows whether the camera was
    moved, turned or zoomed since.

    Parameters
    ----------
    image : Frame or array (H, W, 3) of uint8
        RGB.
    calibration : Calibration
        That of the camera.

    Returns
    -------
    dict of int to float
        The median distance of its marks from where they were (px of the frame), by the number of
        the sheet; of those sheets that the picture shows, and that the calibration was made with.

    Raises
    ------
    ImportError
        If OpenCV is not installed.
    TypeError, ValueError
        If an argument has another type, or the picture another size.
    """
    if not isinstance(calibration, Calibration):
        raise TypeError(f"calibration must be a Calibration, got {quoted(calibration)}")
    pixels = pixels_of("image", image)
    calibration.check_frames(frame_size(pixels))
    off: dict[int, float] = {}  # by the mark; of two of one number the nearer one counts
    for number, corners in find_marks(pixels) if calibration.marks else ():
        if number in calibration.marks:
            distance = np.linalg.norm(corners.mean(axis=0) - calibration.marks[number])
            off[number] = min(float(distance), off.get(number, np.inf))
    sheets = sorted({sheet_of(number) for number in off})
    return {
        sheet: float(np.median([off[number] for number in off if sheet_of(number) == sheet]))
        for sheet in sheets
    }


def single_marks(image: Pixels) -> dict[int, tuple[float, float]]:
    """Return the middles of the marks that a picture shows once (px), by their numbers."""
    found = find_marks(image)
    counts = Counter(number for number, _ in found)
    middles = {}
    for number, corners in found:
        if counts[number] == 1:
            u, v = corners.mean(axis=0).tolist()
            middles[number] = (u, v)
    return middles


def remedy_of_shifts(shifts: Mapping[int, float]) -> str:
    """Return why sheets may lie elsewhere, and what to do; empty if they lie where they did."""
    moved = [sheet for sheet, shift in shifts.items() if shift > SHIFTS[0]]
    if not moved:
        return ""
    if len(moved) == 1:
        said = f"floor sheet {moved[0]} is not where the calibration saw it"
    else:
        said = f"floor sheets {listed(map(str, moved))} are not where the calibration saw them"
    if len(moved) < len(shifts):
        return (
            f"{said}, the others are: lay back what was moved; or, if it was the camera, calibrate "
            "the floor again (robsim calibrate floor)"
        )
    return (
        f"{said}: was the camera moved, turned or zoomed since? Then calibrate the floor again "
        "(robsim calibrate floor)"
    )
