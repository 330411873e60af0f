"""A picture to try the tool with: a floor of tiles, seen at a tilt."""

from __future__ import annotations

import functools
import math

import numpy as np

from robsim.base.checks import Floats
from robsim.vision.imaging.images import Pixels

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
def tiled_floor() -> Pixels:
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
