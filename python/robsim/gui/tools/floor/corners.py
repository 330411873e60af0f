"""Corners, dots and sheets found in the picture of a floor; an example picture."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from robsim.base.checks import Floats, check_float
from robsim.lab.calibration.seen_sheets import SeenSheets
from robsim.vision.imaging import images

_MOST_REACH = 40.0  # px
_SIGMA = 0.25  # of the weights around the point, per reach: wide joints need a wide window
_LEAST_SIGMA, _MOST_SIGMA = 4.0, 6.0  # px
_LEAST_CONTRAST = 1.5  # levels per px, mean across the weaker direction
_TURNS = 12
_SETTLED = 0.005  # px
_LUMA = np.array((0.299, 0.587, 0.114))


def snapped(
    image: images.Pixels, at: tuple[float, float], reach: float
) -> tuple[float, float] | None:
    """Return the nearest corner or dot of a picture, to a tenth of a pixel."""
    reach = min(max(reach, 1.0), _MOST_REACH)
    sigma = min(max(_SIGMA * reach, _LEAST_SIGMA), _MOST_SIGMA)
    half = math.ceil(reach + 4 * sigma)
    left, top = (max(round(one) - half, 0) for one in at)
    bottom, right = (round(one) + half + 1 for one in (at[1], at[0]))
    part = image[top:bottom, left:right] if min(bottom, right) > 0 else image[:0]
    if min(part.shape[:2]) < 4 * sigma:
        return None
    down, across = np.gradient(_blurred(part @ _LUMA, 0.7))
    # The weight is the gradient, not its square, so that both sides of a joint count similarly.
    scale = np.sqrt(np.hypot(across, down) + 1e-9)
    down, across = down / scale, across / scale
    begin = _strongest(across, down, (at[0] - left, at[1] - top), reach, sigma)
    found = None if begin is None else _refined(across, down, begin, sigma)
    if found is None or math.dist(found, (at[0] - left, at[1] - top)) > reach + 1:
        return None
    return found[0] + left, found[1] + top


def _strongest(
    across: Floats, down: Floats, at: tuple[float, float], reach: float, sigma: float
) -> tuple[float, float] | None:
    """Return the pixel near a point whose surrounding gradients vary most in direction."""
    xx, xy, yy = (_blurred(one, sigma) for one in (across**2, across * down, down**2))
    # the smaller eigenvalue of [[xx, xy], [xy, yy]]
    weaker = (xx + yy) / 2 - np.hypot((xx - yy) / 2, xy)
    v, u = np.indices(weaker.shape)
    away = np.hypot(u - at[0], v - at[1]) / reach
    score = np.where(away <= 1, weaker * (1 - 0.5 * away**2), 0.0)
    best = np.unravel_index(int(score.argmax()), score.shape)
    if weaker[best] < _LEAST_CONTRAST:
        return None
    return float(best[1]), float(best[0])


def _refined(
    across: Floats, down: Floats, begin: tuple[float, float], sigma: float
) -> tuple[float, float] | None:
    """Return the better fit: the meeting point of the lines along edges or across edges."""
    fits = [_meeting(*lines, begin, sigma) for lines in ((across, down), (-down, across))]
    found = [fit for fit in fits if fit is not None]
    return min(found, key=lambda fit: fit[0])[1] if found else None


def _meeting(
    across: Floats, down: Floats, begin: tuple[float, float], sigma: float
) -> tuple[float, tuple[float, float]] | None:
    """Return the point nearest to lines with these normals, and its distance."""
    v, u = np.indices(across.shape)
    at = np.array(begin)
    for _ in range(_TURNS):
        weight = np.exp(-((u - at[0]) ** 2 + (v - at[1]) ** 2) / (2 * sigma**2))
        normals = np.array(
            [
                ((weight * across**2).sum(), (weight * across * down).sum()),
                ((weight * across * down).sum(), (weight * down**2).sum()),
            ]
        )
        if np.linalg.cond(normals) > 100:
            return None
        off = weight * (across * (u - at[0]) + down * (v - at[1]))
        step = np.linalg.solve(normals, np.array(((off * across).sum(), (off * down).sum())))
        at = at + step
        if np.linalg.norm(step) < _SETTLED:
            break
    if math.dist(at, begin) > 2 * sigma:
        return None
    left = (weight * (across * (u - at[0]) + down * (v - at[1])) ** 2).sum() / np.trace(normals)
    return float(left), (float(at[0]), float(at[1]))


def _blurred(levels: Any, sigma: float) -> Floats:
    """Return an array blurred by a Gaussian; edge pixels are repeated outside."""
    half = math.ceil(2.5 * sigma)
    taps = np.exp(-(np.arange(-half, half + 1) ** 2) / (2 * sigma**2))
    taps /= taps.sum()
    for axis in (0, 1):
        padding = [(half, half) if one == axis else (0, 0) for one in (0, 1)]
        padded = np.pad(levels, padding, mode="edge")
        count = levels.shape[axis]
        levels = sum(tap * np.take(padded, range(i, i + count), axis) for i, tap in enumerate(taps))
    return np.asarray(levels, float)


_MARK = 80.0  # mm, as printed


class FloorSheets:
    """The sheets found last, and their measured sizes and positions."""

    def __init__(self) -> None:
        self._seen = SeenSheets((0, 0), _MARK)

    def task(self) -> SeenSheets:
        return self._seen

    def looking(self, image: images.Pixels) -> Callable[[], SeenSheets | str]:
        """Return a function that finds a picture's sheets, or says why not, in any thread."""
        mark = self._seen.mark

        def find() -> SeenSheets | str:
            try:
                seen = SeenSheets.of(image, mark)
            except (ImportError, ValueError) as error:
                return str(error)
            if not seen.corners:
                return (
                    "no floor sheet in the picture: the marks of a sheet must be at least 15 px "
                    "wide, sharp and visible"
                )
            return seen

        return find

    def take(self, found: SeenSheets) -> None:
        """Take the sheets of a picture; the side of the marks may have changed meanwhile."""
        self._seen = replace(found.with_mark(self._seen.mark), places=self._seen.places)

    def place(self, number: int, x: float | None, y: float | None) -> None:
        """Set the position of a sheet's cross on the floor (mm); None = not measured."""
        if number not in self._seen.corners:
            raise ValueError(f"the picture has no sheet {number}")
        self._seen = replace(self._seen, places={**self._seen.places, number: (x, y)})

    def adjust(self, mark: float) -> None:
        """Set the side of a mark (mm)."""
        mark = check_float("mark", mark, "mm", minimum=5, maximum=1000)
        self._seen = self._seen.with_mark(mark)

    def state(self) -> dict[str, Any]:
        """Return the data for the browsers."""
        seen = self._seen
        return {
            "mark": seen.mark,
            "found": [
                {
                    "number": number,
                    "place": [*seen.places.get(number, (None, None))],
                    "corners": len(one.pixels),
                }
                for number, one in sorted(seen.corners.items())
            ],
        }


