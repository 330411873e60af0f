"""`Chessboard` and `Charuco`: the patterns that calibrate a lens, found in pictures."""

from __future__ import annotations

from collections.abc import Iterator
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
_REDUCED = 1280.0  # px of a side.
_FLAT = (24, 48)  # px of a square that is mapped to one.
_MARGIN = 3.0  # px at the edge of a picture, which its map to squares repeats.
_MOST_BEND = 0.5  # of a step between corners.
_MOST_FLAT_BEND = 0.2  # of a step, where all are mapped to about the same.
_LEAST_CONTRAST = 0.1  # of neighbouring squares, of the median.
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
        """Left, top, width and height of the black areas (mm)."""
        return _squares(self.columns + 1, self.rows + 1, self.square)

    @property
    def label(self) -> str:
        """The printed text below the board."""
        return f"chessboard, --board {self.columns}x{self.rows} --square {self.square:g}"

    def find(self, image: Pixels) -> Corners | None:
        """Return all inner corners of the board in an RGB picture; None unless all are visible.

        Raises
        ------
        ImportError
            If OpenCV is not installed.
        TypeError, ValueError
            If `image` is not a picture.
        """
        cv2 = load_opencv(PURPOSE)
        gray = gray_of(image)
        grid = self._grid(cv2, gray)
        if grid is None:
            grid = self._flattened(cv2, gray)
        if grid is None:
            return None
        rows, columns = np.mgrid[1 : self.rows + 1, 1 : self.columns + 1]
        positions = self.square * np.stack([columns, rows], axis=-1).reshape(-1, 2)
        return Corners(positions.astype(float), grid.reshape(-1, 2))

    def _grid(self, cv2: Any, gray: Pixels) -> Floats | None:
        grids = (self._refined(cv2, gray, about) for about in self._tries(cv2, gray))
        return next((one for one in grids if one is not None), None)

    def _tries(self, cv2: Any, gray: Pixels) -> Iterator[Floats]:
        """Yield approximate corners from several detectors; no detector finds all boards."""
        size = (self.columns, self.rows)
        for flags in (cv2.CALIB_CB_NORMALIZE_IMAGE, 0):
            found, pixels = cv2.findChessboardCornersSB(gray, size, flags=flags)
            if found:
                yield np.asarray(pixels, float)
        flags = cv2.CALIB_CB_ADAPTIVE_THRESH  # histograms made even would take seconds
        found, pixels = cv2.findChessboardCorners(gray, size, flags=flags)
        if found:
            yield np.asarray(pixels, float)

    def _flattened(self, cv2: Any, gray: Pixels) -> Floats | None:
        """Return the corners found after mapping a part of the board to squares."""
        reach = max(self.columns, self.rows) + 1  # squares from the part to the farthest edge
        bounds = np.array(gray.shape[::-1]) - _MARGIN
        for steps, centre in _parts(cv2, gray):
            side = int(np.clip(np.linalg.norm(steps, axis=0).max(), *_FLAT))
            flatten = side * np.linalg.inv(steps)
            shift = side * reach - flatten @ centre
            to_flat, size = np.column_stack([flatten, shift]), 2 * side * reach
            flat = cv2.warpAffine(gray, to_flat, (size, size), borderMode=cv2.BORDER_REPLICATE)
            grid = self._grid(cv2, flat)
            if grid is None or not _is_even(grid, _MOST_FLAT_BEND):
                continue
            corners = np.asarray((grid - shift) @ np.linalg.inv(flatten).T)
            if (corners > _MARGIN).all() and (corners < bounds).all():
                return corners
        return None

    def _refined(self, cv2: Any, gray: Pixels, about: Floats) -> Floats | None:
        """Return the corners (rows, columns, 2); None without a board of this size."""
        raw = about.reshape(self.rows, self.columns, 2)
        fine = _saddle_points(cv2, gray, about, 0.5 * _shortest(raw)).reshape(raw.shape)
        even = (one for one in (fine, raw) if _is_even(one))  # noise may distort the fine corners
        return next((one for one in even if has_squares(cv2, gray, one)), None)


def _shortest(grid: Floats) -> float:
    return min(float(np.linalg.norm(np.diff(grid, axis=axis), axis=2).min()) for axis in (0, 1))


def _is_even(grid: Floats, most: float = _MOST_BEND) -> bool:
    """Return whether corners (R, C, 2) follow each other evenly, but for perspective and lens."""
    for axis in (0, 1):
        steps = np.diff(grid, axis=axis)
        lengths = np.linalg.norm(steps, axis=2)
        before, after = (np.delete(lengths, end, axis=axis) for end in (-1, 0))
        bends = np.linalg.norm(np.diff(steps, axis=axis), axis=2)
        if (bends > most * np.minimum(before, after)).any():
            return False
    return True


