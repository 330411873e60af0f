"""Frames as browsers get them: how often, and as what."""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from PIL import Image

from robsim._core import Blob, PlaneMap
from robsim.vision.imaging.images import Pixels

_GAP = 1 / 30  # s between two frames
_QUALITY = 80  # of the JPEG; 25 kB for 600 x 600
_MOST_BYTES = 140_000  # of a picture that stays in a notebook
_COLORS = (128, 64, 32, 16)  # of few a photograph of a noisy floor takes a fifth


class FrameClock:
    """When the next frame may come.

    By a due time: "30 ms since the last one" would beat against the clock of the steps.
    """

    def __init__(self) -> None:
        self.due = 0.0  # by the monotonic clock

    def sent(self, now: float) -> None:
        self.due = max(self.due + _GAP, now + 0.5 * _GAP)


def jpeg(pixels: Pixels) -> bytes:
    """Return an image as a JPEG."""
    out = io.BytesIO()
    Image.fromarray(pixels).save(out, "JPEG", quality=_QUALITY)
    return out.getvalue()


def small_png(picture: Image.Image) -> bytes:
    """Return an image as a PNG of so few colours that it is small, for a saved notebook."""
    for colors in _COLORS:
        out = io.BytesIO()
        kind = Image.Quantize.FASTOCTREE  # it keeps rare colours, such as those of the markers
        few = picture.quantize(colors, kind, dither=Image.Dither.NONE)
        few.save(out, "PNG", optimize=True)
        if out.tell() <= _MOST_BYTES:
            break
    return out.getvalue()


def numbers(values: Any) -> list[float] | None:
    """Return an array as a list for JSON; None if one of them is not finite."""
    array = np.asarray(values, float).ravel()
    return array.tolist() if np.isfinite(array).all() else None


def boxes_of(blobs: Mapping[str, Sequence[Blob]]) -> list[list[Any]]:
    """Return ``[colour, left, top, right, bottom]`` of each blob."""
    return [
        [color, *(int(side) for side in blob.bounding_box)]
        for color, found in blobs.items()
        for blob in found
    ]


def lens_of(plane_map: PlaneMap) -> list[float] | None:
    """Return fx, fy, cx, cy and the distortion; None for a camera whose lens is not known."""
    lens = plane_map.intrinsics
    if lens is None:
        return None
    (fx, _, cx), (_, fy, cy), _ = lens.matrix.tolist()
    return [fx, fy, cx, cy, *lens.distortion.tolist()]
