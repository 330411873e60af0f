"""An AprilTag in place of the robot: how it looks, and the pose that cv2.aruco finds of it."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from robsim._core import Frame
from robsim.base.checks import Floats
from robsim.vision import BlobMarker, RobotDefinition

_ID = 0
_MODULES = 8  # of the black square's side; a white one around it on each side
_MODULE = 20  # px of its image
_APART = 0.03  # of its perimeter: less than a module's diagonal
_ENLARGED = 2  # tags of a few px a module are found better so
_AROUND = 4  # sides of the tag around its place that are searched


class AprilTag:
    """A tag 36h11 that lies on the robot's place.

    Parameters
    ----------
    cv2 : module
        OpenCV.
    area : float
        Area of its black square (work-area px^2).
    """

    def __init__(self, cv2: Any, area: float) -> None:
        aruco = cv2.aruco
        parameters = aruco.DetectorParameters()
        # The most exact of OpenCV's four for tags as small as these.
        parameters.cornerRefinementMethod = aruco.CORNER_REFINE_CONTOUR
        # The edge of the paper is no marker: OpenCV up to 4.8 would take it in place of the tag.
        parameters.minMarkerDistanceRate = _APART
        self._cv2 = cv2
        self._dictionary = aruco.getPredefinedDictionary(aruco.DICT_APRILTAG_36h11)
        self._detector = aruco.ArucoDetector(self._dictionary, parameters)
        self._side = math.sqrt(area)
        turns = ((-1, -1), (1, -1), (1, 1), (-1, 1))
        self._corners = self._side / 2 * np.array(turns, float)  # forward, right

    def definition(self) -> RobotDefinition:
        """Return it as a robot, which the world then draws as it draws one."""
        image = self._cv2.aruco.generateImageMarker(self._dictionary, _ID, _MODULES * _MODULE)
        image = np.pad(image, _MODULE, constant_values=255)
        last, half = image.shape[0] - 1, image.shape[0] / 2
        opaque = np.full_like(image, 255)
        return RobotDefinition(
            name="apriltag",
            image=np.dstack((image, image, image, opaque)),
            size=self._side * (_MODULES + 2) / _MODULES,
            alignment=0,
            outline=_box(0, 0, last, last),
            # A robot must have two markers; nobody looks for these.
            markers={
                "right": BlobMarker(
                    _box(_MODULE, half + _MODULE, last - _MODULE, last - _MODULE), "red"
                ),
                "left": BlobMarker(_box(_MODULE, _MODULE, last - _MODULE, half - _MODULE), "blue"),
            },
        )

    def pose(self, frame: Frame, near: Floats) -> Floats | None:
        """Return its pose in a frame, (3,), searched near a position; None if it is not found."""
        part, first = self._part(frame, near)
        enlarged = self._cv2.resize(
            self._cv2.cvtColor(part, self._cv2.COLOR_RGB2GRAY),
            None,
            fx=_ENLARGED,
            fy=_ENLARGED,
            interpolation=self._cv2.INTER_CUBIC,
        )
        corners, ids, _ = self._detector.detectMarkers(enlarged)
        found = np.flatnonzero(np.ravel([] if ids is None else ids) == _ID)
        if not len(found):
            return None
        seen = np.asarray(corners[found[0]], np.float64).reshape(4, 2)
        pixels = (seen + 0.5) / _ENLARGED - 0.5 + first
        return self._fitted(np.asarray(frame.plane_map.to_world(pixels)))

    def _part(self, frame: Frame, near: Floats) -> tuple[Any, Floats]:
        """Return the part of a frame around a position, and its first column and row."""
        reach = _AROUND * self._side
        corners = frame.plane_map.to_pixel(near[:2] + np.array(((-reach, -reach), (reach, reach))))
        height, width = frame.image.shape[:2]
        (left, top), (right, bottom) = np.rint(corners).clip(0, (width, height)).astype(int)
        part = np.ascontiguousarray(frame.image[top:bottom, left:right])
        return part, np.array((left, top), float)

    def _fitted(self, positions: Floats) -> Floats:
        """Return the pose whose corners have the least squared distances from positions (4, 2)."""
        centre = positions.mean(axis=0)
        (forward, right), (x, y) = self._corners.T, (positions - centre).T
        # tan heading = sum (forward y - right x) / sum (forward x + right y)
        heading = math.atan2((forward * y - right * x).sum(), (forward * x + right * y).sum())
        return np.array((*centre, heading))


def _box(left: float, top: float, right: float, bottom: float) -> Floats:
    return np.array(((left, top), (right, top), (right, bottom), (left, bottom)), float)
