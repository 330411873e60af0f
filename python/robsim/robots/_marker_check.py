"""Whether the colours of a robot's markers are seen."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from os import PathLike

import numpy as np

from robsim._base.check_report import CheckReport, Problem
from robsim._base.checks import Floats
from robsim._core import Blob, ColorClass, PlaneMap, find_blobs, locate, rgb_to_yuv
from robsim.imaging._images import Pixels, resized
from robsim.imaging._shading import darkened
from robsim.robots._definition import RobotDefinition
from robsim.robots._polygons import area_and_centroid, mask
from robsim.vision._color_files import as_colors

#: What stands for the floor behind an image: neutral grey.
GREY = 128

#: The least area of a blob that `find_blobs` returns (px of the frame).
LEAST_AREA = 12

_LEAST_SHARE = 0.6
_FARTHEST = 2.0  # work-area px from a blob to its polygon
_MARGIN = 4  # px around the image, so that nothing touches its border


def check_colors(
    robot: RobotDefinition,
    colors: str | PathLike[str] | Iterable[ColorClass] | None = None,
) -> CheckReport:
    """Check whether the camera finds a robot by its markers' colours.

    The image is looked at in the size that it has on the work area, lit and in the shadow.

    Parameters
    ----------
    robot : RobotDefinition
        The robot.
    colors : path or iterable of ColorClass, optional
        Colour file or classes. Default: the colours that ship with robsim.

    Returns
    -------
    CheckReport
        True if the markers are seen; else its `sentences` say why not.
    """
    classes = {color.name: color for color in as_colors(colors)}
    sentences = _problems(_View(robot), classes)
    if not sentences:
        shaded = replace(robot, image=_in_shadow(robot.image))
        sentences = [f"in the shadow: {problem}" for problem in _problems(_View(shaded), classes)]
    problems = (Problem(kind="marker not seen", sentence=sentence) for sentence in sentences)
    return CheckReport(name=f"the robot {robot.name}", problems=tuple(problems))


def _in_shadow(image: Pixels) -> Pixels:
    return np.dstack((darkened(image[..., :3]), image[..., 3]))


def _problems(view: _View, classes: dict[str, ColorClass]) -> list[str]:
    problems = []
    for name in ("red", "blue"):
        if name not in classes:
            problems.append(f"{name} marker: the colours have no {name}, but {', '.join(classes)}")
        elif problem := view.problem(name, classes[name]):
            problems.append(f"{name} marker: {problem}")
    return problems or view.not_located([classes["red"], classes["blue"]])


def over_grey(image: Pixels) -> Pixels:
    """Return the RGBA image as RGB before a grey floor."""
    alpha = image[..., 3:].astype(np.float32) / 255
    mixed = image[..., :3] * alpha + GREY * (1 - alpha)
    return np.rint(mixed).astype(np.uint8)


def ranges(color: ColorClass) -> str:
    """Return the ranges of a colour in words."""
    y, u, v = (f"{low}..{high}" for low, high in (color.y, color.u, color.v))
    return f"Y {y}, U {u}, V {v}"


class _View:
    """The robot's image in the camera's size, with a margin."""

    def __init__(self, definition: RobotDefinition) -> None:
        self.definition = definition
        height, width = definition.image.shape[:2]
        # Not larger than it is: that would show nothing more.
        new_width = max(1, min(width, round(definition.size)))
        new_height = max(1, round(height * new_width / width))
        small = resized(definition.image, new_width, new_height)
        self.scale = np.array((new_width / width, new_height / height))
        self.unit = definition.size / new_width  # work-area px that a pixel stands for
        margin = ((_MARGIN, _MARGIN), (_MARGIN, _MARGIN), (0, 0))
        self.pixels = np.pad(over_grey(small), margin, constant_values=GREY)

    def to_view(self, polygon: Floats) -> Floats:
        """Return the polygon of the image in px of the view."""
        places: Floats = (polygon + 0.5) * self.scale - 0.5 + _MARGIN
        return places

    def problem(self, name: str, color: ColorClass) -> str | None:
        """Return what keeps a marker from being seen."""
        polygon = self.to_view(getattr(self.definition, name))
        area, centroid = area_and_centroid(polygon)
        if area * self.unit**2 < LEAST_AREA:
            return (
                f"it is too small to be seen, {area * self.unit**2:.1f} px of the work area, at "
                f"least {LEAST_AREA} are needed: make the robot's size larger"
            )
        height, width = self.pixels.shape[:2]
        inside = rgb_to_yuv(self.pixels)[mask(polygon, width, height)].astype(int)
        limits = np.array((color.y, color.u, color.v))
        share = ((inside >= limits[:, 0]) & (inside <= limits[:, 1])).all(axis=1).mean()
        if share < _LEAST_SHARE:
            y, u, v = inside.mean(axis=0)
            return (
                f"{100 * share:.1f} % of its polygon has the colour {color.name}, "
                f"{100 * _LEAST_SHARE:.0f} % is needed; the mean there is Y {y:.0f}, U {u:.0f}, "
                f"V {v:.0f}, but {color.name} is {ranges(color)}"
            )
        return self._elsewhere(color, area, centroid)

    def _elsewhere(self, color: ColorClass, area: float, centroid: Floats) -> str | None:
        blobs = self._blobs([color])[color.name]
        if not blobs:
            return "no blob of the colour is large enough to be seen"
        away = [float(np.linalg.norm(blob.centroid - centroid)) * self.unit for blob in blobs]
        blob = blobs[int(np.argmin(away))]
        factor = max(blob.area / area, area / blob.area)
        if factor > self.definition.marker_layout().area_tolerance:
            return (
                f"the blob seen there has {blob.area * self.unit**2:.0f} px of the work area, its "
                f"polygon {area * self.unit**2:.0f}: draw it around all that has the colour"
            )
        if min(away) > _FARTHEST:
            right, down = (blob.centroid - _MARGIN + 0.5) / self.scale - 0.5
            return (
                f"the blob seen there has its centroid at ({right:.5g}, {down:.5g}), "
                f"{min(away):.1f} px of the work area away from that of the polygon"
            )
        return None

    def not_located(self, colors: list[ColorClass]) -> list[str]:
        """Return a sentence if the markers are seen, but the robot is not located by them."""
        plane_map = PlaneMap.scaled(
            (self.pixels.shape[1], self.pixels.shape[0]),
            (self.pixels.shape[1] * self.unit, self.pixels.shape[0] * self.unit),
        )
        blobs = self._blobs(colors)
        if locate(blobs, self.definition.marker_layout(), plane_map) is not None:
            return []
        counts = ", ".join(f"{len(found)} {name}" for name, found in blobs.items())
        return [
            "the markers are seen, but the robot is not found by them: their blobs do not fit the "
            f"polygons well enough, or others of the colours ({counts}) fit as well"
        ]

    def _blobs(self, colors: list[ColorClass]) -> dict[str, list[Blob]]:
        least = max(1, round(LEAST_AREA / self.unit**2))
        return find_blobs(self.pixels, colors, minimum_area=least)
