"""Checks that vision finds a robot by the colours of its markers; `add_robot` calls it."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import lru_cache
from os import PathLike

import numpy as np

from robsim._core import (
    Blob,
    ColorClass,
    Detection,
    Frame,
    PlaneMap,
    detect,
    find_blobs,
    rgb_to_yuv,
)
from robsim.base.check_report import CheckReport, Problem
from robsim.base.checks import Floats, check_kind
from robsim.vision.imaging.images import Pixels, darkened, resized
from robsim.vision.markers.color_files import as_colors
from robsim.vision.robots.definition import RobotDefinition
from robsim.vision.robots.polygons import area_and_centroid, mask, placed

#: Grey level of the floor assumed behind an image.
GREY = 128
#: The minimum area of a blob that `find_blobs` returns (px of the frame).
MINIMUM_AREA = 12
_MINIMUM_FRACTION = 0.6  # of a marker polygon that must have the colour
_MAXIMUM_OFFSET = 2.0  # work-area px between the centroids of a blob and its polygon.
_MARGIN = 4  # px around the image, so that no blob touches the border


def check_colors(
    robot: RobotDefinition, colors: str | PathLike[str] | Iterable[ColorClass] | None = None
) -> CheckReport:
    """Check whether the camera finds a robot by its markers' colours.

    The check uses the image at its size on the work area, in light and in shadow.

    Parameters
    ----------
    robot : RobotDefinition
        The robot.
    colors : path or iterable of ColorClass, optional
        Colour file or classes. Default: the colours shipped with robsim.

    Returns
    -------
    CheckReport
        The report; `ok` is True if the robot is found, otherwise `sentences` gives the reasons.

    Raises
    ------
    TypeError, ValueError
        If `robot` is not a RobotDefinition, or `colors` not a colour file or an iterable of
        ColorClass.

    Examples
    --------
    >>> bool(robsim.vision.check_colors(robsim.load_robot("lab")))
    True
    """
    check_kind("robot", robot, RobotDefinition)
    classes = {color.name: color for color in as_colors(colors)}
    sentences = _problems(_View(robot), classes)
    if not sentences:
        dark = darkened(robot.image[..., :3])
        shaded = replace(robot, image=np.dstack((dark, robot.image[..., 3])))
        sentences = [f"in the shadow: {problem}" for problem in _problems(_View(shaded), classes)]
    problems = (Problem(kind="marker not detected", sentence=sentence) for sentence in sentences)
    return CheckReport(name=f"the robot {robot.name}", problems=tuple(problems))


def _problems(view: _View, classes: dict[str, ColorClass]) -> list[str]:
    problems = []
    robot = view.robot
    for role, marker in robot.markers.items():
        name = marker.color
        if name not in classes:
            problems.append(
                f"{role} marker ({name}): unknown colour {name}, known: {', '.join(classes)}; "
                f"use colours with a {name}, or give the robot other marker_colors"
            )
        elif problem := view.problem(marker.polygon, classes[name]):
            problems.append(f"{role} marker ({name}): {problem}")
    return problems or view.location_problems(
        [classes[marker.color] for marker in robot.markers.values()]
    )


def over_grey(image: Pixels) -> Pixels:
    """Return an RGBA image blended onto a grey floor, as RGB."""
    alpha = image[..., 3:].astype(np.float32) / 255
    mixed = image[..., :3] * alpha + GREY * (1 - alpha)
    return np.rint(mixed).astype(np.uint8)


def ranges(color: ColorClass) -> str:
    """Return the ranges of a colour as text."""
    y, u, v = (f"{low}..{high}" for low, high in (color.y, color.u, color.v))
    return f"Y {y}, U {u}, V {v}"


class _View:
    """The robot's image at the scale of the work area, on a grey floor with a margin."""

    def __init__(self, robot: RobotDefinition) -> None:
        self.robot = robot
        height, width = robot.image.shape[:2]
        # Never enlarged: interpolation adds no information.
        new_width = max(1, min(width, round(robot.size)))
        new_height = max(1, round(height * new_width / width))
        small = resized(robot.image, new_width, new_height)
        self.scale = np.array((new_width / width, new_height / height))
        self.unit = robot.size / new_width  # width of a pixel of the view on the work area (px)
        margin = ((_MARGIN, _MARGIN), (_MARGIN, _MARGIN), (0, 0))
        self.pixels = np.pad(over_grey(small), margin, constant_values=GREY)

    def to_view(self, polygon: Floats) -> Floats:
        """Transform a polygon from image px to px of the view."""
        positions: Floats = (polygon + 0.5) * self.scale - 0.5 + _MARGIN
        return positions

    def problem(self, marker: Floats, color: ColorClass) -> str | None:
        """Return the reason for a missed marker; None if it is detected."""
        polygon = self.to_view(marker)
        area, centroid = area_and_centroid(polygon)
        if area * self.unit**2 < MINIMUM_AREA:
            return (
                f"it is too small to be detected, {area * self.unit**2:.1f} px of the work area, "
                f"at least {MINIMUM_AREA} are needed: increase the robot's size"
            )
        height, width = self.pixels.shape[:2]
        inside = rgb_to_yuv(self.pixels)[mask(polygon, width, height)].astype(int)
        limits = np.array((color.y, color.u, color.v))
        fraction = ((inside >= limits[:, 0]) & (inside <= limits[:, 1])).all(axis=1).mean()
        if fraction < _MINIMUM_FRACTION:
            y, u, v = inside.mean(axis=0)
            return (
                f"{100 * fraction:.1f} % of its polygon has the colour {color.name}, "
                f"{100 * _MINIMUM_FRACTION:.0f} % is needed; the mean there is Y {y:.0f}, U {u:.0f}"
                f", V {v:.0f}, but {color.name} is {ranges(color)}"
            )
        return self._mismatch(color, area, centroid)

    def _mismatch(self, color: ColorClass, area: float, centroid: Floats) -> str | None:
        """Return the difference of the nearest blob to a marker polygon; None if it fits."""
        blobs = self._blobs([color])[color.name]
        if not blobs:
            return "no blob of the colour is large enough to be detected"
        offsets = [float(np.linalg.norm(blob.centroid - centroid)) * self.unit for blob in blobs]
        blob = blobs[int(np.argmin(offsets))]
        factor = max(blob.area / area, area / blob.area)
        if factor > self.robot.marker_layout().area_tolerance:
            return (
                f"the blob detected there has {blob.area * self.unit**2:.0f} px of the work area, "
                f"its polygon {area * self.unit**2:.0f}: draw it around the whole coloured area"
            )
        if min(offsets) > _MAXIMUM_OFFSET:
            right, down = (blob.centroid - _MARGIN + 0.5) / self.scale - 0.5
            return (
                f"the blob detected there has its centroid at ({right:.5g}, {down:.5g}), "
                f"{min(offsets):.1f} px of the work area from the polygon's"
            )
        return None

    def location_problems(self, colors: list[ColorClass]) -> list[str]:
        """Return a sentence if the markers are detected, but do not locate the robot."""
        plane_map = PlaneMap.scaled(
            (self.pixels.shape[1], self.pixels.shape[0]),
            (self.pixels.shape[1] * self.unit, self.pixels.shape[0] * self.unit),
        )
        blobs = self._blobs(colors)
        detection = detect(blobs, self.robot.marker_layout(), plane_map=plane_map)
        if detection.measurement is not None:
            return []
        return ["the markers are detected, but do not locate the robot: " + detection.explanation]

    def _blobs(self, colors: list[ColorClass]) -> dict[str, list[Blob]]:
        minimum_area = max(1, round(MINIMUM_AREA / self.unit**2))
        return find_blobs(self.pixels, colors, minimum_area=minimum_area)


