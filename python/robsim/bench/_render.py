"""The benchmark of the renderer against OpenCV's functions."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from robsim._core import Renderer
from robsim.imaging._images import Pixels
from robsim.robots import RobotDefinition, load_robot
from robsim.simulation._world.scene import make_scene, robot_sprite

AREA = (1200, 1200)  # px

# Grey levels between the two images of a robot: OpenCV 4 samples at multiples of 1/32 px.
MAXIMUM_DIFFERENCE = 16
MAXIMUM_MEAN_DIFFERENCE = 3.0  # over the pixels that differ

# The robot moves from frame to frame, without a shadow, which OpenCV's functions do not draw.
_POSES = [(300 + 2.3 * k, 700 - 1.7 * k, 0.5 + 0.11 * k) for k in range(100)]

Pose = tuple[float, float, float]


def render_calls(cv2: Any, size: int) -> dict[str, Callable[[], Pixels]]:
    """Return the calls that draw the robot at its next pose, by robsim and by OpenCV.

    Parameters
    ----------
    cv2 : module
        OpenCV.
    size : int
        Width and height of the frame (px).

    Returns
    -------
    dict of str to callable
        ``"ours"`` and ``"opencv"``. Each call returns a frame; the buffer is reused.

    Raises
    ------
    RuntimeError
        If the two frames of a pose differ.
    """
    robot = load_robot("lab")
    scene = make_scene(
        robot=robot,
        area=AREA,
        resolution=(size, size),
        headings=0,
        background=None,
        adjust_background=lambda background: background,
    )
    renderer = Renderer(scene)
    opencv = _opencv_renderer(cv2, robot, renderer, size)
    for pose in _POSES[::10]:
        _check_same(renderer.render(pose), opencv(pose), pose)
    ours_next, opencv_next = itertools.cycle(_POSES), itertools.cycle(_POSES)
    return {
        "ours": lambda: renderer.render(next(ours_next)),
        "opencv": lambda: opencv(next(opencv_next)),
    }


def _opencv_renderer(
    cv2: Any, robot: RobotDefinition, renderer: Renderer, size: int
) -> Callable[[Pose], Pixels]:
    """Return a function that copies the background, rotates the robot's image and blends it in."""
    scale = size / AREA[0]
    background = renderer.render((-1e4, -1e4, 0.0)).copy()
    frame = np.empty_like(background)
    sprite, centre, _ = robot_sprite(robot, scale)
    alpha = sprite[:, :, 3:] / 255
    premultiplied = np.rint(np.dstack((sprite[:, :, :3] * alpha, sprite[:, :, 3:]))).astype(
        np.uint8
    )
    half_width = math.ceil(math.hypot(*sprite.shape[:2]) / 2) + 1
    side = (2 * half_width + 1, 2 * half_width + 1)

    def render(pose: Pose) -> Pixels:
        cv2.copyTo(background, None, frame)
        u, v = (pose[0] + 0.5) * scale - 0.5, (pose[1] + 0.5) * scale - 0.5
        left, top = round(u) - half_width, round(v) - half_width
        rotation = _rotation_matrix(
            pose[2] + math.radians(robot.alignment), centre, (u - left, v - top)
        )
        rotated = cv2.warpAffine(premultiplied, rotation, side, flags=cv2.INTER_LINEAR)
        background_weight = cv2.bitwise_not(cv2.extractChannel(rotated, 3))
        weights = cv2.cvtColor(background_weight, cv2.COLOR_GRAY2RGB)
        part = frame[top : top + side[1], left : left + side[0]]
        cv2.multiply(part, weights, part, scale=1 / 255)
        cv2.add(part, cv2.cvtColor(rotated, cv2.COLOR_RGBA2RGB), part)
        return frame

    return render


def _rotation_matrix(
    angle: float, centre: tuple[float, float], position: tuple[float, float]
) -> npt.NDArray[np.float64]:
    """Return the matrix (2, 3) that rotates clockwise about `centre` and moves it to `position`."""
    cos, sin = math.cos(angle), math.sin(angle)
    return np.array(
        [
            [cos, -sin, position[0] - cos * centre[0] + sin * centre[1]],
            [sin, cos, position[1] - sin * centre[0] - cos * centre[1]],
        ]
    )


def _check_same(ours: Pixels, theirs: Pixels, pose: Pose) -> None:
    differences = np.abs(ours.astype(int) - theirs)
    n_different = differences.any(axis=2).sum()
    mean = differences.sum() / max(1, 3 * n_different)
    if differences.max() > MAXIMUM_DIFFERENCE or mean > MAXIMUM_MEAN_DIFFERENCE:
        raise RuntimeError(
            f"robsim and OpenCV must draw the same robot at {pose}, "
            f"got differences of up to {differences.max()} grey levels, {mean:.1f} on average"
        )
