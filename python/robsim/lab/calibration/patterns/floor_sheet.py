"""`FloorSheet`: large marks to lay on the floor, and their detection in pictures."""

from __future__ import annotations

from dataclasses import dataclass
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

_ALONG = np.linspace(0.12, 0.88, 24)  # where a side is looked at, as a fraction of it
_STEPS = 17  # of a profile across a side
_REACH = 0.11  # of a side, to each side of it: the border is 1/6, the gap to the next mark 0.15
_SHORTEST, _LONGEST = 1.5, 6.0  # px
_TURNS = 2  # the second begins at the sides that the first one found


def refined_corners(cv2: Any, gray: Any, corners: Floats) -> Floats:
    """Return the corners (M, 4, 2) of marks in a picture (H, W), clockwise (px), refined."""
    picture = gray.astype(np.float32)
    for _ in range(_TURNS):
        corners = _turn(cv2, picture, corners)
    return corners


def _turn(cv2: Any, picture: Any, corners: Floats) -> Floats:
    following = np.roll(corners, -1, axis=1)
    side = following - corners  # (M, 4, 2), clockwise on the picture
    length = np.linalg.norm(side, axis=2, keepdims=True)
    along = side / length
    outward = np.stack([along[..., 1], -along[..., 0]], axis=-1)
    reach = np.clip(_REACH * length, _SHORTEST, _LONGEST)
    offsets = np.linspace(-1, 1, _STEPS)
    middles = corners[:, :, None] + _ALONG[:, None] * side[:, :, None]  # (M, 4, A, 2)
    across = (reach * outward)[:, :, None, None] * offsets[:, None]
    places = (middles[:, :, :, None] + across).astype(np.float32)  # (M, 4, A, S, 2)
    flat = places.reshape(places.shape[0] * 4, -1, 2)
    levels = cv2.remap(picture, flat[..., 0], flat[..., 1], cv2.INTER_LINEAR)
    profiles = levels.reshape(places.shape[:-1]).astype(float)
    edge = offsets[0] + _dark_part(profiles) * (offsets[-1] - offsets[0])
    points = middles + (edge * reach)[..., None] * outward[:, :, None]
    lines = _lines(points)
    found = _meeting(np.roll(lines, 1, axis=1), lines)
    is_near = np.linalg.norm(found - corners, axis=2, keepdims=True) < 2 * reach
    refined: Floats = np.where(is_near, found, corners)
    return refined


def _dark_part(profiles: Floats) -> Floats:
    """Return up to where profiles (..., S) from dark to bright are dark, as a fraction of them.

    Blur that is the same to both sides does not move it.
    """
    dark, bright = profiles.min(axis=-1, keepdims=True), profiles.max(axis=-1, keepdims=True)
    share = (bright - profiles) / np.maximum(bright - dark, 1)
    weights = np.ones(profiles.shape[-1])
    weights[[0, -1]] = 0.5  # trapezoids
    part: Floats = (share * weights).sum(axis=-1) / weights.sum()
    return part


def _lines(points: Floats) -> Floats:
    """Return the lines (..., 3), a x + b y = c, nearest to points (..., A, 2), but for outliers."""
    middle = np.median(points, axis=-2, keepdims=True)
    normal = _normal(points - middle)
    off = np.abs(((points - middle) * normal[..., None, :]).sum(-1))
    off -= np.median(off, axis=-1, keepdims=True)
    spread = np.median(np.abs(off), axis=-1, keepdims=True)
    weight = (off <= 4 * spread + 0.05).astype(float)[..., None]
    middle = (weight * points).sum(axis=-2, keepdims=True) / weight.sum(axis=-2, keepdims=True)
    normal = _normal(np.sqrt(weight) * (points - middle))
    offset = (normal * middle[..., 0, :]).sum(-1, keepdims=True)
    return np.concatenate([normal, offset], axis=-1)


def _normal(points: Floats) -> Floats:
    """Return the unit vectors (..., 2) along which points (..., A, 2) about 0 spread least."""
    spread = np.swapaxes(points, -1, -2) @ points
    normal: Floats = np.linalg.eigh(spread)[1][..., 0]
    return normal


def _meeting(one: Floats, other: Floats) -> Floats:
    """Return the points (..., 2) where lines (..., 3) meet; NaN if they are parallel."""
    determinant = one[..., 0] * other[..., 1] - one[..., 1] * other[..., 0]
    safe = np.where(np.abs(determinant) < 1e-6, np.nan, determinant)
    x = (one[..., 2] * other[..., 1] - one[..., 1] * other[..., 2]) / safe
    y = (one[..., 0] * other[..., 2] - one[..., 2] * other[..., 0]) / safe
    return np.stack([x, y], axis=-1)


#: The number of distinct floor sheets.
MOST_SHEETS = 16
_MARKS = 3, 2  # of a floor sheet, across and down
_GAP = 0.15  # between them, of the side of a mark
_BITS = 4  # cells along a mark, without its border.
_FEW = 12  # marks: a mirrored picture may show that many wrong ones


@dataclass(frozen=True)
class FloorSheet:
    """A sheet with six large marks for the floor; its axes point right and down from its centre.

    Parameters
    ----------
    number : int
        1 to 16; sheets on the same floor must have different numbers.
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
        """The printed text below the sheet."""
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
        """Left, top, width and height of the black areas (mm)."""
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
    """Return the visible marks of each floor sheet in a picture, by sheet number.

    Parameters
    ----------
    image : array (H, W, 3) of uint8
        RGB picture.
    mark : float
        Side of a mark (mm).

    Returns
    -------
    dict of int to Corners
        The corners of the found marks, from the centre of each sheet.

    Raises
    ------
    ImportError
        If OpenCV is not installed.
    TypeError, ValueError
        If an argument has the wrong type, or is out of range, or if the picture is mirrored.

    Examples
    --------
    >>> picture = np.full((480, 640, 3), 200, np.uint8)  # 1 px per mm
    >>> sheet = robsim.lab.FloorSheet(number=3, mark=60)
    >>> for x, y, width, height in np.rint(sheet.rectangles).astype(int):
    ...     picture[176 + y : 176 + y + height, 221 + x : 221 + x + width] = 20
    >>> found = robsim.lab.find_sheets(picture, mark=60)
    >>> {number: len(corners.pixels) for number, corners in found.items()}
    {3: 24}
    """
    mark = check_float("mark", mark, "mm", minimum=5, maximum=1000)
    seen: dict[int, list[tuple[int, Floats]]] = {}
    all_marks = find_marks(image)
    # A mirrored mark may resemble another one.
    if len(all_marks) < _FEW and len(find_marks(image[:, ::-1].copy())) > len(all_marks):
        raise ValueError("pictures must not be mirrored, but the floor sheets are mirrored")
    for number, corners in all_marks:
        seen.setdefault(sheet_of(number), []).append((number, corners))
    if twice := [sheet for sheet, marks in seen.items() if len(dict(marks)) < len(marks)]:
        raise ValueError(
            f"a picture must show each floor sheet once, got sheet {min(twice)} twice: cover one "
            "of the two, and print each sheet with its own robsim calibrate sheet --number"
        )
    found = {}
    for sheet, marks in sorted(seen.items()):
        places = FloorSheet(sheet, mark).corners()
        found[sheet] = Corners(
            np.concatenate([places[number] for number, _ in marks]),
            np.concatenate([corners for _, corners in marks]),
        )
    return found
