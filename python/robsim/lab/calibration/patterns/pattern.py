"""The base of the printed patterns: rectangles, marks, the found corners."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robsim.base.checks import Floats
from robsim.base.text import quoted
from robsim.base.values import runs_of
from robsim.vision.imaging.video import load_opencv

Rectangle = tuple[float, float, float, float]
Pixels = NDArray[np.uint8]

_LARGEST = 32_767  # px

#: The purpose of OpenCV.
PURPOSE = "finding a calibration pattern"


@dataclass(frozen=True, eq=False)
class Corners:
    """The found corners of a pattern in a picture.

    Attributes
    ----------
    positions : array (N, 2)
        Positions on the printed pattern, x to the right and y down (mm).
    pixels : array (N, 2)
        Positions in the picture: (u, v), an integer is a pixel's centre.

    Examples
    --------
    >>> squares = np.pad(np.indices((7, 10)).sum(axis=0) % 2, 1, constant_values=1)
    >>> picture = np.dstack(3 * [np.kron(squares, np.full((40, 40), 255)).astype(np.uint8)])
    >>> found = robsim.lab.Chessboard(square=25).find(picture)
    >>> len(found.pixels), np.ptp(found.positions, axis=0), np.ptp(found.pixels, axis=0).round()
    (54, array([200., 125.]), array([320., 200.]))
    """

    positions: Floats
    pixels: Floats


def mark_rectangles(
    bits: int, number: int, left: float, top: float, side: float
) -> list[Rectangle]:
    """Return the black cells of a mark, those beside each other in a row as one."""
    aruco = load_opencv("drawing a sheet with marks").aruco
    count = bits + 2  # with the border
    cells = aruco.generateImageMarker(mark_dictionary(bits), number, count) == 0
    cell = side / count
    black = []
    for row, line in enumerate(cells):
        for start, end in runs_of(line):
            black.append((left + start * cell, top + row * cell, (end - start) * cell, cell))
    return black


def mark_dictionary(bits: int) -> Any:
    aruco = load_opencv(PURPOSE).aruco
    names = {4: aruco.DICT_4X4_100, 5: aruco.DICT_5X5_100}
    return aruco.getPredefinedDictionary(names[bits])


def gray_of(image: Any) -> Pixels:
    if not (isinstance(image, np.ndarray) and image.dtype == np.uint8 and image.shape[2:] == (3,)):
        raise TypeError(f"image must be a uint8 array of shape (H, W, 3), got {quoted(image)}")
    if not 0 < min(image.shape) <= max(image.shape) <= _LARGEST:  # OpenCV ends the process
        raise ValueError(f"image must have 1 to {_LARGEST} px per side, got shape {image.shape}")
    gray: Pixels = load_opencv(PURPOSE).cvtColor(image, load_opencv(PURPOSE).COLOR_RGB2GRAY)
    return gray
