"""Calibration of a camera: its lens, where it looks at the floor from, sheets to print."""

from robsim._base.public import present as _present
from robsim.calibration._floor import calibrate_floor, calibrate_floor_by_sheets
from robsim.calibration._floor_report import FloorCalibration, FloorPoint
from robsim.calibration._grid import draw_grid
from robsim.calibration._lens import calibrate_lens
from robsim.calibration._lens_report import BoardPicture, LensCalibration
from robsim.calibration._patterns.boards import Charuco, Chessboard
from robsim.calibration._patterns.floor_sheet import FloorSheet, find_sheets
from robsim.calibration._patterns.pattern import Corners
from robsim.calibration._patterns.printing import save_sheet
from robsim.calibration._shifts import sheet_shifts

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

_present(globals())
