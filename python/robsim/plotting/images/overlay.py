"""`draw_overlay`: vision and estimation results drawn onto a frame's pixels, for videos."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import cache

import numpy as np
from matplotlib.colors import to_rgb
from numpy.typing import ArrayLike
from PIL import Image, ImageDraw, ImageFont
from PIL.ImageFont import FreeTypeFont

from robsim._core import Blob, Estimate, Frame, Measurement
from robsim.base.checks import Floats, check_text
from robsim.plotting import style as style
from robsim.plotting.style import check_blobs, check_optional, check_positions, check_source
from robsim.vision.imaging.images import Pixels
from robsim.vision.robots.polygons import placed

HEADING_LINE = 80.0  # length of a heading's line (work-area px)


def heading_line(pose: Floats) -> Floats:
    """Return both ends (2, 2) of the line from a pose's position along its heading."""
    return placed(np.array(((0.0, 0.0), (HEADING_LINE, 0.0))), pose)


def placed_outline(outline: ArrayLike, pose: Floats) -> Floats:
    """Return an outline (N, 2) in robot axes (x forward, y right) at a pose (3,), in area px."""
    return placed(check_positions("outline", outline), pose)


def box_corners(blob: Blob) -> Floats:
    """Return the corners (4, 2) of the box around a blob (pixels), at its pixels' outer edges."""
    left, top, right, bottom = np.add(blob.bounding_box, (-0.5, -0.5, 0.5, 0.5))
    return np.array([(left, top), (right, top), (right, bottom), (left, bottom)])


SHADE = 0.35  # brightness of the image under the text
SUPERSAMPLING = 3  # lines are drawn larger by this factor, then reduced, against jagged edges


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
    """Draw the results of vision and estimation onto a copy of a frame's pixels, for a video.

    Parameters
    ----------
    frame : Frame
        The image with its plane map.
    measurement : Measurement, optional
        The measured pose, green: a line from the centre along the heading. With `blobs` and no
        measurement, the image shows "not seen".
    blobs : dict of str to sequence of Blob, optional
        The blobs of each colour, as from `robsim.find_blobs`: each gets its bounding box.
    outline : array_like (N, 2), optional
        Outline of the robot in its own axes, x forward and y to the right (work-area px). The
        outline is drawn at the measured pose and at the estimated pose.
    path : array_like (N, 2), optional
        The positions measured up to now (work-area px), drawn as a green line. NaN breaks it.
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
    TypeError, ValueError
        If an argument has the wrong type, or `outline` or `path` is not of shape (N, 2).

    Examples
    --------
    >>> sim = robsim.Simulation(seed=1, measure=True)
    >>> step = sim.step()
    >>> image = robsim.plotting.draw_overlay(step.frame, measurement=step.measurement)
    >>> image.shape, bool((image != np.asarray(step.frame)).any())
    ((1200, 1200, 3), True)
    """
    check_source("frame", frame, Frame)
    check_optional("measurement", measurement, Measurement)
    check_blobs(blobs)
    check_optional("estimate", estimate, Estimate)
    contour = None if outline is None else check_positions("outline", outline)
    canvas = _Canvas(frame)
    if path is not None:
        canvas.trail(check_positions("path", path), style.MEASURED)
    for color, found in (blobs or {}).items():
        for blob in found:
            canvas.box(box_corners(blob), style.drawn_color(color))
    if estimate is not None:
        canvas.pose(estimate.pose, contour, style.ESTIMATED)
        canvas.cross(estimate.pose, style.ESTIMATED)
    if measurement is not None:
        canvas.pose(measurement.pose, contour, style.MEASURED)
    elif blobs is not None:
        canvas.label("not seen", style.WRONG)
    if text is not None:
        canvas.caption(check_text("text", text))
    return canvas.image


