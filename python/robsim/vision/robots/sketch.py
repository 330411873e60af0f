"""A robot under construction: its picture and polygons, guesses of polygons, its problems."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sized
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from robsim._core import ColorClass, Frame, find_blobs, rgb_to_yuv
from robsim.base.checks import Floats
from robsim.base.text import quoted
from robsim.vision.imaging.images import Pixels, resized
from robsim.vision.robots.definition import (
    DEFAULT_COLORS,
    RobotDefinition,
    by_color,
    from_colors,
    roles_by_color,
)
from robsim.vision.robots.finding import (
    MAXIMUM_SIDE,
    OPAQUE,
    marker_in,
    opaque_outline,
    pixels_of_blob,
)
from robsim.vision.robots.polygon_checks import finite_array, geometry_problems, polygon
from robsim.vision.robots.polygons import area_and_centroid, mask

#: The part that is no marker.
OUTLINE = "outline"
_FEWEST, _MOST = 3, 200  # corners
_FLOOR = 150  # level of the floor below a robot's picture


@dataclass(frozen=True, eq=False)
class Sketch:
    """A robot under definition; a missing polygon has no corners.

    `image` (h, w, 4) is uint8 RGBA, `size` its width on the work area (px), `alignment` (degrees)
    the clockwise rotation that makes the robot face right. `outline` (N, 2) and `markers`, by
    colour, are polygons in image px; roles follow from positions. `centre` (2,) is in image px, by
    default the outline's.
    """

    image: Pixels = field(repr=False)
    size: float
    alignment: float = 0.0
    outline: Floats = field(default_factory=lambda: np.empty((0, 2)), repr=False)
    markers: Mapping[str, Floats] = field(
        default_factory=lambda: {color: np.empty((0, 2)) for color in DEFAULT_COLORS}, repr=False
    )
    centre: Floats | None = None
    maximum_blobs: int = RobotDefinition.maximum_blobs

    @classmethod
    def of(cls, robot: RobotDefinition) -> Sketch:
        """Return the sketch of a complete robot."""
        names = ("image", "size", "alignment", "centre", "maximum_blobs", "outline")
        return cls(markers=by_color(robot), **{name: getattr(robot, name) for name in names})

    @classmethod
    def of_picture(cls, pixels: Pixels, size: float, colors: Iterable[ColorClass]) -> Sketch:
        """Return a picture (h, w, 3 or 4), of robots' size at most, with guesses of its parts.

        `size` is its width on the work area (px). ValueError: the picture is fully transparent.
        """
        sketch = cls(_with_alpha(_reduced(pixels)), size=size)
        if is_cut_out(sketch.image):
            sketch = sketch.guessed(OUTLINE, colors)
        for part, corners in sketch.parts.items():
            if not len(corners):
                try:
                    sketch = sketch.guessed(part, colors)
                except ValueError:
                    break  # it is drawn by hand
        return sketch

    @property
    def parts(self) -> dict[str, Floats]:
        """The polygons, in the order of drawing: the outline, markers by colour."""
        return {OUTLINE: self.outline, **self.markers}

    @property
    def roles(self) -> dict[str, str]:
        """The roles of the markers by their colours; empty until both are drawn."""
        if any(len(corners) < _FEWEST for corners in self.markers.values()):
            return {}
        return roles_by_color(self.markers, self.alignment)

    def called(self, part: str) -> str:
        """Return the name of a part in a sentence, such as "right marker (red)"."""
        if part == OUTLINE:
            return part
        role = self.roles.get(part)
        return f"{role} marker ({part})" if role else f"{part} marker"

    @property
    def middle(self) -> Floats:
        """The robot's centre: the given one, or else the outline's, or else the picture's."""
        if self.centre is not None:
            return self.centre
        if len(self.outline) >= _FEWEST:
            return area_and_centroid(self.outline)[1]
        height, width = self.image.shape[:2]
        return np.array(((width - 1) / 2, (height - 1) / 2))

    def part(self, name: str) -> Floats:
        """Return the polygon of a part; raise ValueError if the name is unknown."""
        if not isinstance(name, str) or name not in self.parts:
            raise ValueError(f"part must be one of {', '.join(self.parts)}, got {quoted(name)}")
        return self.parts[name]

    def with_part(self, name: str, polygon: Any) -> Sketch:
        """Return a sketch with a polygon (N, 2) of up to 200 corners, or none, for a part."""
        is_empty = isinstance(polygon, Sized) and len(polygon) == 0
        corners = np.empty((0, 2)) if is_empty else finite_array("polygon", polygon, (-1, 2))
        if len(corners) > _MOST:
            raise ValueError(f"polygon must have at most {_MOST} corners, got {len(corners)}")
        self.part(name)
        if name == OUTLINE:
            return replace(self, outline=np.array(corners), centre=None)
        return replace(self, markers={**self.markers, name: np.array(corners)})

    def guessed(self, part: str, colors: Iterable[ColorClass]) -> Sketch:
        """Return a sketch with a part found in the picture; ValueError if it is not found."""
        if part == OUTLINE and is_cut_out(self.image):
            return self.with_part(part, opaque_outline(self.image))
        image = over_floor(self.image).image
        if part == OUTLINE:
            return self.with_part(part, guess_outline(image))
        return self.with_part(part, guess_marker(image, self.outline, part, colors))

    def problems(self) -> list[str]:
        """Return the problems, a sentence each; empty: the sketch is a robot."""
        missing = [part for part, corners in self.parts.items() if len(corners) < _FEWEST]
        if missing:
            return [f"{self.called(part)} needs at least {_FEWEST} corners" for part in missing]
        height, width = self.image.shape[:2]
        try:  # without corners that lie on each other
            outline = polygon(OUTLINE, self.outline)
            markers = {
                self.called(color): polygon(self.called(color), corners)
                for color, corners in self.markers.items()
            }
        except ValueError as error:
            return [str(error)]
        return geometry_problems(
            width=width, height=height, centre=self.middle, outline=outline, markers=markers
        )

    def definition(self, name: str) -> RobotDefinition:
        """Return the robot; ValueError if something is missing or wrong."""
        if problems := self.problems():
            raise ValueError("; ".join(problems))
        return from_colors(
            self.markers,
            self.alignment,
            name=name,
            image=self._cut_out(),
            size=self.size,
            centre=self.middle,
            outline=self.outline,
            maximum_blobs=self.maximum_blobs,
        )

    def _cut_out(self) -> Pixels:
        """Return the picture; if it is opaque, make all outside the outline transparent."""
        if (self.image[..., 3] < 255).any():
            return self.image
        height, width = self.image.shape[:2]
        inside = mask(self.outline, width, height)
        return np.dstack([self.image[..., :3], np.where(inside, 255, 0).astype(np.uint8)])


