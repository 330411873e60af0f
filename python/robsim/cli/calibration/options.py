"""Options that the commands of a calibration share, and their parsers."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from robsim.base.text import quoted
from robsim.base.warn import warn_user
from robsim.cli.text import about

if TYPE_CHECKING:
    from robsim.lab.calibration.floor_report import FloorCalibration
    from robsim.lab.calibration.lens_report import LensCalibration
    from robsim.lab.calibration.patterns.boards import Charuco, Chessboard

_MOST_OF_VIDEO = 40  # pictures; neighbours in a video show the same

Board = Annotated[
    str | None,
    "--board COLUMNSxROWS: Inner corners of the chessboard, or squares of the ChArUco board. "
    "Default: 9x6.",
]
Square = Annotated[
    float | None,
    "--square MM: Side of a printed square in mm: measure the print. Default: 25, or 28 for a "
    "ChArUco board.",
]
Mark = Annotated[
    float, "--mark MM: Side of a printed mark on the floor sheets in mm: measure the print."
]


def board_of(board: str | None, square: float | None, *, charuco: bool) -> Chessboard | Charuco:
    """Return the board described by --board, --square and --charuco."""
    from robsim.lab.calibration.patterns.boards import Charuco, Chessboard

    kind = Charuco if charuco else Chessboard
    options: dict[str, Any] = {} if square is None else {"square": square}
    if board is None:
        return kind(**options)
    if not (found := re.fullmatch(r"(\d{1,3})[xX](\d{1,3})", board)):
        raise ValueError(f"--board must be columns x rows such as 9x6, got {quoted(board)}")
    columns, rows = map(int, found.groups())
    with about("--board"):
        return kind(columns, rows, **options)


def height_of(option: str, text: str) -> float:
    """Return a length in mm from text such as 80, 80mm or 8cm."""
    found = re.fullmatch(r"(\d+(?:\.\d*)?)\s*(mm|cm|m)?", text.strip())
    if not found:
        raise ValueError(f"{option} must be a length such as 80mm or 8cm, got {quoted(text)}")
    return float(found[1]) * {"m": 1000.0, "cm": 10.0, "mm": 1.0, None: 1.0}[found[2]]


def pictures_of(sources: list[Path], most: int = _MOST_OF_VIDEO) -> Iterator[tuple[str, Any]]:
    """Yield names and RGB pictures of image files, folders and videos.

    A video yields `most` frames at most, evenly spread. Unreadable pictures, and those of another
    size than the first, are skipped with a warning.
    """
    from robsim.vision.imaging.images import check_same_size, frame_size, image_suffixes, load_image
    from robsim.vision.imaging.recordings import Recording, images_in, left_out

    images: list[Path] = []
    for source in sources:
        if source.is_dir():
            images += images_in(source)
        elif source.suffix.lower() in image_suffixes():
            images.append(source)
        else:
            recording = Recording(source)
            every = max(recording.count // most, 1)
            for frame in recording:
                if frame.index % every == 0:
                    yield f"{source.name} frame {frame.index}", frame.image
    size, unread = None, []
    for file in images:
        try:
            image = load_image(file)
            check_same_size(file.name, frame_size(image), size or frame_size(image))
        except ValueError as error:
            unread.append(error)
        else:
            size = frame_size(image)
            yield file.name, image
    if unread and size is None:
        raise unread[0]
    if told := left_out(unread, len(images)):
        warn_user(told)


def report_and_save(
    report: LensCalibration | FloorCalibration, out: Path, *, as_json: bool
) -> None:
    """Print a report and write its calibration; exit with 1 if it is bad."""
    from robsim.cli import errors
    from robsim.vision.imaging.calibration_file import save_calibration

    save_calibration(out, report.calibration)
    errors.show(report.to_json() if as_json else report)
    if not as_json:
        errors.say(f"written: {out}")
    if report.verdict == "bad":
        raise typer.Exit(1)


def check_out(out: Path, suffix: str, option: str = "--out") -> None:
    """Raise an error of the output file before the work, not after it."""
    from robsim.cli.results import check_folder

    if out.suffix.lower() != suffix:
        raise ValueError(f"{option} must be a file name with {suffix}, got {quoted(str(out))}")
    if not out.absolute().parent.is_dir():
        raise FileNotFoundError(f"{option} {out.name}: the folder {out.parent} does not exist")
    check_folder(out.absolute().parent)