_LIKE = 0.5  # correlation from which the robot is there
_LEAD = 0.25  # of the correlation with exchanged channels
_VISIBLE = 0.8  # fraction of the robot that must lie within the frame.
_AROUND_MARKER = 1.4  # of a marker's size, because its colour spreads
_OPAQUE = 250  # alpha


def looks_mirrored(
    frame: Frame, robot: RobotDefinition, detect: Callable[[Frame], Detection]
) -> bool:
    """Return whether a frame shows the robot only with its red and blue channels exchanged.

    The markers fit in both orders of the channels, with headings half a turn apart. Only the rest
    of the robot's image is correlated with the frame at both poses. The result is unreliable for a
    robot that looks the same from both sides, or unlike its image.
    """
    exchanged = Frame.from_bgr(frame.image, plane_map=frame.plane_map)
    given, other = (_likeness(shown, robot, detect(shown)) for shown in (frame, exchanged))
    return other > _LIKE and other > given + _LEAD


def _likeness(frame: Frame, robot: RobotDefinition, detection: Detection) -> float:
    """Return the correlation of the robot's image with the frame at its pose; 0 if not detected."""
    if detection.measurement is None:
        return 0.0
    points, colors = _body(robot)
    places = frame.plane_map.to_pixel(placed(points, detection.measurement.pose))
    pixels = np.rint(np.nan_to_num(places, nan=-1)).astype(int)  # NaN: outside of the frame
    height, width = frame.image.shape[:2]
    is_within = ((pixels >= 0) & (pixels < (width, height))).all(axis=1)
    if is_within.mean() < _VISIBLE:
        return 0.0
    right, down = pixels[is_within].T
    seen, drawn = frame.image[down, right].astype(float), colors[is_within]
    seen, drawn = seen - seen.mean(), drawn - drawn.mean()
    scale = np.sqrt((seen**2).sum() * (drawn**2).sum())
    return float((seen * drawn).sum() / scale) if scale > 0 else 0.0


@lru_cache(maxsize=4)
def _body(robot: RobotDefinition) -> tuple[Floats, Floats]:
    """Return positions (N, 2) in the robot's frame, opaque and off the markers, and their RGB."""
    height, width = robot.image.shape[:2]
    # Every second pixel of the work area is enough.
    columns = max(1, min(width, round(robot.size / 2)))
    rows = max(1, round(height * columns / width))
    small = resized(robot.image, columns, rows)
    scale = np.array((columns / width, rows / height))
    is_body = small[..., 3] > _OPAQUE
    for marker in robot.markers.values():
        polygon = (marker.polygon + 0.5) * scale - 0.5
        centroid = area_and_centroid(polygon)[1]
        is_body &= ~mask(centroid + _AROUND_MARKER * (polygon - centroid), columns, rows)
    down, right = np.nonzero(is_body)
    points = (np.column_stack((right, down)) + 0.5) / scale - 0.5
    return robot.to_robot_frame(points), small[is_body][:, :3].astype(float)