def is_cut_out(pixels: Pixels) -> bool:
    """Return whether a picture (h, w, 3 or 4) shows a robot with transparent surroundings."""
    return pixels.shape[2] == 4 and bool((pixels[..., 3] <= OPAQUE).any())


def over_floor(image: Pixels) -> Frame:
    """Return a picture (h, w, 3 or 4) on a grey floor."""
    if image.shape[2] == 3 or (image[..., 3] == 255).all():
        return Frame(np.ascontiguousarray(image[..., :3]))
    alpha = image[..., 3:].astype(np.uint16)  # in which 255 x 255 has room
    # alpha / 255 x colour + (1 - alpha / 255) x floor, rounded
    shown = (alpha * image[..., :3] + (255 - alpha) * np.uint16(_FLOOR) + 127) // 255
    return Frame(shown.astype(np.uint8))


_RIM = 0.06  # of the shorter side: the floor
_SIGMA = 1.4826  # of a normal distribution, by its median absolute deviation
_LEAST_SPREAD = 3.0  # levels
_FAR = 6.0  # spreads from the floor
_WINDOW = 0.07  # of the shorter side; noise, and seams of the floor, are no robot
_PAINT = (255, 0, 0)
_PAINTED = ColorClass("painted", v=(200, 255))


def guess_outline(image: Pixels) -> Floats:
    """Return the convex polygon around objects that stand out from the floor at the picture's rim.

    The image (h, w, 3) is RGB uint8, with the robot inside. ValueError: nothing stands out.
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
        raise ValueError(
            "no object differs from the floor at the edges of the picture: draw the outline"
        )
    across, down = pixels_of_blob(blobs[0], painted, _PAINTED).astype(int).T
    alpha = np.zeros((*image.shape[:2], 4), np.uint8)
    alpha[down, across, 3] = 255
    return opaque_outline(alpha)


def guess_marker(image: Pixels, outline: Floats, name: str, colors: Iterable[ColorClass]) -> Floats:
    """Return a polygon around the largest blob of a colour in an outline; ValueError: no blob."""
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


def _reduced(image: Pixels) -> Pixels:
    height, width = image.shape[:2]
    factor = min(1.0, MAXIMUM_SIDE / max(height, width))
    return resized(image, *(max(1, round(factor * side)) for side in (width, height)))


def _with_alpha(image: Pixels) -> Pixels:
    if image.shape[2] == 4:
        return np.array(image)
    return np.dstack([image, np.full(image.shape[:2], 255, np.uint8)])
