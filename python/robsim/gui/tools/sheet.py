"""Drawing of the tools' still pictures: a sheet with a picture and a text column."""

from __future__ import annotations

import functools
import math
import textwrap
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from robsim._core import Frame, reduced
from robsim.gui._link import small_png
from robsim.gui.hosts.script import words

Points = Sequence[Sequence[float]]

TEXT, QUIET, LINE = "#1b1f24", "#59626e", "#d8dce2"
ACCENT, CHOSEN, WARNING = "#5750d3", "#e9e8fb", "#8a5a00"
RIM = "#000000"  # under a line, for contrast on any picture

_TIMES = 3  # oversampling against jagged edges
_ALPHA = 200 / 255  # of a class's pixels, on the picture
_FONTS = {"regular": "DejaVuSans", "bold": "DejaVuSans-Bold", "mono": "DejaVuSansMono"}


class Sheet:
    """A white sheet; lengths and positions are in its pixels."""

    def __init__(self, width: int, height: int) -> None:
        self._image = Image.new("RGB", (_TIMES * width, _TIMES * height), "white")
        self._pen = ImageDraw.Draw(self._image)

    def text(
        self,
        at: tuple[float, float],
        line: str,
        *,
        ink: str = TEXT,
        size: float = 12,
        kind: str = "regular",
        right: bool = False,
    ) -> float:
        """Write a line with its middle at a height; return its right end."""
        font = _font(kind, size)
        anchor = "rm" if right else "lm"
        self._pen.text((_TIMES * at[0], _TIMES * at[1]), line, ink, font, anchor=anchor)
        return at[0] + font.getlength(line) / _TIMES

    def paragraph(self, at: tuple[float, float], text: str, width: float, **look: Any) -> float:
        """Write lines up to a width; return the height of the next line."""
        x, y = at
        for row in self.rows(text, width):
            self.text((x, y), row, **look)
            y += 17
        return y

    def length(self, line: str, kind: str = "regular", size: float = 12) -> float:
        return _font(kind, size).getlength(line) / _TIMES

    def rows(self, text: str, width: float) -> list[str]:
        """Return a text in lines up to a width."""
        letter = self.length("n")
        return textwrap.wrap(text, max(8, int(width / letter)))

    def box(
        self,
        sides: tuple[float, float, float, float],
        *,
        fill: str | None = None,
        line: str | None = None,
        radius: float = 0,
    ) -> None:
        """Draw a rectangle: left, top, right, bottom."""
        self._pen.rounded_rectangle(
            [_TIMES * side for side in sides], _TIMES * radius, fill, line, _TIMES if line else 0
        )

    def dot(self, at: tuple[float, float], radius: float, ink: str) -> None:
        x, y = at
        self.box((x - radius, y - radius, x + radius, y + radius), fill=ink, radius=radius)

    def title(self, kind: str, about: str) -> float:
        """Write the name of the tool and its subject; return the right end."""
        end = self.text((6, 16), words(f"tool_title.{kind}"), size=13, kind="bold")
        return self.text((end + 10, 16), about, ink=QUIET)

    def show(self, picture: Shown, width: int, height: int) -> None:
        """Put a picture below the title, in the middle of a box."""
        self.box((6, 34, 6 + width, 34 + height), line=LINE)
        left, top = 6 + (width - picture.size[0]) // 2, 34 + (height - picture.size[1]) // 2
        self._image.paste(picture.image, (_TIMES * left, _TIMES * top))

    def png(self) -> bytes:
        return small_png(self._image.reduce(_TIMES))


class Shown:
    """A frame fitted into a square; drawing uses the frame's pixels."""

    def __init__(self, frame: Frame | None, side: int) -> None:
        pixels = np.full((1, 1, 3), 255, np.uint8) if frame is None else frame.image
        height, width = pixels.shape[:2]
        self.scale = side / max(width, height)
        self.size = (max(1, round(width * self.scale)), max(1, round(height * self.scale)))
        if frame is not None:
            pixels = reduced(frame, 2 * self.size[0])
        fitted = Image.fromarray(pixels).resize(self.size, Image.Resampling.BILINEAR)
        self._enlarge(fitted)

    def _enlarge(self, fitted: Image.Image) -> None:
        self.image = fitted.resize(
            (_TIMES * self.size[0], _TIMES * self.size[1]), Image.Resampling.NEAREST
        )
        self._pen = ImageDraw.Draw(self.image)

    def paint(self, index: np.ndarray[Any, Any], inks: Sequence[Sequence[int]]) -> None:
        """Overlay a mask with the ink number of each pixel, from 1; call this before the lines."""
        at = np.asarray(Image.fromarray(index).resize(self.size, Image.Resampling.NEAREST))
        alpha = (at > 0)[..., None] * _ALPHA
        over = np.array([(0, 0, 0), *inks], float)[at]
        shown = np.asarray(self.image.reduce(_TIMES), float)
        self._enlarge(Image.fromarray(np.rint(shown + alpha * (over - shown)).astype(np.uint8)))

    def line(self, points: Points, ink: str, width: float = 1.5, *, closed: bool = False) -> None:
        """Draw a line with a rim (width in px of the sheet)."""
        if len(points) < 2:
            return
        ends = [*points, points[0], points[1]] if closed else points
        fine = [self._at(point) for point in ends]
        for wide, color in ((width + 1.5, RIM), (width, ink)):
            self._pen.line(fine, color, round(_TIMES * wide), joint="curve")

    def dot(self, point: Sequence[float], ink: str, radius: float = 3.5) -> None:
        """Draw a disk with a rim (radius in px of the sheet)."""
        x, y = self._at(point)
        for size, color in ((radius + 1, RIM), (radius, ink)):
            far = _TIMES * size
            self._pen.ellipse((x - far, y - far, x + far, y + far), color)

    def rectangle(self, sides: Sequence[float], ink: str, width: float = 1.5) -> None:
        """Draw the rectangle around pixels, inclusive: left, top, right, bottom."""
        left, top, right, bottom = np.add(sides, (-0.5, -0.5, 0.5, 0.5)).tolist()
        corners = [(left, top), (right, top), (right, bottom), (left, bottom)]
        self.line(corners, ink, width, closed=True)

    def arrow(self, start: Sequence[float], angle: float, length: float, ink: str) -> None:
        """Draw an arrow (angle in rad, clockwise from the right; length in px of the sheet)."""
        long, barb = length / self.scale, length / 4 / self.scale
        end = _moved(start, angle, long)
        self.line([start, end], ink, 2)
        tips = [_moved(end, angle + math.pi + turn, barb) for turn in (-0.5, 0.5)]
        self.line([tips[0], end, tips[1]], ink, 2)

    def _at(self, point: Sequence[float]) -> tuple[float, float]:
        x, y = (_TIMES * self.scale * (float(one) + 0.5) - 0.5 for one in point[:2])
        return x, y


def _moved(point: Sequence[float], angle: float, by: float) -> tuple[float, float]:
    return point[0] + by * math.cos(angle), point[1] + by * math.sin(angle)


@functools.cache
def _font(kind: str, size: float) -> ImageFont.FreeTypeFont:
    from matplotlib import get_data_path  # slow to load

    folder = Path(get_data_path(), "fonts", "ttf")
    return ImageFont.truetype(str(folder / f"{_FONTS[kind]}.ttf"), _TIMES * size)