TITLE = "an example: a floor with tiles of 300 mm"
_SIZE = (800, 600)  # px
_FOCAL = 700.0  # px
_TILT = math.radians(-35)
_AWAY = 3200.0  # mm, from the camera to the middle of the area
_MIDDLE = (1200.0, 1200.0)  # of the area (mm)
_TILE, _JOINT = 300.0, 10.0  # mm
_BLUR = 5.0  # mm, about a px
_LIGHT, _DARK, _SPREAD, _NOISE = 150.0, 70.0, 14.0, 1.5  # levels


@functools.cache
def tiled_floor() -> images.Pixels:
    """Return the picture of the floor, (H, W, 3)."""
    width, height = _SIZE
    a, b, c = np.linalg.inv(floor_to_pixels())
    across, down = np.arange(width)[None, :], np.arange(height)[:, None]
    depth = c[0] * across + c[1] * down + c[2]
    x = (a[0] * across + a[1] * down + a[2]) / depth
    y = (b[0] * across + b[1] * down + b[2]) / depth
    rng = np.random.default_rng(2)
    tones = _LIGHT + _SPREAD * rng.uniform(-1, 1, (64, 64))
    column, row = (np.floor(one / _TILE).astype(int) % 64 for one in (x, y))
    off = [np.abs(one - _TILE * np.rint(one / _TILE)) for one in (x, y)]
    dark = np.clip(0.5 + (_JOINT / 2 - np.minimum(*off)) / _BLUR, 0, 1)
    levels = dark * _DARK + (1 - dark) * tones[row, column]
    levels = levels + _NOISE * rng.standard_normal(levels.shape)
    gray = np.clip(np.rint(levels), 0, 255).astype(np.uint8)
    picture = np.stack([gray] * 3, axis=-1)
    picture.flags.writeable = False
    return picture


def floor_to_pixels() -> Floats:
    """Return the homography (3, 3) from the floor (mm) to the pixels."""
    c, s = math.cos(_TILT), math.sin(_TILT)
    turned = np.array(((1, 0, 0), (0, c, -s), (0, s, c)))  # from the area to the camera
    place = np.array((0, 0, _AWAY)) - turned @ (*_MIDDLE, 0)
    width, height = _SIZE
    matrix = np.array(
        ((_FOCAL, 0, (width - 1) / 2), (0, _FOCAL, (height - 1) / 2), (0, 0, 1)), float
    )
    found: Floats = matrix @ np.column_stack([turned[:, :2], place])
    return found
