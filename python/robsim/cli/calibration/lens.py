"""The command ``robsim calibrate lens``: a lens from pictures of a board, or of a live camera."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from robsim.base.checks import check_int
from robsim.cli import errors
from robsim.cli.calibration.options import (
    Board,
    Square,
    board_of,
    check_out,
    pictures_of,
    report_and_save,
)
from robsim.cli.shared import Json
from robsim.lab.calibration.patterns.boards import Charuco, Chessboard
from robsim.lab.calibration.taking import BoardTaker


def lens(
    pictures: list[Path] | None = None,
    board: Board = None,
    square: Square = None,
    charuco: bool = False,
    camera: str | None = None,
    count: int = 15,
    keep: Path | None = None,
    out: Path = Path("camera.toml"),
    as_json: Json = False,
) -> None:
    """Calibrate a lens with pictures of a printed board.

    Take ten to twenty pictures, in the size that you will use for the robot. For each picture, tilt
    the board by 20 to 45 degrees in another direction, and hold it still. Together, the pictures
    must show the board in all corners of the picture. With --camera, robsim takes a picture
    whenever you hold the board still at a new place. Photos are read as stored by the sensor,
    without rotation. A ChArUco board reveals mirrored pictures, but a chessboard does not. The exit
    status is 1 if the result is bad.

    PICTURES: Pictures, folders of pictures, or videos.
    --charuco: The board is a ChArUco board.
    --camera SOURCE: Number or address of a live camera, which takes the pictures.
    --count N: Number of pictures to take with --camera.
    --keep FOLDER: Folder for the pictures of --camera.
    --out FILE: The calibration to write.

    Example: robsim calibrate lens pictures/ --board 9x6 --square 25 --out camera.toml
    """
    from robsim.lab.calibration.lens import calibrate_lens

    check_out(out, ".toml")
    pattern = board_of(board, square, charuco=charuco)
    if bool(pictures) == (camera is not None):
        raise ValueError("give either pictures or --camera")
    if camera is not None:
        named = taken_pictures(camera, pattern, count, keep)
    else:
        named = list(pictures_of(pictures or []))
    names, images = zip(*named, strict=True) if named else ((), ())
    report = calibrate_lens(images, pattern, names=names)
    if _has_floor(out):
        errors.print_note(
            f"the floor in {out} depended on the replaced lens: calibrate the floor again "
            "(robsim calibrate floor)"
        )
    report_and_save(report, out, as_json=as_json)


def _has_floor(file: Path) -> bool:
    """Return whether a file, if it exists, has a calibration of a floor."""
    from robsim.vision.imaging.calibration_file import load_calibration

    try:
        return load_calibration(file).floor is not None
    except (OSError, ValueError):
        return False


_PATIENCE = 60.0  # s without a new picture


def taken_pictures(
    camera: str, board: Chessboard | Charuco, count: int, keep: Path | None
) -> list[tuple[str, Any]]:
    """Return names and pictures from a live camera, and write them to a folder."""
    import time

    from robsim.cli.sources import _source
    from robsim.lab.cameras.camera import Camera
    from robsim.vision.imaging.images import save_image

    check_int("--count", count, minimum=4, maximum=200)
    if keep is not None:
        keep.mkdir(parents=True, exist_ok=True)
    taken: list[tuple[str, Any]] = []
    with Camera(_source(camera)) as device:
        taker = BoardTaker(board, device.size)
        errors.print_note(f"hold the board still in front of the camera: {count} times")
        since = time.monotonic()
        while len(taken) < count:
            if time.monotonic() - since > _PATIENCE:
                raise TimeoutError(
                    f"the board was not held still at a new place for {_PATIENCE:g} s: "
                    f"{len(taken)} of {count} pictures were taken"
                )
            try:
                frame = device.read()
            except EOFError:
                break
            if not taker.takes(frame.image):
                continue
            since = time.monotonic()
            name = f"{len(taken) + 1:02d}.png"
            taken.append((name, frame.image))
            if keep is not None:
                save_image(keep / name, frame.image)
            parts = ", ".join(taker.empty_parts)
            where = f": still no board at the {parts}" if parts else ": tilt the board another way"
            errors.print_note(f"{len(taken)} of {count}{where if len(taken) < count else ''}")
    return taken