def has_squares(cv2: Any, gray: Pixels, grid: Floats, *, is_part: bool = False) -> bool:
    """Return whether black and white alternate between corners (R, C, 2), and around, but no more.

    If they alternate a square farther, this is a part of a larger board.
    """
    around = np.pad(grid, ((2, 2), (2, 2), (0, 0)), mode="reflect", reflect_type="odd")
    pairs = around[:-1] + around[1:]
    middles = ((pairs[:, :-1] + pairs[:, 1:]) / 4).astype(np.float32)
    width = max(int(_shortest(grid) / 4), 1)
    smooth = cv2.blur(gray, (width, width)).astype(np.float32)
    levels = cv2.remap(smooth, middles, None, cv2.INTER_LINEAR, borderValue=np.nan)
    levels[np.indices(levels.shape).sum(axis=0) % 2 == 1] *= -1
    inner = levels[2:-2, 2:-2] if is_part else levels[1:-1, 1:-1]
    # a + b, as every second level is negated: differences of neighbours, of one sign
    steps = np.concatenate([(inner[1:] + inner[:-1]).flat, (inner[:, 1:] + inner[:, :-1]).flat])
    typical = float(np.nanmedian(steps))
    least = float(np.nanmin(steps * np.sign(typical)))  # NaN is outside the picture
    if is_part or least <= _LEAST_CONTRAST * abs(typical):
        return is_part and least > 0
    beyond = (levels[0], levels[-1], levels[:, 0], levels[:, -1])
    farther = [(line[1:-2] + line[2:-1]) / typical for line in beyond]
    return not any((line > 0.5).all() for line in farther)


def reduced(cv2: Any, gray: Pixels) -> tuple[Pixels, float]:
    """Return a smaller picture if this one is large, and its scale."""
    scale = min(max(_REDUCED / max(gray.shape), 1 / min(gray.shape)), 1.0)
    return cv2.resize(gray, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA), scale


def find_part(cv2: Any, gray: Pixels, flags: int) -> Floats | None:
    """Return corners (R, C, 2) that may be a part of a chessboard, 3 x 3 or more."""
    flags |= cv2.CALIB_CB_LARGER
    found, pixels, meta = cv2.findChessboardCornersSBWithMeta(gray, (3, 3), flags=flags)
    return np.asarray(pixels, float).reshape(*meta.shape, 2) if found else None


def _parts(cv2: Any, gray: Pixels) -> Iterator[tuple[Floats, Floats]]:
    """Yield steps (columns of a 2 x 2 matrix) and centres of possible parts of a chessboard."""
    small, scale = reduced(cv2, gray)
    extent = np.array(small.shape[::-1])
    turns = np.radians((0, 45, 90, 135))
    along = np.column_stack([np.cos(turns), np.sin(turns)])
    # detectors miss narrow rhombs, but not in a picture that is stretched along the right line
    for stretch in (np.eye(2), *(0.7 * (np.eye(2) + np.outer(one, one)) for one in along)):
        size = tuple((np.abs(stretch) @ extent).astype(int))
        shift = (size - stretch @ extent) / 2
        to_view = np.column_stack([stretch, shift])
        view = cv2.warpAffine(small, to_view, size, borderMode=cv2.BORDER_REPLICATE)
        grid = find_part(cv2, view, cv2.CALIB_CB_NORMALIZE_IMAGE)
        if grid is None:
            continue
        back = np.linalg.inv(scale * stretch)
        means = [np.diff(grid, axis=axis).mean(axis=(0, 1)) for axis in (1, 0)]
        steps = back @ np.column_stack(means)
        if np.linalg.det(steps) > 1:  # neither mirrored nor on a line
            yield steps, back @ (grid.mean(axis=(0, 1)) - shift)


@dataclass(frozen=True)
class Charuco:
    """A chessboard with marks in its white squares; it may extend beyond the picture.

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
        """The printed text below the board."""
        return f"ChArUco, --board {self.columns}x{self.rows} --square {self.square:g} --charuco"

    @cached_property
    def _board(self) -> Any:
        aruco = load_opencv(PURPOSE).aruco
        size = (self.columns, self.rows)
        return aruco.CharucoBoard(size, self.square, self.marker, mark_dictionary(_BITS))

    @property
    def rectangles(self) -> list[Rectangle]:
        """Left, top, width and height of the black areas (mm)."""
        black = _squares(self.columns, self.rows, self.square)
        for number, corners in zip(
            self._board.getIds().ravel(), self._board.getObjPoints(), strict=True
        ):
            left, top = corners[0][:2]
            black += mark_rectangles(_BITS, int(number), float(left), float(top), self.marker)
        return black

    def find(self, image: Pixels) -> Corners | None:
        """Return the corners found in an RGB picture; None for fewer than six corners.

        Raises
        ------
        ImportError
            If OpenCV is not installed.
        TypeError, ValueError
            If `image` is not a picture.
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
    """Return (N, 2) points where four squares meet, near `about`; `reach` is the radius (px)."""
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
