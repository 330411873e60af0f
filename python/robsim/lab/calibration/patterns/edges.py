"""The corners of black marks to a tenth of a pixel: where straight lines through their sides meet.

Where corners are rounded by blur, a corner finder is some 0.3 px too far inside; sides are not.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from robsim.base.checks import Floats

_ALONG = np.linspace(0.12, 0.88, 24)  # where a side is looked at, as a fraction of it
_STEPS = 17  # of a profile across a side
_REACH = 0.11  # of a side, to each side of it: the border is 1/6, the gap to the next mark 0.15
_SHORTEST, _LONGEST = 1.5, 6.0  # px
_TURNS = 2  # the second begins at the sides that the first one found


def refined_corners(cv2: Any, gray: Any, corners: Floats) -> Floats:
    """Return the corners (M, 4, 2) of marks, refined.

    Parameters
    ----------
    cv2 : module
        OpenCV.
    gray : array (H, W) of uint8
        The picture.
    corners : array (M, 4, 2)
        About where they are, clockwise (px).
    """
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
