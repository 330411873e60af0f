"""The command ``robsim calibrate lens``: a lens from pictures of a board."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from robsim.cli import errors
from robsim.cli.calibration.options import (
    Board,
    Square,
    board_of,
    check_out,
    pictures_of,
    report_and_save,
)
from robsim.cli.option import argument, integer_option, option, switch
from robsim.cli.shared import Json

EXAMPLE = "Example: robsim calibrate lens pictures/ --board 9x6 --square 25 --out camera.toml"
HELP = (
    "Calibrate a lens by pictures of a printed board.\n\n"
    "Ten to twenty pictures, of the size that the robot will be seen in: hold the board still, "
    "tilted by 20 to 45 degrees, each time in another direction, and bring it into all corners of "
    "the picture. Pictures are files, folders and videos; or, with --camera, they are taken by "
    "themselves whenever the board stands still somewhere new. The exit status is 1 if the result "
    "is bad."
)


def lens(
    pictures: Annotated[
        list[Path] | None, argument("PICTURES", "Pictures, folders of them, or videos.")
    ] = None,
    board: Board = None,
    square: Square = None,
    charuco: Annotated[bool, switch("--charuco", "The board is a ChArUco board.")] = False,
    camera: Annotated[
        str | None,
        option(
            "--camera", "SOURCE", "Take the pictures from a live camera: its number or its address."
        ),
    ] = None,
    count: Annotated[int, integer_option("--count", "N", "How many pictures to take by it.")] = 15,
    keep: Annotated[
        Path | None, option("--keep", "FOLDER", "Folder for the pictures that it takes.")
    ] = None,
    out: Annotated[Path, option("--out", "FILE", "The calibration to write.")] = Path(
        "camera.toml"
    ),
    as_json: Json = False,
) -> None:
    """Calibrate a lens by pictures of a printed board."""
    from robsim.cli.calibration.taking import taken_pictures
    from robsim.lab.calibration.lens import calibrate_lens

    with errors.report_errors():
        check_out(out, ".toml")
        pattern = board_of(board, square, charuco=charuco)
        if bool(pictures) == (camera is not None):
            raise ValueError("give either pictures, or --camera to take them")
        if camera is not None:
            named = taken_pictures(camera, pattern, count, keep)
        else:
            named = list(pictures_of(pictures or []))
        names, images = zip(*named, strict=True) if named else ((), ())
        report = calibrate_lens(images, pattern, names=names)
        if _has_floor(out):
            errors.print_note(
                f"{out} had a floor, by the lens that is replaced: calibrate it again "
                "(robsim calibrate floor)"
            )
        report_and_save(report, report.calibration, out, as_json=as_json)


def _has_floor(file: Path) -> bool:
    """Return whether there is a calibration of a floor in a file, if there is one."""
    from robsim.vision.imaging.calibration_file import load_calibration

    try:
        return load_calibration(file).floor is not None
    except (OSError, ValueError):
        return False
