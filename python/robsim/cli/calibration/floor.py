"""The command ``robsim calibrate floor``: a camera's pose above the floor."""

from __future__ import annotations

import csv
import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from robsim.base.checks import check_mm_per_px
from robsim.base.text import quoted
from robsim.cli import errors
from robsim.cli.calibration.options import Mark, check_out, height_of, pictures_of, report_and_save
from robsim.cli.shared import Json
from robsim.cli.text import parse_points, parse_size

if TYPE_CHECKING:
    from robsim.lab.calibration.floor_report import FloorCalibration

#: Names, pixels and positions of marks.
Marks = tuple[list[str] | None, Sequence[Sequence[float]], Sequence[Sequence[float]]]
_COLUMNS = "name", "u", "v", "x", "y"


def floor(
    pictures: list[Path] | None = None,
    area: str | None = None,
    scale: float | None = None,
    marker_height: str = "0mm",
    calibration: Path | None = None,
    mark: Mark = 80.0,
    places: list[str] | None = None,
    marks: Path | None = None,
    pixels: str | None = None,
    positions: str | None = None,
    out: Path | None = None,
    as_json: Json = False,
) -> None:
    """Calibrate a camera's pose above the floor.

    The easy way needs printed sheets (robsim calibrate sheet --kind floor). Spread them over the
    whole area, and take a picture; no measurement is needed. --place sets the place of a sheet's
    cross on the area. By default, the sheet with the lowest number is the middle of the area, and x
    points to the right of this sheet. The other way needs marks at measured places: give --marks,
    or --pixels and --positions. robsim checks six or more marks (with a lens, five) against each
    other. The exit status is 1 if the result is bad.

    PICTURES: Pictures of the floor, folders of pictures, or videos; the camera stands still.
    --area WxH: Size of the work area in px.
    --scale MM: Length on the floor of 1 px of the work area, in mm.
    --marker-height LENGTH: Height of the robot's markers above the floor, such as 80mm. Requires a
        lens.
    --calibration FILE: The lens calibration from robsim calibrate lens. Default: no lens
        distortion.
    --place N:X,Y: Place of the cross of sheet N in mm from the top left corner of the area. Can be
        repeated.
    --marks FILE: CSV file of marks with the columns name, u, v (px), x, y (mm), separated by
        commas, semicolons or tabs. Marks with the same name are averaged.
    --pixels POINTS: Marks in the picture in px, such as '12,8 630,11 ...'.
    --positions POINTS: The same marks on the floor, in mm from the top left corner of the area.
    --out FILE: The calibration to write. Default: the file of --calibration, or camera.toml.

    Example: robsim calibrate floor floor.png --calibration camera.toml --area 1200x1200 --scale 2
    --marker-height 80mm
    """
    from robsim.vision.imaging.calibration_file import load_calibration

    file = out or calibration or Path("camera.toml")
    check_out(file, ".toml", "--out" if out else "--calibration")
    if area is None or scale is None:
        missing = [name for name, one in (("--area", area), ("--scale", scale)) if one is None]
        raise ValueError(
            f"{' and '.join(missing)} {'is' if len(missing) == 1 else 'are'} missing: give the "
            "size of the work area in px, and the length of a px on the floor in mm, such as "
            "--area 1200x1200 --scale 2"
        )
    check_mm_per_px(scale, "--scale")
    height = height_of("--marker-height", marker_height)
    if height and calibration is None:
        raise ValueError(
            "--marker-height needs --calibration, a file from robsim calibrate lens, because the "
            "shift in the picture depends on the lens. Without a lens, measure marks at the "
            "height of the markers"
        )
    options = {
        "area": parse_size("--area", area),
        "mm_per_px": scale,
        "marker_height": height,
        "lens": None if calibration is None else load_calibration(calibration),
    }
    report = _calibrated(
        pictures or [], _given_marks(marks, pixels, positions), mark, places or [], options
    )
    report_and_save(report, file, as_json=as_json)


def _calibrated(
    sources: list[Path],
    marks: Marks | None,
    mark: float,
    places: list[str],
    options: dict[str, Any],
) -> FloorCalibration:
    from robsim.lab.calibration.floor import calibrate_floor, calibrate_floor_by_sheets

    if marks is None:
        if not sources:
            raise ValueError("give a picture of floor sheets, or measured marks with --marks")
        images = [image for _, image in pictures_of(sources)]
        where = dict(_place(text) for text in places)
        return calibrate_floor_by_sheets(images, mark=mark, places=where or None, **options)
    if places:
        raise ValueError("--place is for floor sheets and cannot be used with marks")
    if not sources and options["lens"] is None:
        raise ValueError("without --calibration, also give a picture: robsim needs its size")
    image = next(pictures_of(sources))[1] if sources else None
    names, seen, where_they_are = marks
    try:
        return calibrate_floor(seen, where_they_are, names=names, picture=image, **options)
    except ImportError as error:
        errors.print_note(f"floor sheets are not stored: {error}")
    size = None if image is None else (image.shape[1], image.shape[0])
    return calibrate_floor(seen, where_they_are, names=names, size=size, **options)


def _place(text: str) -> tuple[int, tuple[float, float]]:
    sheet, _, place = text.partition(":")
    try:
        x, y = map(float, place.split(","))
        return int(sheet), (x, y)
    except ValueError:
        raise ValueError(
            "--place must be the number of a floor sheet and its position in mm, such as "
            f"1:600,400, got {quoted(text)}"
        ) from None


def _given_marks(marks: Path | None, pixels: str | None, positions: str | None) -> Marks | None:
    """Return names, pixels and positions; None if no marks are given."""
    if marks is not None:
        if pixels or positions:
            raise ValueError("give either --marks, or --pixels and --positions, not both")
        return _read_marks(marks)
    if (pixels is None) != (positions is None):
        raise ValueError("--pixels and --positions belong together: give both or neither")
    seen = parse_points("--pixels", pixels, minimum=4)
    places = parse_points("--positions", positions, minimum=4)
    return None if seen is None or places is None else (None, seen, places)


def _read_marks(file: Path) -> Marks:
    from robsim.base.files import read_text

    lines = [line for line in read_text(file).splitlines() if line.strip()]
    # a semicolon before a comma, which then is that of decimals
    separators = (one for one in "\t;" if lines and lines[0].count(one) >= len(_COLUMNS) - 1)
    separator = next(separators, ",")
    rows = list(csv.reader(lines, delimiter=separator))
    rows = [[cell.strip() for cell in row] for row in rows if any(map(str.strip, row))]
    if rows and tuple(map(str.lower, rows[0])) == _COLUMNS:
        rows = rows[1:]
    names, seen, places = [], [], []
    for number_of_row, row in enumerate(rows, start=1):
        try:
            name, u, v, x, y = row
            numbers = [float(cell.replace(",", ".")) for cell in (u, v, x, y)]
            if not all(map(math.isfinite, numbers)):
                raise ValueError
        except ValueError:
            raise ValueError(
                f"{file}: mark {number_of_row} must be name, u, v, x, y, such as corner,12,8,0,0, "
                f"got {quoted(separator.join(row))}. Separators are commas, semicolons or tabs; "
                "numbers between commas need a decimal point"
            ) from None
        names.append(name)
        seen.append(numbers[:2])
        places.append(numbers[2:])
    if not names:
        raise ValueError(f"{file} has no marks; a mark is a line such as corner,12,8,0,0")
    return names, seen, places
