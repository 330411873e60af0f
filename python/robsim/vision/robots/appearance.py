"""Tells by the rest of a robot's image whether frames have red and blue exchanged."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import numpy as np

from robsim._core import Detection, Frame, PlaneMap
from robsim.base.checks import Floats
from robsim.base.geometry.polygons import area_and_centroid, mask
from robsim.vision.imaging.images import Pixels, resized
from robsim.vision.robots.definition import RobotDefinition

_LIKE = 0.5  # correlation from which the robot is there
_LEAD = 0.25  # of the correlation with exchanged channels
_VISIBLE = 0.8  # fraction of the robot that must lie within the frame
_AROUND_MARKER = 1.4  # of a marker's size; its colour spreads beyond its edge
_OPAQUE = 250  # alpha


def looks_mirrored(
    frame: Frame, robot: RobotDefinition, detect: Callable[[Frame], Detection]
) -> bool:
    """Return whether a frame shows the robot only if its red and blue channels are exchanged.

    The markers fit in both orders of the channels, with headings half a turn apart. What else the
    robot's image shows, does not: it is correlated with the frame at both poses. A robot that looks
    the same from both sides cannot be told, nor one that does not look like its image.

    Parameters
    ----------
    frame : Frame
        The frame.
    robot : RobotDefinition
        The robot; its image is compared, without the markers.
    detect : callable
        ``detect(frame) -> Detection``.
    """
    exchanged = Frame.from_bgr(frame.image, plane_map=frame.plane_map)
    given, other = (_likeness(shown, robot, detect(shown)) for shown in (frame, exchanged))
    return other > _LIKE and other > given + _LEAD


def _likeness(frame: Frame, robot: RobotDefinition, detection: Detection) -> float:
    """Return the correlation of the robot's image with the frame at its pose; 0 if not detected."""
    if detection.measurement is None:
        return 0.0
    points, colors = _body(robot)
    pixels = _pixels_at(points, detection.measurement.pose, frame.plane_map)
    height, width = frame.image.shape[:2]
    is_within = ((pixels >= 0) & (pixels < (width, height))).all(axis=1)
    if is_within.mean() < _VISIBLE:
        return 0.0
    right, down = pixels[is_within].T
    seen, drawn = frame.image[down, right].astype(float), colors[is_within]
    seen, drawn = seen - seen.mean(), drawn - drawn.mean()
    scale = np.sqrt((seen**2).sum() * (drawn**2).sum())
    return float((seen * drawn).sum() / scale) if scale > 0 else 0.0


def _pixels_at(points: Floats, pose: Floats, plane_map: PlaneMap) -> Pixels:
    """Return the pixels (N, 2) of points in the frame of a robot at a pose."""
    x, y, heading = pose
    cos, sin = np.cos(heading), np.sin(heading)
    # position = centre + R(heading) (forward, right)
    positions = points @ np.array(((cos, sin), (-sin, cos))) + (x, y)
    seen = np.nan_to_num(plane_map.to_pixel(positions), nan=-1)  # not shown: outside of the frame
    pixels: Pixels = np.rint(seen).astype(int)
    return pixels


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
        polygon = (marker + 0.5) * scale - 0.5
        centroid = area_and_centroid(polygon)[1]
        is_body &= ~mask(centroid + _AROUND_MARKER * (polygon - centroid), columns, rows)
    down, right = np.nonzero(is_body)
    points = (np.column_stack((right, down)) + 0.5) / scale - 0.5
    return robot.to_robot_frame(points), small[is_body][:, :3].astype(float)
