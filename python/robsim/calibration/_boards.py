"""The patterns that are printed for a calibration, and how they are found in pictures."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from robsim._base.checks import Floats, check_float, check_int
from robsim._base.text import quoted
from robsim.calibration._edges import refined_corners
from robsim.imaging._opencv import load_opencv

Rectangle = tuple[float, float, float, float]
Pixels = NDArray[np.uint8]

_LARGEST = 50  # corners or squares along a side
_PURPOSE = "finding a calibration pattern"
_FEWEST = 6  # corners of a ChArUco board that tell its pose
_BITS = 4, 5  # cells along a mark of a floor sheet and of a ChArUco board, without their border


@dataclass(frozen=True, eq=False)
class Corners:
    """What was found of a pattern in a picture.

    Attributes
    ----------
    positions : array (N, 2)
        Positions on the printed pattern, x to the right and y down (mm).
    pixels : array (N, 2)
        Where they are in the picture: (u, v), an integer is a pixel's centre.
    """

    positions: Floats
    pixels: Floats


class Pattern(Protocol):
    """What a sheet can show: black rectangles (mm from its top left corner)."""

    @property
    def size(self) -> tuple[float, float]:
        """Width and height (mm)."""

    @property
    def rectangles(self) -> list[Rectangle]:
        """Left, top, width and height of what is black."""

    @property
    def label(self) -> str:
        """What is printed below."""


def _check_squares(board: Chessboard | Charuco) -> None:
    check_int("columns", board.columns, minimum=3, maximum=_LARGEST)
    check_int("rows", board.rows, minimum=3, maximum=_LARGEST)
    check_float("square", board.square, "mm", minimum=1, maximum=1000)


@dataclass(frozen=True)
class Chessboard:
    """A chessboard, for the calibration of a lens.

    Parameters
    ----------
    columns, rows : int
        Inner corners, where four squares meet: 9 x 6 for a board of 10 x 7 squares.
    square : float
        Side of a square, measured on the print (mm).
    """

    columns: int = 9
    rows: int = 6
    square: float = 25.0

    def __post_init__(self) -> None:
        _check_squares(self)

    @property
    def size(self) -> tuple[float, float]:
        """Width and height (mm)."""
        return (self.columns + 1) * self.square, (self.rows + 1) * self.square

    @property
    def rectangles(self) -> list[Rectangle]:
        """Left, top, width and height of what is black (mm)."""
        return _squares(self.columns + 1, self.rows + 1, self.square)

    @property
    def label(self) -> str:
        """What is printed below."""
        return f"chessboard, --board {self.columns}x{self.rows} --square {self.square:g}"

    def find(self, image: Pixels) -> Corners | None:
        """Return all inner corners of the board in an RGB picture; None if it does not show all.

        Raises
        ------
        ImportError
            If OpenCV is not installed.
        TypeError, ValueError
            If `image` is no picture.
        """
        cv2 = load_opencv(_PURPOSE)
        gray = _gray(image)
        size = (self.columns, self.rows)
        found, pixels = cv2.findChessboardCornersSB(gray, size, flags=cv2.CALIB_CB_NORMALIZE_IMAGE)
        if not found:
            return None
        grid = np.asarray(pixels, float).reshape(self.rows, self.columns, 2)
        sides = [np.linalg.norm(np.diff(grid, axis=axis), axis=2).min() for axis in (0, 1)]
        pixels = _saddle_points(cv2, gray, pixels, 0.3 * min(sides))
        rows, columns = np.mgrid[1 : self.rows + 1, 1 : self.columns + 1]
        positions = self.square * np.stack([columns, rows], axis=-1).reshape(-1, 2)
        return Corners(positions.astype(float), pixels)


@dataclass(frozen=True)
class Charuco:
    """A chessboard with marks in its white squares: it may reach beyond the picture.

    Parameters
    ----------
    columns, rows : int
        Squares.
    square : float
        Side of a square, measured on the print (mm).
    """

    columns: int = 9
    rows: int = 6
    square: float = 28.0

    def __post_init__(self) -> None:
        _check_squares(self)
        if self.columns * self.rows > 200:
            raise ValueError(
                f"columns and rows must give at most 200 squares, got {self.columns} x {self.rows}"
            )

    @property
    def marker(self) -> float:
        """Side of a mark (mm)."""
        return 0.7 * self.square

    @property
    def size(self) -> tuple[float, float]:
        """Width and height (mm)."""
        return self.columns * self.square, self.rows * self.square

    @property
    def label(self) -> str:
        """What is printed below."""
        return f"ChArUco, --board {self.columns}x{self.rows} --square {self.square:g} --charuco"

    @cached_property
    def _board(self) -> Any:
        aruco = load_opencv(_PURPOSE).aruco
        size = (self.columns, self.rows)
        return aruco.CharucoBoard(size, self.square, self.marker, _dictionary(_BITS[1]))

    @property
    def rectangles(self) -> list[Rectangle]:
        """Left, top, width and height of what is black (mm)."""
        black = _squares(self.columns, self.rows, self.square)
        for number, corners in zip(
            self._board.getIds().ravel(), self._board.getObjPoints(), strict=True
        ):
            left, top = corners[0][:2]
            black += _mark(_BITS[1], int(number), float(left), float(top), self.marker)
        return black

    def find(self, image: Pixels) -> Corners | None:
        """Return the corners in an RGB picture, six at least; None if there are fewer.

        Raises
        ------
        ImportError
            If OpenCV is not installed.
        TypeError, ValueError
            If `image` is no picture.
        """
        cv2 = load_opencv(_PURPOSE)
        options = cv2.aruco.CharucoParameters()
        options.minMarkers = 1  # that a corner is beside: those at the edge of a picture have one
        gray = _gray(image)
        detector = cv2.aruco.CharucoDetector(self._board, options)
        pixels, numbers, marks, _ = detector.detectBoard(gray)
        if numbers is None or len(numbers) < _FEWEST:
            return None
        sides = np.linalg.norm(np.diff(np.array(marks, float).reshape(-1, 4, 2), axis=1), axis=2)
        about = np.asarray(pixels, float).reshape(-1, 2)
        reach = 0.2 * float(np.quantile(sides, 0.1))
        pixels = _saddle_points(cv2, gray, pixels, reach)
        is_near = np.linalg.norm(pixels - about, axis=1) < max(reach / 2, 1)  # no mark's corner
        if is_near.sum() < _FEWEST:
            return None
        positions = np.asarray(self._board.getChessboardCorners(), float)[numbers.ravel()]
        positions = positions[is_near, :2]
        if min(np.ptp(positions, axis=0)) == 0:  # all in one row
            return None
        return Corners(positions, pixels[is_near])


#: Floor sheets that can be told apart.
MOST_SHEETS = 16
_MARKS = 3, 2  # of a floor sheet, across and down
_GAP = 0.15  # between them, of the side of a mark


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
            for rectangle in _mark(_BITS[0], number, left, top, self.mark)
        ]

    def corners(self) -> dict[int, Floats]:
        """Return the corners (4, 2) of each mark, from the centre of the sheet (mm)."""
        square = self.mark * np.array([(0, 0), (1, 0), (1, 1), (0, 1)], float)
        centre = np.array(self.size) / 2
        return {
            number: square + np.array((left, top)) - centre for number, left, top in self._places
        }


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
    cv2 = load_opencv(_PURPOSE)
    options = cv2.aruco.DetectorParameters()
    options.minMarkerPerimeterRate = 0.01
    detector = cv2.aruco.ArucoDetector(_dictionary(_BITS[0]), options)
    gray = _gray(image)
    about, numbers, _ = detector.detectMarkers(gray)
    if numbers is None or not len(numbers):
        return {}
    pixels = refined_corners(cv2, gray, np.array(about, float).reshape(-1, 4, 2))
    seen: dict[int, list[tuple[int, Floats]]] = {}
    for number, corners in zip(numbers.ravel().tolist(), pixels, strict=True):
        sheet = number // (_MARKS[0] * _MARKS[1]) + 1
        if sheet <= MOST_SHEETS:
            seen.setdefault(sheet, []).append((number, corners))
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


def _saddle_points(cv2: Any, gray: Pixels, pixels: Any, reach: float) -> Floats:
    """Return (N, 2) where four squares meet, from about where; `reach` is how far to look (px)."""
    window = int(np.clip(reach, 2, 9))
    criteria = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_COUNT, 50, 1e-3)
    about = np.ascontiguousarray(pixels, np.float32).reshape(-1, 1, 2)
    found = cv2.cornerSubPix(gray, about, (window, window), (-1, -1), criteria)
    return np.asarray(found, float).reshape(-1, 2)


def _squares(columns: int, rows: int, side: float) -> list[Rectangle]:
    """Return the black squares of a chessboard; that at the top left is one."""
    return [
        (column * side, row * side, side, side)
        for row in range(rows)
        for column in range(columns)
        if (row + column) % 2 == 0
    ]


def _mark(bits: int, number: int, left: float, top: float, side: float) -> list[Rectangle]:
    """Return the black cells of a mark, those beside each other in a row as one."""
    aruco = load_opencv("drawing a sheet with marks").aruco
    count = bits + 2  # with the border
    cells = aruco.generateImageMarker(_dictionary(bits), number, count) == 0
    cell = side / count
    black = []
    for row, line in enumerate(cells):
        edges = np.flatnonzero(np.diff(np.concatenate(([0], line.astype(int), [0]))))
        for start, end in edges.reshape(-1, 2).tolist():
            black.append((left + start * cell, top + row * cell, (end - start) * cell, cell))
    return black


def _dictionary(bits: int) -> Any:
    aruco = load_opencv(_PURPOSE).aruco
    names = {4: aruco.DICT_4X4_100, 5: aruco.DICT_5X5_100}
    return aruco.getPredefinedDictionary(names[bits])


def _gray(image: Any) -> Pixels:
    if not (isinstance(image, np.ndarray) and image.dtype == np.uint8 and image.shape[2:] == (3,)):
        raise TypeError(f"image must be a uint8 array of shape (H, W, 3), got {quoted(image)}")
    gray: Pixels = load_opencv(_PURPOSE).cvtColor(image, load_opencv(_PURPOSE).COLOR_RGB2GRAY)
    return gray
