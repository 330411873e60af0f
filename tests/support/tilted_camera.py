"""A camera of a known lens that looks at the floor at an angle: where it sees what, by OpenCV."""

import math

import numpy as np

from robsim.vision import Intrinsics, PlaneMap


class TiltedCamera:
    """A camera whose optical axis meets the floor in `target`, `tilt` degrees off the vertical.

    The axes of the world are those of the work area, and its third one points to the ground.
    """

    def __init__(
        self, size, focal, distortion=(0, 0, 0, 0, 0), tilt=30, away=1800, target=(600, 600)
    ):
        self.size = size
        middle = ((size[0] - 1) / 2, (size[1] - 1) / 2)
        self.matrix = np.array([[focal, 0, middle[0]], [0, focal, middle[1]], [0, 0, 1]])
        self.distortion = np.array(distortion, float)
        self.rotation = np.array([math.radians(tilt), 0, 0])
        c, s = math.cos(self.rotation[0]), math.sin(self.rotation[0])
        turned = np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
        self.shift = np.array([0, 0, away]) - turned @ [*target, 0]

    @property
    def intrinsics(self):
        return Intrinsics(self.matrix, self.distortion)

    def pixels(self, positions, height=0.0, *, with_lens=True):
        """The pixels of positions (N, 2) at a height above the floor, by OpenCV."""
        import cv2

        positions = np.asarray(positions, float)
        points = np.c_[positions, np.full(len(positions), -height)]
        distortion = self.distortion if with_lens else np.zeros(5)
        seen, _ = cv2.projectPoints(points, self.rotation, self.shift, self.matrix, distortion)
        return seen[:, 0]

    def floor_map(self, marks=((0, 0), (1199, 0), (1199, 1199), (0, 1199))):
        """The map that a calibration by marks on the floor gives."""
        return PlaneMap.from_points(self.pixels(marks), marks, self.intrinsics)
