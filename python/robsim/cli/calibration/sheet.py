"""The command ``robsim calibrate sheet``: a pattern to print."""

from __future__ import annotations

from pathlib import Path

from robsim.cli import errors
from robsim.cli.calibration.options import Board, Square, board_of, check_out

KINDS = "chessboard", "charuco", "floor"


def sheet(
    out: Path,
    kind: str = "chessboard",
    paper: str = "A4",
    board: Board = None,
    square: Square = None,
    sheet_number: int = 1,
    mark: float = 80.0,
) -> None:
    """Write a sheet to print, as PDF at true scale.

    Print the sheet at 100 %, not 'fit to page', and check that its line is 100 mm long. For a lens,
    use chessboard or charuco, and glue the sheet on a flat plate. A ChArUco board may extend beyond
    the picture. For the floor, use floor, and print several sheets with different numbers.

    --out FILE: The PDF file to write.
    --kind KIND: chessboard, charuco or floor.
    --paper SIZE: A4, A3, A2, A1, A0 or letter.
    --number N: Number of a floor sheet: 1 to 16.
    --mark MM: Side of a mark on a floor sheet in mm.

    Example: robsim calibrate sheet --kind floor --number 1 --out floor-1.pdf
    """
    from robsim.base.checks import check_choice
    from robsim.lab.calibration.patterns.floor_sheet import FloorSheet
    from robsim.lab.calibration.patterns.printing import save_sheet

    check_out(out, ".pdf")
    check_choice("--kind", kind, KINDS)
    if kind == "floor":
        if board or square:
            raise ValueError(
                "--board and --square are for boards; a floor sheet has --mark and --number"
            )
        save_sheet(out, FloorSheet(sheet_number, mark), paper=paper)
    else:
        if sheet_number != 1 or mark != 80:
            raise ValueError("--number and --mark are for floor sheets: add --kind floor")
        save_sheet(out, board_of(board, square, charuco=kind == "charuco"), paper=paper)
    errors.say(f"written: {out}")
    errors.print_note("print the sheet at 100 %, and check that its line is 100 mm long")
