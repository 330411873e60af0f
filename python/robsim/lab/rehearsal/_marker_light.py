"""What the light makes of a marker's colour in a frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from robsim._core import Blob, ColorClass, Frame, rgb_to_yuv
from robsim.base.checks import Floats

_INNER = 0.7  # of a marker's outline, from its centre: the edge is mixed with what lies around
_OUTER = 1.2  # all of it
_AROUND = 1.6
_CLIPPED = 254  # levels
_LEVELS = 255

Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class MarkerLight:
    """The pixels of a marker in a frame.

    Attributes
    ----------
    level : float
        The brightest channel of its mean colour (0..255).
    clipped : float
        Share of its pixels with a channel at the upper end.
    margin : float
        How far its mean colour is inside the limits of its class (levels); negative = outside.
    contrast : float
        Distance in (U, V) between its mean colour and that of what is around it (levels).
    found : float
        Area of its blob, as a fraction of its own.
    """

    level: float
    clipped: float
    margin: float
    contrast: float
    found: float


def marker_light(
    frame: Frame, corners: Floats, blob: Blob, color: ColorClass
) -> MarkerLight | None:
    """Return what the light makes of a marker; None if too little of it is in the frame.

    Parameters
    ----------
    frame : Frame
        The frame.
    corners : array (N, 2)
        Corners of the marker (pixels of the frame).
    blob : Blob
        The blob that it was found as.
    color : ColorClass
        The class that found it.
    """
    if not np.isfinite(corners).all():  # where the lens shows nothing
        return None
    centre = corners.mean(axis=0)
    reach = _AROUND * np.abs(corners - centre).max(axis=0) + 1
    height, width = frame.image.shape[:2]
    left, top = np.maximum(np.floor(centre - reach), 0).astype(int)
    right, bottom = np.minimum(np.ceil(centre + reach), (width - 1, height - 1)).astype(int)
    if right - left < 2 or bottom - top < 2:
        return None
    rgb = np.ascontiguousarray(frame.image[top : bottom + 1, left : right + 1])
    polygons = (centre + scale * (corners - centre) - (left, top) for scale in (_INNER, _OUTER))
    inner, outer = (_mask(polygon, rgb.shape[:2]) for polygon in polygons)
    if inner.sum() < 4 or outer.all():
        return None
    yuv = rgb_to_yuv(rgb).astype(float)
    color_of_marker, color_around = yuv[inner].mean(axis=0), yuv[~outer].mean(axis=0)
    return MarkerLight(
        level=float(rgb[inner].mean(axis=0).max()),
        clipped=float((rgb[inner].max(axis=1) >= _CLIPPED).mean()),
        margin=_margin(color_of_marker, color),
        contrast=float(np.hypot(*(color_of_marker - color_around)[1:])),
        found=blob.area / _area(corners),
    )


def _mask(polygon: Floats, shape: tuple[int, ...]) -> Mask:
    drawn = Image.new("1", (shape[1], shape[0]))
    ImageDraw.Draw(drawn).polygon([(float(x), float(y)) for x, y in polygon], fill=1)
    return np.array(drawn)


def _area(corners: Floats) -> float:
    x, y = corners.T
    return abs(float(x @ np.roll(y, 1) - y @ np.roll(x, 1))) / 2


def _margin(yuv: Floats, color: ColorClass) -> float:
    """Return how far a colour (3,) is inside the limits that can be passed (levels)."""
    distances = []
    for value, (lower, upper) in zip(yuv, (color.y, color.u, color.v), strict=True):
        distances += [value - lower] * (lower > 0) + [upper - value] * (upper < _LEVELS)
    return float(min(distances, default=_LEVELS))