class _Canvas:
    """The image to draw on. Line widths are for a frame of 1200 px."""

    def __init__(self, frame: Frame) -> None:
        # Whole images are slow to convert from Pillow: it draws masks, which are painted here.
        self.image = frame.image.copy()
        self._size = self.image.shape[1], self.image.shape[0]
        self._map = frame.plane_map
        self._unit = min(self._size) / 1200

    def trail(self, positions: Floats, color: str) -> None:
        # It may have thousands of points: drawn without supersampling.
        pixels = self._pixels(positions)
        mask = Image.new("L", self._size)
        for segment in np.split(pixels, np.flatnonzero(np.isnan(pixels[:, 0]))):
            known = segment[~np.isnan(segment[:, 0])].ravel().tolist()
            ImageDraw.Draw(mask).line(known, 255, max(round(2 * self._unit), 1))
        self._paint(mask, (0, 0), color)

    def box(self, corners: Floats, color: str) -> None:
        self._stroke(_closed(corners), color, 2)

    def pose(self, pose: Floats, outline: Floats | None, color: str) -> None:
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
        """Return a font that is legible in this image, smaller if the text does not fit."""
        size = max(round(30 * self._unit), 11)
        scale = (self._size[0] - size) / _font(size).getlength(text)
        return _font(max(int(min(scale, 1) * size), 8))

    def _pixels(self, positions: Floats) -> Floats:
        """Return the pixels of positions, NaN far from the image."""
        pixels = np.full(positions.shape, np.nan)
        known = np.isfinite(positions).all(axis=1)
        pixels[known] = self._map.to_pixel(positions[known])
        is_near = (np.abs(pixels) < 4 * max(self._size)).all(axis=1)
        return np.where(is_near[:, None], pixels, np.nan)

    def _stroke(self, pixels: Floats, color: str, width: float) -> None:
        """Draw a line through pixels (N, 2); a white edge keeps it visible on any floor."""
        if len(pixels) < 2 or np.isnan(pixels).any():
            return
        line, edge = max(width * self._unit, 1.5), max(self._unit, 0.5)
        box = self._around(pixels, margin=line / 2 + edge)
        if box[0] >= box[2] or box[1] >= box[3]:
            return
        # Integers are the centres of pixels, here and in the supersampled mask.
        fine = ((pixels - box[:2] + 0.5) * SUPERSAMPLING - 0.5).ravel().tolist()
        for ink, thickness in (("white", line + 2 * edge), (color, line)):
            mask = Image.new(
                "L", (SUPERSAMPLING * (box[2] - box[0]), SUPERSAMPLING * (box[3] - box[1]))
            )
            ImageDraw.Draw(mask).line(fine, 255, round(SUPERSAMPLING * thickness), joint="curve")
            self._paint(mask.reduce(SUPERSAMPLING), box[:2], ink)

    def _paint(self, mask: Image.Image, corner: tuple[int, int], color: str) -> None:
        """Blend a colour into the image by a mask whose upper left corner is given."""
        part = self.image[corner[1] :, corner[0] :][: mask.height, : mask.width]
        cover = np.asarray(mask)[: part.shape[0], : part.shape[1]]
        covered = np.divmod(np.flatnonzero(cover > 0), cover.shape[1])  # faster than nonzero
        alpha = cover[covered][:, None] / 255
        ink = 255 * np.array(to_rgb(color))
        part[covered] = np.rint((1 - alpha) * part[covered] + alpha * ink)

    def _around(self, pixels: Floats, margin: float) -> tuple[int, int, int, int]:
        """Return the bounding box of these pixels with a margin, clipped to the image."""
        left, top = np.floor(np.maximum(pixels.min(axis=0) - margin, 0)).astype(int).tolist()
        maximum = np.minimum(pixels.max(axis=0) + margin + 1, self._size)
        right, bottom = np.ceil(maximum).astype(int).tolist()
        return left, top, right, bottom


@cache
def _font(size: int) -> FreeTypeFont:
    font = ImageFont.load_default(size)
    if not isinstance(font, FreeTypeFont):
        raise ImportError("text on images needs a Pillow with FreeType")
    return font


def _closed(corners: Floats) -> Floats:
    """Return the corners of a closed line: it ends with its first two, to join the ends."""
    return np.vstack((corners, corners[:2]))
