"""First guesses of a robot's polygons: its outline from the floor's contrast, markers by colour."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from robsim._core import ColorClass, find_blobs, rgb_to_yuv
from robsim.base.checks import Floats
from robsim.base.geometry.polygons import mask
from robsim.vision.imaging.images import Pixels
from robsim.vision.robots.finding import marker_in, opaque_outline, pixels_of_blob

_RIM = 0.06  # of the shorter side: what is floor
_SIGMA = 1.4826  # of a normal distribution, by its median absolute deviation
_LEAST_SPREAD = 3.0  # levels
_FAR = 6.0  # spreads from the floor
_WINDOW = 0.07  # of the shorter side; noise, and seams of the floor, are no robot
_PAINT = (255, 0, 0)
_PAINTED = ColorClass("painted", v=(200, 255))


def guess_outline(image: Pixels) -> Floats:
    """Return the convex polygon around what stands out from the floor at the picture's rim.

    Parameters
    ----------
    image : array (h, w, 3) of uint8
        RGB; the robot somewhere within, the floor around it.

    Raises
    ------
    ValueError
        If nothing stands out.
    """
    yuv = rgb_to_yuv(image).astype(float)
    floor = yuv[_rim(image.shape[0], image.shape[1])]
    middle = np.median(floor, axis=0)
    spread = np.maximum(_SIGMA * np.median(np.abs(floor - middle), axis=0), _LEAST_SPREAD)
    distance = np.sqrt(np.square((yuv - middle) / spread).sum(axis=2))
    window = 2 * round(_WINDOW * min(image.shape[:2]) / 2) + 1
    stands_out = _mean(distance > _FAR, window) > 0.5
    painted = np.where(stands_out[..., None], np.array(_PAINT, np.uint8), np.uint8(0))
    least = max(9, image.shape[0] * image.shape[1] // 400)
    blobs = find_blobs(painted, [_PAINTED], minimum_area=least, maximum_count=1)["painted"]
    if not blobs:
        raise ValueError("nothing stands out from the floor at the picture's rim: draw the outline")
    across, down = pixels_of_blob(blobs[0], painted, _PAINTED).astype(int).T
    alpha = np.zeros((*image.shape[:2], 4), np.uint8)
    alpha[down, across, 3] = 255
    return opaque_outline(alpha)


def guess_marker(image: Pixels, outline: Floats, name: str, colors: Iterable[ColorClass]) -> Floats:
    """Return a polygon around the largest blob of a colour inside an outline.

    Raises
    ------
    ValueError
        If there is none, or no such colour.
    """
    height, width = image.shape[:2]
    inside = mask(outline, width, height)
    cut = np.dstack([image, np.where(inside, 255, 0).astype(np.uint8)])
    return marker_in(cut, name, tuple(colors))


def _rim(height: int, width: int) -> np.ndarray[tuple[int, int], np.dtype[np.bool_]]:
    wide = max(1, round(_RIM * min(height, width)))
    rim = np.ones((height, width), bool)
    rim[wide:-wide, wide:-wide] = False
    return rim


def _mean(values: np.ndarray[tuple[int, int], np.dtype[np.bool_]], n: int) -> Floats:
    """Return the share of true values in a window of n x n around each pixel."""
    padded = np.pad(values.astype(float), n // 2, mode="edge")
    sums = np.pad(padded.cumsum(axis=0).cumsum(axis=1), ((1, 0), (1, 0)))
    found: Floats = sums[n:, n:] - sums[:-n, n:] - sums[n:, :-n] + sums[:-n, :-n]
    return found / n**2
