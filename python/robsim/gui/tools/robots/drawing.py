"""A robot while it is drawn: its picture, polygons, heading and size; each change can be undone."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sized
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from robsim._core import ColorClass, find_blobs, rgb_to_yuv
from robsim.base.checks import Floats, check_float, check_int
from robsim.base.polygons import area_and_centroid, mask
from robsim.base.text import quoted
from robsim.gui.tools.history import History
from robsim.gui.tools.pictures import over_floor
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

#: The part that is no marker.
OUTLINE = "outline"
_FEWEST, _MOST = 3, 200  # corners


@dataclass(frozen=True, eq=False)
class Sketch:
    """What there is of a robot; a polygon that is not drawn yet has no corners.

    Attributes
    ----------
    image : array (h, w, 4) of uint8
        RGBA.
    size : float
        Width of the image on the work area (px).
    alignment : float
        Clockwise rotation of the image (degrees) after which the robot faces right.
    outline : array (N, 2)
        Polygon (image px).
    markers : dict of str to array (N, 2)
        Polygons of both markers by their colours (image px): their roles follow from where they
        lie.
    centre : array (2,) or None
        The robot's centre (image px). None = that of the outline.
    maximum_blobs : int
        As of `RobotDefinition`.
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

    @property
    def parts(self) -> dict[str, Floats]:
        """The polygons, in the order in which they are drawn: the outline, markers by colour."""
        return {OUTLINE: self.outline, **self.markers}

    @property
    def roles(self) -> dict[str, str]:
        """The roles of the markers by their colours; empty until both are drawn."""
        if any(len(corners) < _FEWEST for corners in self.markers.values()):
            return {}
        return roles_by_color(self.markers, self.alignment)

    def called(self, part: str) -> str:
        """Return what a part is called in a sentence, such as "right marker (red)"."""
        if part == OUTLINE:
            return part
        role = self.roles.get(part)
        return f"{role} marker ({part})" if role else f"{part} marker"


class RobotDrawing(History[Sketch]):
    """A robot while it is drawn.

    Parameters
    ----------
    sketch : Sketch
        What there is already.
    """

    @property
    def sketch(self) -> Sketch:
        """What there is now."""
        return self._now

    # Corners.

    def put(self, part: str, polygon: Any) -> None:
        """Draw a polygon in place of what is there; none = nothing is drawn.

        Raises
        ------
        TypeError, ValueError
            If there is no such part, or it is no array (N, 2) of at most 200 corners.
        """
        is_empty = isinstance(polygon, Sized) and len(polygon) == 0
        corners = np.empty((0, 2)) if is_empty else finite_array("polygon", polygon, (-1, 2))
        if len(corners) > _MOST:
            raise ValueError(f"polygon must have at most {_MOST} corners, got {len(corners)}")
        self._change(self._with(part, np.array(corners)))

    def move(self, part: str, corner: int, to: Any, *, goes_on: bool = False) -> None:
        """Move a corner; `goes_on`: it is the same change as the one before, undone with it."""
        corners = self._polygon(part).copy()
        corners[self._index(part, corner)] = finite_array("to", to, (2,))
        self._change(self._with(part, corners), goes_on=goes_on)

    def insert(self, part: str, corner: int, at: Any) -> None:
        """Insert a corner before another one; as many as there are = behind the last one."""
        corners = self._polygon(part)
        corner = check_int("corner", corner, minimum=0, maximum=len(corners))
        self.put(part, np.insert(corners, corner, finite_array("at", at, (2,)), axis=0))

    def remove(self, part: str, corner: int) -> None:
        self.put(part, np.delete(self._polygon(part), self._index(part, corner), axis=0))

    # The whole.

    def turn(self, degrees: float) -> None:
        """Turn the heading: the robot faces right after so much more of a clockwise rotation."""
        turned = self.sketch.alignment + check_float("degrees", degrees, "degrees")
        self._change({"alignment": float(np.remainder(turned + 180, 360) - 180)})

    def face(self, towards: Any, *, goes_on: bool = False) -> None:
        """Let the robot face a point of the picture, as seen from its centre."""
        right, down = finite_array("towards", towards, (2,)) - self.centre
        if np.hypot(right, down) < 1:
            raise ValueError("towards must lie beside the centre of the robot")
        alignment = float(-np.degrees(np.arctan2(down, right)))
        self._change({"alignment": alignment}, goes_on=goes_on)

    def resize(self, size: float) -> None:
        """Set the width of the picture on the work area (px)."""
        self._change({"size": check_float("size", size, "px", minimum=1, maximum=10_000)})

    def scale(self, one: Any, other: Any, distance: float) -> None:
        """Set the size by two points of the picture that are so far apart (work-area px)."""
        distance = check_float("distance", distance, "px", exclusive_minimum=0, maximum=10_000)
        apart = finite_array("other", other, (2,)) - finite_array("one", one, (2,))
        pixels = float(np.hypot(*apart))
        if pixels < 1:
            raise ValueError("one and other must be a pixel apart, at least")
        self.resize(distance / pixels * self.sketch.image.shape[1])

    @property
    def centre(self) -> Floats:
        """The robot's centre: its own, or that of an outline that was drawn, or of the picture."""
        if self.sketch.centre is not None:
            return self.sketch.centre
        outline = self.sketch.outline
        if len(outline) >= _FEWEST:
            return area_and_centroid(outline)[1]
        height, width = self.sketch.image.shape[:2]
        return np.array(((width - 1) / 2, (height - 1) / 2))

    # What it is.

    def problems(self) -> list[str]:
        """Return what is missing or wrong, a sentence each; empty: it is a robot."""
        sketch = self.sketch
        missing = [part for part, corners in sketch.parts.items() if len(corners) < _FEWEST]
        if missing:
            return [f"{sketch.called(part)} needs {_FEWEST} corners at least" for part in missing]
        height, width = sketch.image.shape[:2]
        try:  # without corners that lie on each other
            outline = polygon(OUTLINE, sketch.outline)
            markers = {
                sketch.called(color): polygon(sketch.called(color), corners)
                for color, corners in sketch.markers.items()
            }
        except ValueError as error:
            return [str(error)]
        return geometry_problems(
            width=width,
            height=height,
            centre=self.centre,
            outline=outline,
            markers=markers,
        )

    def definition(self, name: str) -> RobotDefinition:
        """Return the robot; ValueError if something is missing or wrong."""
        if problems := self.problems():
            raise ValueError("; ".join(problems))
        sketch = self.sketch
        return from_colors(
            sketch.markers,
            sketch.alignment,
            name=name,
            image=self._cut_out(),
            size=sketch.size,
            centre=self.centre,
            outline=sketch.outline,
            maximum_blobs=sketch.maximum_blobs,
        )

    def _cut_out(self) -> Pixels:
        """Return the picture; what surrounds the robot in one without transparency is cut off."""
        image = self.sketch.image
        if (image[..., 3] < 255).any():
            return image
        height, width = image.shape[:2]
        inside = mask(self.sketch.outline, width, height)
        return np.dstack([image[..., :3], np.where(inside, 255, 0).astype(np.uint8)])

    def _polygon(self, part: str) -> Floats:
        return self.sketch.parts[self.checked(part)]

    def _with(self, part: str, corners: Floats) -> dict[str, Any]:
        """Return the change of the sketch that draws a part."""
        if self.checked(part) == OUTLINE:
            return {"outline": corners}
        return {"markers": {**self.sketch.markers, part: corners}}

    def checked(self, part: str) -> str:
        """Return the name of a part; ValueError if there is none of that name."""
        parts = self.sketch.parts
        if not isinstance(part, str) or part not in parts:
            raise ValueError(f"part must be one of {', '.join(parts)}, got {quoted(part)}")
        return part

    def _index(self, part: str, corner: int) -> int:
        return check_int("corner", corner, minimum=0, maximum=len(self._polygon(part)) - 1)

    def _change(self, changes: dict[str, Any], *, goes_on: bool = False) -> None:
        if "outline" in changes:
            changes["centre"] = None
        self.go_to(replace(self.sketch, **changes), goes_on=goes_on)


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


