"""The picture of a frame, as pixels."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import cache

import numpy as np
from matplotlib.colors import to_rgb
from numpy.typing import ArrayLike
from PIL import Image, ImageDraw, ImageFont
from PIL.ImageFont import FreeTypeFont

from robsim._base.checks import Floats
from robsim._core import Blob, Estimate, Frame, Measurement
from robsim.imaging._frames import frame_size
from robsim.imaging._images import Pixels
from robsim.plotting import _style as style
from robsim.plotting._shapes import box_corners, heading_line, placed_outline

SHADE = 0.35  # brightness of the picture under the text
FINENESS = 3  # lines are drawn so many times larger, then reduced: their edges become smooth


def draw_overlay(
    frame: Frame,
    *,
    measurement: Measurement | None = None,
    blobs: Mapping[str, Sequence[Blob]] | None = None,
    outline: ArrayLike | None = None,
    path: ArrayLike | None = None,
    estimate: Estimate | None = None,
    text: str | None = None,
) -> Pixels:
    """Draw onto the pixels of a frame what the robot's software made of it, as for a video.

    Parameters
    ----------
    frame : Frame
        The image with its plane map.
    measurement : Measurement, optional
        The measured pose, green: a line from the centre along the heading. With `blobs`, but
        without it, the picture says "not seen".
    blobs : dict of str to sequence of Blob, optional
        Per colour the blobs, as from `find_blobs`: each gets its bounding box.
    outline : array_like (N, 2), optional
        Outline of the robot in its own axes, x forward and y to the right (work-area px), drawn at
        the measured and at the estimated pose.
    path : array_like (N, 2), optional
        The places measured up to now (work-area px), drawn as a green line. NaN breaks it.
    estimate : Estimate, optional
        The estimated pose, blue: a cross and a line along the heading.
    text : str, optional
        A line of text at the bottom.

    Returns
    -------
    array (H, W, 3) of uint8
        RGB, of the size of the frame.

    Raises
    ------
    ValueError
        If `outline` or `path` is not of shape (N, 2).
    """
    canvas = _Canvas(frame)
    if path is not None:
        canvas.trail(_places(path), style.MEASURED)
    for color, found in (blobs or {}).items():
        for blob in found:
            canvas.box(box_corners(blob), style.drawn_color(color))
    if estimate is not None:
        canvas.pose(estimate.pose, outline, style.ESTIMATED)
        canvas.cross(estimate.pose, style.ESTIMATED)
    if measurement is not None:
        canvas.pose(measurement.pose, outline, style.MEASURED)
    elif blobs is not None:
        canvas.label("not seen", style.WRONG)
    if text:
        canvas.caption(text)
    return canvas.image


class _Canvas:
    """The picture in the making. Widths are those in a frame of 1200 px."""

    def __init__(self, frame: Frame) -> None:
        # Whole pictures are slow to take from Pillow: it draws masks, which are painted here.
        self.image = frame.image.copy()
        self._size = frame_size(self.image)
        self._map = frame.plane_map
        self._unit = min(self._size) / 1200

    def trail(self, places: Floats, color: str) -> None:
        # It may have thousands of points: no smooth edges.
        pixels = self._pixels(places)
        mask = Image.new("L", self._size)
        for segment in np.split(pixels, np.flatnonzero(np.isnan(pixels[:, 0]))):
            known = segment[~np.isnan(segment[:, 0])].ravel().tolist()
            ImageDraw.Draw(mask).line(known, 255, max(round(2 * self._unit), 1))
        self._paint(mask, (0, 0), color)

    def box(self, corners: Floats, color: str) -> None:
        self._stroke(_closed(corners), color, 2)

    def pose(self, pose: Floats, outline: ArrayLike | None, color: str) -> None:
        if outline is not None:
            self._stroke(_closed(self._pixels(placed_outline(outline, pose))), color, 3)
        self._stroke(self._pixels(heading_line(pose)), color, 4)

    def cross(self, pose: Floats, color: str) -> None:
        centre, arm = self._pixels(pose[None, :2]), max(12 * self._unit, 4)
        for direction in ((1, 1), (1, -1)):
            ends = np.multiply.outer((-arm, arm), direction)
            self._stroke(centre + ends, color, 4)

    def label(self, text: str, color: str) -> None:
        font = self._font(text)
        size = (math.ceil(font.getlength(text) + font.size), round(1.8 * font.size))
        margin = int(font.size / 2)
        self._paint(Image.new("L", size, 255), (margin, margin), color)
        self._write(text, font, (margin, margin), size)

    def caption(self, text: str) -> None:
        font = self._font(text)
        width, height = self._size
        size = (width, min(round(1.8 * font.size), height))
        top = height - size[1]
        self.image[top:] = SHADE * self.image[top:]
        self._write(text, font, (0, top), size)

    def _write(
        self, text: str, font: FreeTypeFont, corner: tuple[int, int], size: tuple[int, int]
    ) -> None:
        mask = Image.new("L", size)
        middle = (font.size / 2, size[1] / 2)
        ImageDraw.Draw(mask).text(middle, text, 255, font, anchor="lm")
        self._paint(mask, corner, "white")

    def _font(self, text: str) -> FreeTypeFont:
        """Return a font that can be read in this picture, smaller if the text does not fit."""
        size = max(round(24 * self._unit), 11)
        share = (self._size[0] - size) / _font(size).getlength(text)
        return _font(max(int(min(share, 1) * size), 8))

    def _pixels(self, places: Floats) -> Floats:
        """Return the pixels of places, NaN where there are none near the picture."""
        pixels = np.full(places.shape, np.nan)
        known = np.isfinite(places).all(axis=1)
        pixels[known] = self._map.to_pixel(places[known])
        is_near = (np.abs(pixels) < 4 * max(self._size)).all(axis=1)
        return np.where(is_near[:, None], pixels, np.nan)

    def _stroke(self, pixels: Floats, color: str, width: float) -> None:
        """Draw a line through pixels (N, 2); a white edge shows it on any floor."""
        if len(pixels) < 2 or np.isnan(pixels).any():
            return
        line, edge = max(width * self._unit, 1.5), max(self._unit, 0.5)
        box = self._around(pixels, reach=line / 2 + edge)
        if box[0] >= box[2] or box[1] >= box[3]:
            return
        # Integers are the centres of pixels, here and in the finer picture.
        fine = ((pixels - box[:2] + 0.5) * FINENESS - 0.5).ravel().tolist()
        for ink, thickness in (("white", line + 2 * edge), (color, line)):
            mask = Image.new("L", (FINENESS * (box[2] - box[0]), FINENESS * (box[3] - box[1])))
            ImageDraw.Draw(mask).line(fine, 255, round(FINENESS * thickness), joint="curve")
            self._paint(mask.reduce(FINENESS), box[:2], ink)

    def _paint(self, mask: Image.Image, corner: tuple[int, int], color: str) -> None:
        """Colour the picture where the mask, whose upper left corner is given, is not 0."""
        part = self.image[corner[1] :, corner[0] :][: mask.height, : mask.width]
        cover = np.asarray(mask)[: part.shape[0], : part.shape[1]]
        covered = np.divmod(np.flatnonzero(cover > 0), cover.shape[1])  # faster than nonzero
        share = cover[covered][:, None] / 255
        ink = 255 * np.array(to_rgb(color))
        part[covered] = np.rint((1 - share) * part[covered] + share * ink)

    def _around(self, pixels: Floats, reach: float) -> tuple[int, int, int, int]:
        """Return the part of the picture that these pixels and what is near them lie in."""
        left, top = np.floor(np.maximum(pixels.min(axis=0) - reach, 0)).astype(int).tolist()
        farthest = np.minimum(pixels.max(axis=0) + reach + 1, self._size)
        right, bottom = np.ceil(farthest).astype(int).tolist()
        return left, top, right, bottom


@cache
def _font(size: int) -> FreeTypeFont:
    font = ImageFont.load_default(size)
    if not isinstance(font, FreeTypeFont):
        raise ImportError("text on pictures needs a Pillow with FreeType")
    return font


def _closed(corners: Floats) -> Floats:
    """Return the corners of a ring; the line goes on over the first, to make it a joint."""
    return np.vstack((corners, corners[:2]))


def _places(path: ArrayLike) -> Floats:
    places = np.asarray(path, dtype=np.float64)
    if places.ndim != 2 or places.shape[1] != 2:
        raise ValueError(f"path: expected the shape (N, 2), got {places.shape}")
    return places
