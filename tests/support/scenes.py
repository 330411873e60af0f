"""Scenes that several tests look at, and a tilted camera."""

import math

import numpy as np

import robsim
from robsim.simulation.world.scene import Floor, make_scene, scaled_floor
from robsim.vision import Intrinsics, PlaneMap

AREA = (1200, 1200)


def renderer(
    *, resolution=AREA, headings=0, adjust_background=robsim.simulation.draw_red_square, **options
):
    area = options.get("area", AREA)
    background = options.get("background")
    scene = make_scene(
        robot=options.get("robot", robsim.load_robot()),
        area=area,
        resolution=resolution,
        headings=headings,
        background=scaled_floor(None if background is None else Floor(background), area),
        adjust_background=adjust_background,
    )
    return robsim.simulation.Renderer(scene)


def small_renderer(**changed):
    """A renderer of a grey floor, 10 px x 8 px, with any of its arguments changed."""
    image = np.full((8, 10, 3), 100, np.uint8)
    options = {
        **{"floor": (image, image), "home": (image, image), "shadow_left": 6},
        **{"shadow_factor": 0.8, "sprite": np.full((4, 4, 4), 200, np.uint8)},
        **{"centre": (1.5, 1.5), "unit": 1.0, "alignment": 0.0, "headings": 4, "area": (10, 8)},
    }
    return robsim.simulation.Renderer(robsim.simulation.Scene(**(options | changed)))


def poses_within(rng, count, margin=60):
    """Poses uniform in x, y and heading, the whole robot in view."""
    xy = rng.uniform(margin, AREA[0] - 1 - margin, (count, 2))
    return np.column_stack((xy, rng.uniform(-np.pi, np.pi, count)))


def errors_of(draw, poses, *, markers=None, resolution=AREA):
    """Measured minus true poses (N, 3), NaN where the robot is not seen."""
    markers = robsim.load_robot().marker_layout() if markers is None else markers
    colors = robsim.load_colors()
    plane_map = robsim.vision.PlaneMap.scaled(resolution, AREA)
    errors = np.full((len(poses), 3), np.nan)
    for error, pose in zip(errors, poses, strict=True):
        seen = robsim.locate(robsim.find_blobs(draw.render(pose), colors), markers, plane_map)
        if seen is not None:
            error[:] = seen.pose - pose
            error[2] = robsim.wrap_angle(error[2])
    return errors


def rms(errors):
    """Root mean square of the place (px) and of the heading (degrees)."""
    distance = np.hypot(errors[:, 0], errors[:, 1])
    heading = np.rad2deg(errors[:, 2])
    return np.sqrt(np.mean(distance**2)), np.sqrt(np.mean(heading**2))


def false_poses(errors):
    distance = np.hypot(errors[:, 0], errors[:, 1])
    return (distance > 10) | (np.abs(errors[:, 2]) > np.deg2rad(20))


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