def sketch_of(robot: RobotDefinition) -> Sketch:
    """Return what there is of a robot."""
    names = ("image", "size", "alignment", "centre", "maximum_blobs", "outline")
    return Sketch(markers=by_color(robot), **{name: getattr(robot, name) for name in names})


def is_cut_out(pixels: Pixels) -> bool:
    """Return whether a picture (h, w, 3 or 4) shows a robot with transparent surroundings."""
    return pixels.shape[2] == 4 and bool((pixels[..., 3] <= OPAQUE).any())


def sketch_of_picture(pixels: Pixels, size: float, colors: Iterable[ColorClass]) -> Sketch:
    """Return a picture (h, w, 3 or 4) with first guesses of all parts, as far as they are found.

    One that is larger than robots are is scaled down.

    Parameters
    ----------
    size : float
        Its width on the work area (px).
    colors : iterable of ColorClass
        Those of the markers.

    Raises
    ------
    ValueError
        If it is transparent everywhere.
    """
    drawing = RobotDrawing(Sketch(_with_alpha(_reduced(pixels)), size=size))
    if is_cut_out(drawing.sketch.image):
        drawing.put(OUTLINE, opaque_outline(drawing.sketch.image))
    for part, corners in drawing.sketch.parts.items():
        if not len(corners):
            try:
                drawing.put(part, guessed(drawing.sketch, part, colors))
            except ValueError:
                break  # it is drawn by hand
    return drawing.sketch


def guessed(sketch: Sketch, part: str, colors: Iterable[ColorClass]) -> Floats:
    """Return a part as it is found in the picture; ValueError if it is not."""
    if part == OUTLINE and is_cut_out(sketch.image):
        return opaque_outline(sketch.image)
    image = over_floor(sketch.image).image
    if part == OUTLINE:
        return guess_outline(image)
    return guess_marker(image, sketch.outline, part, colors)


def cut_out(image: Pixels, square: tuple[float, float, float]) -> Pixels:
    """Return what a square of a picture shows: its centre and side (px)."""
    u, v, side = square
    count = round(side)
    left, top = (round(middle - side / 2) for middle in (u, v))
    height, width = image.shape[:2]
    left, top = min(max(left, 0), width - count), min(max(top, 0), height - count)
    return np.array(image[top : top + count, left : left + count])


def _reduced(image: Pixels) -> Pixels:
    height, width = image.shape[:2]
    factor = min(1.0, MAXIMUM_SIDE / max(height, width))
    return resized(image, *(max(1, round(factor * side)) for side in (width, height)))


def _with_alpha(image: Pixels) -> Pixels:
    if image.shape[2] == 4:
        return np.array(image)
    return np.dstack([image, np.full(image.shape[:2], 255, np.uint8)])
