"""`Chessboard` and `Charuco`: the patterns that calibrate a lens, found in pictures."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from robsim.base.checks import Floats, check_float, check_int
from robsim.lab.calibration.patterns.pattern import (
    PURPOSE,
    Corners,
    Pixels,
    Rectangle,
    gray_of,
    mark_dictionary,
    mark_rectangles,
)
from robsim.vision.imaging.video import load_opencv

_LARGEST = 50  # corners or squares along a side
_FEWEST = 6  # corners of a ChArUco board that tell its pose
_BITS = 5  # cells along a mark of a ChArUco board, without its border


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
        cv2 = load_opencv(PURPOSE)
        gray = gray_of(image)
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
        aruco = load_opencv(PURPOSE).aruco
        size = (self.columns, self.rows)
        return aruco.CharucoBoard(size, self.square, self.marker, mark_dictionary(_BITS))

    @property
    def rectangles(self) -> list[Rectangle]:
        """Left, top, width and height of what is black (mm)."""
        black = _squares(self.columns, self.rows, self.square)
        for number, corners in zip(
            self._board.getIds().ravel(), self._board.getObjPoints(), strict=True
        ):
            left, top = corners[0][:2]
            black += mark_rectangles(_BITS, int(number), float(left), float(top), self.marker)
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
        cv2 = load_opencv(PURPOSE)
        options = cv2.aruco.CharucoParameters()
        options.minMarkers = 1  # that a corner is beside: those at the edge of a picture have one
        gray = gray_of(image)
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
