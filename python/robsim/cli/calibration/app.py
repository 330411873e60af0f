"""The commands ``robsim calibrate``."""

from __future__ import annotations

from robsim.cli.calibration import check, floor, lens, sheet
from robsim.cli.command import command, command_group

HELP = (
    "In this order: print a board (sheet), hold it in front of the camera (lens), lay floor sheets "
    "or measure marks (floor), look at the grid (check). The result is one file, for robsim live, "
    "robsim track and robsim.Camera. Lock zoom and focus first. Do not move the camera after the "
    "calibration of the floor."
)
app = command_group("Start with: robsim calibrate sheet --kind chessboard --out board.pdf")
for one in (sheet.sheet, lens.lens, floor.floor, check.check):
    command(app)(one)
