"""A check of a calibration against a picture: its grid, and the positions of floor sheets."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping
from typing import Any

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from robsim._core import Frame, PlaneMap
from robsim.base.checks import Floats, check_float, check_kind, check_size
from robsim.base.text import listed
from robsim.base.values import runs_of
from robsim.lab.calibration.patterns.floor_sheet import FloorSheet, find_marks, sheet_of
from robsim.lab.calibration.patterns.pattern import Corners
from robsim.vision.imaging.calibration import Calibration
from robsim.vision.imaging.images import Pixels, frame_pixels, frame_size

_FLOOR, _HIGH = (255, 214, 10), (0, 229, 255)
_LINES = 8  # about as many across the longer side of the area
_ROUND = (1, 2, 2.5, 5, 10)
_PIECES = 96  # of a line: it is curved by the lens
_SMOOTH = 3  # drawn that much larger, and reduced


def draw_grid(
    image: Pixels | Frame, calibration: Calibration, *, step: float | None = None
) -> Pixels:
    """Return a picture with the grid of the work area drawn on it.

    Yellow lines with numbers lie on the floor; blue lines, if any, are at the markers' height.
    Tiles and marks on the floor must match the yellow lines.

    Parameters
    ----------
    image : Frame or array (H, W, 3) of uint8
        RGB picture of the calibrated camera.
    calibration : Calibration
        A calibration with a floor.
    step : float, optional
        Distance of the lines (mm; work-area px if the scale is not known). Default: a round
        number that gives about eight lines.

    Returns
    -------
    array (H, W, 3) of uint8
        The picture.

    Raises
    ------
    TypeError, ValueError
        If an argument has the wrong type, or the calibration has no floor or another frame size.

    Examples
    --------
    >>> floor = robsim.vision.PlaneMap(np.diag([2.0, 2.0, 1.0]))
    >>> calibration = robsim.vision.Calibration(size=(640, 480), floor=floor, area=(1279, 959))
    >>> picture = np.zeros((480, 640, 3), np.uint8)
    >>> drawn = robsim.lab.draw_grid(picture, calibration, step=200)
    >>> bool(drawn.any())
    True
    """
    pixels = frame_pixels("image", image)
    check_kind("calibration", calibration, Calibration)
    step = None if step is None else check_float("step", step, "mm", exclusive_minimum=0)
    calibration.check_frames(check_size("size of image", frame_size(pixels)))
    above = calibration.plane_map  # raises for a calibration without a floor
    floor, area = calibration.floor, calibration.area
    assert floor is not None
    assert area is not None
    scale = calibration.mm_per_px or 1.0
    extent = (area[0] * scale, area[1] * scale)
    largest = max(extent)
    step = grid_step(calibration) if step is None else step
    step = check_float("step", step, "mm", minimum=largest / 200, maximum=largest)
    drawing = _Drawing(pixels)
    if calibration.marker_height:
        drawing.grid(above, extent, step, scale, _HIGH, width=1)
    drawing.grid(floor, extent, step, scale, _FLOOR, width=2)
    drawing.numbers(floor, extent, step, scale)
    drawing.legend(calibration, step)
    return drawing.finished()


def grid_step(calibration: Calibration) -> float:
    """Return a round distance of lines, about eight across the area (mm, or px)."""
    assert calibration.area is not None
    about = max(calibration.area) * (calibration.mm_per_px or 1.0) / _LINES
    power = 10.0 ** math.floor(math.log10(about))
    return min((power * one for one in _ROUND), key=lambda one: abs(math.log(one / about)))


class _Drawing:
    """Lines on a transparent sheet, laid over a darkened picture."""

    def __init__(self, pixels: Pixels) -> None:
        self._below = Image.fromarray((pixels * 0.8).astype(np.uint8))
        self._size = self._below.size
        self._sheet = Image.new("RGBA", (self._size[0] * _SMOOTH, self._size[1] * _SMOOTH))
        self._draw = ImageDraw.Draw(self._sheet)
        self._unit = max(max(self._size) / 640, 1.0)  # lines and letters of large pictures
        self._font = ImageFont.load_default(12 * self._unit * _SMOOTH)
        self._taken: list[tuple[float, float, float, float]] = []

    def grid(
        self,
        plane_map: PlaneMap,
        extent: tuple[float, float],
        step: float,
        scale: float,
        color: tuple[int, int, int],
        width: int,
    ) -> None:
        """Draw the lines at all multiples of `step`, and the border."""
        right, bottom = extent
        for axis, (long, across) in enumerate(((bottom, right), (right, bottom))):
            stations = [*np.arange(0, across + 1e-6 * step, step), across]
            for station in dict.fromkeys(stations):
                along = np.linspace(0, long, _PIECES)
                at = np.full(_PIECES, station)
                line = np.column_stack([at, along] if axis == 0 else [along, at])
                edge = station in (0, across)
                self._line(plane_map.to_pixel(line / scale), color, width + edge)

    def _line(self, pixels: Floats, color: tuple[int, int, int], width: int) -> None:
        for start, end in _runs(pixels, self._size):
            points = [tuple(one) for one in (_SMOOTH * (pixels[start:end] + 0.5)).tolist()]
            self._draw.line(points, fill=(*color, 220), width=round(width * self._unit * _SMOOTH))

    def numbers(
        self, plane_map: PlaneMap, extent: tuple[float, float], step: float, scale: float
    ) -> None:
        """Write x along the top border, and y along the left one."""
        right, bottom = extent
        for x in np.arange(0, right + 1e-6 * step, step):
            self._number(plane_map.to_pixel(np.array((x, 0.0)) / scale), f"{x:g}", (0, -1))
        for y in np.arange(step, bottom + 1e-6 * step, step):
            self._number(plane_map.to_pixel(np.array((0.0, y)) / scale), f"{y:g}", (-1, 0))

    def _number(self, pixel: Floats, text: str, beside: tuple[int, int]) -> None:
        if not np.isfinite(pixel).all():
            return
        self._words(pixel + 0.5, text, beside)

    def _words(self, at: Any, text: str, beside: tuple[int, int]) -> None:
        """Write a text on a dark box, inside the picture, beside a point."""
        left, top, right, bottom = self._draw.textbbox((0, 0), text, font=self._font)
        pad = 2 * self._unit * _SMOOTH
        wide, tall = right - left + 2 * pad, bottom - top + 2 * pad
        x = at[0] * _SMOOTH - wide / 2 + beside[0] * (wide / 2 + pad)
        y = at[1] * _SMOOTH - tall / 2 + beside[1] * (tall / 2 + pad)
        x = min(max(x, 0), self._sheet.width - wide)
        y = min(max(y, 0), self._sheet.height - tall)
        box = (x, y, x + wide, y + tall)
        if any(_overlap(box, other) for other in self._taken):
            return
        self._taken.append(box)
        self._draw.rectangle(box, fill=(0, 0, 0, 170))
        self._draw.text((x + pad - left, y + pad - top), text, font=self._font, fill=(*_FLOOR, 255))

    def legend(self, calibration: Calibration, step: float) -> None:
        """Write a legend of the lines at the bottom."""
        unit = "mm" if calibration.mm_per_px else "px"
        said = f"yellow: the floor, every {step:g} {unit}"
        if calibration.marker_height:
            said += f"; blue: {calibration.marker_height:g} mm above it, as high as the markers"
        self._words((self._size[0] / 2, self._size[1]), said, (0, -1))

    def finished(self) -> Pixels:
        sheet = self._sheet.resize(self._size, Image.Resampling.BOX)
        below = self._below.convert("RGBA")
        return np.array(Image.alpha_composite(below, sheet).convert("RGB"))


def _overlap(one: Any, other: Any) -> bool:
    return bool(one[0] < other[2] and other[0] < one[2] and one[1] < other[3] and other[1] < one[3])


def _runs(pixels: Floats, size: tuple[int, int]) -> list[tuple[int, int]]:
    """Return the parts of a line in or near the picture: far outside, a lens is undefined."""
    margin = np.array(size) * 0.5
    is_near = ((pixels > -margin) & (pixels < size + margin)).all(axis=1)  # NaN is not
    return [(start, end) for start, end in runs_of(is_near) if end - start > 1]


#: Shifts of a sheet that are good, and poor (px of the frame).
SHIFTS = (1.0, 3.0)


def mark_middles(sheets: Mapping[int, Corners], mark: float) -> dict[int, tuple[float, float]]:
    """Return the centres of the marks of sheets in a picture (px), by number."""
    middles = {}
    for sheet, seen in sheets.items():
        for number, positions in FloorSheet(sheet, mark).corners().items():
            is_its = (seen.positions[:, None] == positions).all(axis=2).any(axis=1)
            if is_its.sum() == len(positions):
                u, v = seen.pixels[is_its].mean(axis=0).tolist()
                middles[number] = (u, v)
    return middles


def sheet_shifts(image: Pixels | Frame, calibration: Calibration) -> dict[int, float]:
    """Return the distance of floor sheets from their positions during a calibration.

    A sheet that stays next to the robot's area reveals whether the camera was moved, turned or
    zoomed since the calibration.

    Parameters
    ----------
    image : Frame or array (H, W, 3) of uint8
        RGB picture.
    calibration : Calibration
        The camera's calibration.

    Returns
    -------
    dict of int to float
        The median distance of a sheet's marks from their calibrated positions (frame px), by sheet
        number. The dict contains only visible sheets that the calibration used.

    Raises
    ------
    ImportError
        If OpenCV is not installed.
    TypeError, ValueError
        If an argument has the wrong type, or the picture has another size.

    Examples
    --------
    >>> picture = np.full((480, 640, 3), 200, np.uint8)  # 1 px per mm
    >>> sheet = robsim.lab.FloorSheet(number=3, mark=60)
    >>> for x, y, width, height in np.rint(sheet.rectangles).astype(int):
    ...     picture[176 + y : 176 + y + height, 221 + x : 221 + x + width] = 20
    >>> fit = robsim.lab.calibrate_floor_by_sheets([picture], area=(300, 300), mm_per_px=2, mark=60)
    >>> shifts = robsim.lab.sheet_shifts(np.roll(picture, 5, axis=1), fit.calibration)
    >>> {number: round(shift, 1) for number, shift in shifts.items()}
    {3: 5.0}
    """
    check_kind("calibration", calibration, Calibration)
    pixels = frame_pixels("image", image)
    calibration.check_frames(check_size("size of image", frame_size(pixels)))
    off: dict[int, float] = {}  # by mark; the nearer of two marks with the same number counts
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
    """Return the centres of the marks that a picture shows once (px), by number."""
    found = find_marks(image)
    counts = Counter(number for number, _ in found)
    middles = {}
    for number, corners in found:
        if counts[number] == 1:
            u, v = corners.mean(axis=0).tolist()
            middles[number] = (u, v)
    return middles


def remedy_of_shifts(shifts: Mapping[int, float]) -> str:
    """Return why sheets may have moved, and the remedy; empty if they have not."""
    moved = [sheet for sheet, shift in shifts.items() if shift > SHIFTS[0]]
    if not moved:
        return ""
    if len(moved) == 1:
        said = f"floor sheet {moved[0]} is not where the calibration saw it"
    else:
        said = f"floor sheets {listed(map(str, moved))} are not where the calibration saw them"
    if len(moved) < len(shifts):
        return (
            f"{said}, the others are: put the sheets back or, if the camera moved, calibrate "
            "the floor again (robsim calibrate floor)"
        )
    return (
        f"{said}: was the camera moved, turned or zoomed since? Then calibrate the floor again "
        "(robsim calibrate floor)"
    )
