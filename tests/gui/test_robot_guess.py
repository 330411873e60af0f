"""First guesses of a robot's polygons from its picture on a floor."""

import numpy as np
import pytest

import robsim
from drawn_robots import covered
from robsim.vision import load_colors
from robsim.vision.robots.sketch import guess_marker, guess_outline


def picture(name, noise=None):
    """A robot on the floor, cut out of a frame, its pose, and what takes its points there."""
    robot = robsim.load_robot(name)
    pose = np.array((300, 300, 0.6))
    options = {"area": (600, 600), "headings": None, "seed": 2, "noise": noise}
    frame = robsim.Simulation(robot=robot, start=tuple(pose), **options).step().frame
    half = int(robot.radius * 1.5)
    cut = frame.image[300 - half : 300 + half, 300 - half : 300 + half]
    return robot, np.ascontiguousarray(cut), pose - (300 - half, 300 - half, 0)


def placed(robot, polygon, pose):
    forward, right = robot.to_robot_frame(polygon).T
    c, s = np.cos(pose[2]), np.sin(pose[2])
    return np.column_stack([pose[0] + c * forward - s * right, pose[1] + s * forward + c * right])


def overlap(one, other, image):
    one, other = covered(one, image), covered(other, image)
    return (one & other).sum() / (one | other).sum()


@pytest.mark.parametrize(("name", "noise"), [("robot2", None), ("lab", robsim.GaussianNoise(10))])
def test_the_outline_is_about_that_of_the_robot(name, noise):
    robot, image, pose = picture(name, noise)
    found = guess_outline(image)
    assert overlap(found, placed(robot, robot.outline, pose), image) > 0.75


def test_the_markers_are_those_of_the_robot():
    robot, image, pose = picture("lab")
    outline = guess_outline(image)
    for marker in robot.markers.values():
        found = guess_marker(image, outline, marker.color, load_colors())
        assert overlap(found, placed(robot, marker.polygon, pose), image) > 0.6


def test_a_bare_floor_has_no_robot():
    floor = np.full((90, 120, 3), 128, np.uint8)
    with pytest.raises(ValueError, match="nothing stands out from the floor"):
        guess_outline(floor)
    rng = np.random.default_rng(1)
    noisy = np.clip(128 + 12 * rng.standard_normal((90, 120, 3)), 0, 255).astype(np.uint8)
    with pytest.raises(ValueError, match="nothing stands out from the floor"):
        guess_outline(noisy)


def test_a_marker_outside_of_the_outline_is_none():
    image = np.full((90, 120, 3), 128, np.uint8)
    image[5:15, 5:15] = (210, 40, 30)
    outline = np.array([(30.0, 20), (90, 20), (90, 70), (30, 70)])
    with pytest.raises(ValueError, match="red marker: nothing in the image"):
        guess_marker(image, outline, "red", load_colors())
