"""Calibration of a camera: its lens, its view of the floor, sheets to print."""

from robsim.lab.calibration.floor import calibrate_floor, calibrate_floor_by_sheets
from robsim.lab.calibration.floor_report import FloorCalibration, FloorPoint
from robsim.lab.calibration.grid import draw_grid, sheet_shifts
from robsim.lab.calibration.lens import calibrate_lens
from robsim.lab.calibration.lens_report import BoardPicture, LensCalibration
from robsim.lab.calibration.patterns.boards import Charuco, Chessboard
from robsim.lab.calibration.patterns.floor_sheet import FloorSheet, find_sheets
from robsim.lab.calibration.patterns.pattern import Corners
from robsim.lab.calibration.patterns.printing import save_sheet

__all__ = [
    "BoardPicture",
    "Charuco",
    "Chessboard",
    "Corners",
    "FloorCalibration",
    "FloorPoint",
    "FloorSheet",
    "LensCalibration",
    "calibrate_floor",
    "calibrate_floor_by_sheets",
    "calibrate_lens",
    "draw_grid",
    "find_sheets",
    "save_sheet",
    "sheet_shifts",
]
