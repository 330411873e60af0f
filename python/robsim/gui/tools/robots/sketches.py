"""What a robot's drawing begins with: a robot that there is, or a picture, with first guesses."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from robsim._core import ColorClass
from robsim.base.checks import Floats
from robsim.gui.tools.opening import over_floor
from robsim.gui.tools.robots.drawing import OUTLINE, RobotDrawing, Sketch
from robsim.gui.tools.robots.guess import guess_marker, guess_outline
from robsim.vision.imaging.images import Pixels, resized
from robsim.vision.robots.definition import RobotDefinition, by_color
from robsim.vision.robots.finding import MAXIMUM_SIDE, OPAQUE, opaque_outline


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
