"""`FloorSheet`: large marks to lay on the floor, and how they are found in pictures."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robsim.base.checks import Floats, check_float, check_int
from robsim.lab.calibration.patterns.edges import refined_corners
from robsim.lab.calibration.patterns.pattern import (
    PURPOSE,
    Corners,
    Pixels,
    Rectangle,
    gray_of,
    mark_dictionary,
    mark_rectangles,
)
from robsim.vision.imaging.opencv import load_opencv

#: Floor sheets that can be told apart.
MOST_SHEETS = 16
_MARKS = 3, 2  # of a floor sheet, across and down
_GAP = 0.15  # between them, of the side of a mark
_BITS = 4  # cells along a mark, without its border


@dataclass(frozen=True)
class FloorSheet:
    """Six large marks to lay on the floor; its axes point right and down, from its centre.

    Parameters
    ----------
    number : int
        1 to 16; no two sheets of one number may lie on the floor.
    mark : float
        Side of a mark, measured on the print (mm).
    """

    number: int = 1
    mark: float = 80.0

    def __post_init__(self) -> None:
        check_int("number", self.number, minimum=1, maximum=MOST_SHEETS)
        check_float("mark", self.mark, "mm", minimum=5, maximum=1000)

    @property
    def size(self) -> tuple[float, float]:
        """Width and height (mm)."""
        across, down = _MARKS
        pitch = (1 + _GAP) * self.mark
        return across * pitch - _GAP * self.mark, down * pitch - _GAP * self.mark

    @property
    def label(self) -> str:
        """What is printed below."""
        return f"floor sheet {self.number}, --mark {self.mark:g}"

    @property
    def _places(self) -> list[tuple[int, float, float]]:
        """Number, left and top (mm) of each mark."""
        across, down = _MARKS
        first = (self.number - 1) * across * down
        pitch = (1 + _GAP) * self.mark
        return [
            (first + row * across + column, column * pitch, row * pitch)
            for row in range(down)
            for column in range(across)
        ]

    @property
    def rectangles(self) -> list[Rectangle]:
        """Left, top, width and height of what is black (mm)."""
        return [
            rectangle
            for number, left, top in self._places
            for rectangle in mark_rectangles(_BITS, number, left, top, self.mark)
        ]

    def corners(self) -> dict[int, Floats]:
        """Return the corners (4, 2) of each mark, from the centre of the sheet (mm)."""
        square = self.mark * np.array([(0, 0), (1, 0), (1, 1), (0, 1)], float)
        centre = np.array(self.size) / 2
        return {
            number: square + np.array((left, top)) - centre for number, left, top in self._places
        }


def sheet_of(mark: int) -> int:
    return mark // (_MARKS[0] * _MARKS[1]) + 1


def find_marks(image: Pixels) -> list[tuple[int, Floats]]:
    """Return number and corners (4, 2) of each mark of a floor sheet in an RGB picture (px)."""
    cv2 = load_opencv(PURPOSE)
    options = cv2.aruco.DetectorParameters()
    options.minMarkerPerimeterRate = 0.01
    detector = cv2.aruco.ArucoDetector(mark_dictionary(_BITS), options)
    gray = gray_of(image)
    about, numbers, _ = detector.detectMarkers(gray)
    if numbers is None or not len(numbers):
        return []
    pixels = refined_corners(cv2, gray, np.array(about, float).reshape(-1, 4, 2))
    found = zip(numbers.ravel().tolist(), pixels, strict=True)
    return [(number, corners) for number, corners in found if sheet_of(number) <= MOST_SHEETS]


def find_sheets(image: Pixels, mark: float) -> dict[int, Corners]:
    """Return what a picture shows of each floor sheet, by its number.

    Parameters
    ----------
    image : array (H, W, 3) of uint8
        RGB.
    mark : float
        Side of a mark (mm).

    Returns
    -------
    dict of int to Corners
        The corners of the marks that were found, from the centre of each sheet.

    Raises
    ------
    ImportError
        If OpenCV is not installed.
    TypeError, ValueError
        If an argument has another type, or is out of range.
    """
    mark = check_float("mark", mark, "mm", minimum=5, maximum=1000)
    seen: dict[int, list[tuple[int, Floats]]] = {}
    for number, corners in find_marks(image):
        seen.setdefault(sheet_of(number), []).append((number, corners))
    if twice := [sheet for sheet, marks in seen.items() if len(dict(marks)) < len(marks)]:
        raise ValueError(
            f"pictures must show each floor sheet once, got sheet {min(twice)} twice in one: give "
            "each a number of its own (robsim calibrate sheet --number), and cover the other"
        )
    found = {}
    for sheet, marks in sorted(seen.items()):
        places = FloorSheet(sheet, mark).corners()
        found[sheet] = Corners(
            np.concatenate([places[number] for number, _ in marks]),
            np.concatenate([corners for _, corners in marks]),
        )
    return found
