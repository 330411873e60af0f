"""Whether the markers of a robot are seen: one thing wrong at a time."""

import numpy as np
import pytest

from drawn_robots import COLORS, box, painted, random_robot
from robsim import ColorClass, load_colors
from robsim.vision import BlobMarker, RobotDefinition, check_colors

pytestmark = pytest.mark.kernels

RED, BLUE = box(240, 240, 319, 319), box(80, 240, 159, 319)
EDGE = box(-0.5, -0.5, 399.5, 399.5)


def robot(image, **changed):
    values = {"name": "toy", "image": image, "size": 120.0, "alignment": 90.0}
    values |= {"outline": EDGE, "red": RED, "blue": BLUE} | changed
    red, blue = (BlobMarker(values.pop(color), color) for color in ("red", "blue"))
    return RobotDefinition(markers={"right": red, "left": blue}, **values)


@pytest.fixture
def picture():
    return painted(RED, BLUE)


def filled(picture, polygon, color):
    """The picture with a box of another colour."""
    changed = picture.copy()
    left, top, right, bottom = (*polygon[0].astype(int), *polygon[2].astype(int))
    changed[top : bottom + 1, left : right + 1] = color
    return changed


def test_a_good_robot_has_no_problem(picture):
    assert check_colors(robot(picture)).ok
    for seed in range(3):
        assert check_colors(random_robot(np.random.default_rng(seed))).ok


def test_a_marker_of_another_colour(picture):
    green = filled(picture, BLUE, (20, 160, 30, 255))
    (problem,) = check_colors(robot(green)).sentences
    assert problem.startswith("left marker (blue): 0.0 % of its polygon")
    # Y = (38 20 + 75 160 + 15 30)/128, U = 128 + (-22 20 - 42 160 + 64 30)/128, V likewise
    assert "Y 103, U 87, V 68, but blue is Y 0..255, U 154..255, V 0..140" in problem


def test_other_colours(picture):
    classes = (ColorClass("red", v=(240, 255)), *load_colors()[1:])
    (problem,) = check_colors(robot(picture), classes).sentences
    assert "right marker (red): 0.0 %" in problem
    assert "V 240..255" in problem
    (problem,) = check_colors(robot(picture), load_colors()[:1]).sentences
    assert problem.startswith("left marker (blue): there is no colour blue, only red")


def test_markers_that_are_too_small(picture):
    red, blue = check_colors(robot(picture, size=15)).sentences
    # 79 picture px, at 15/400 each
    assert red.startswith("right marker (red): it is too small to be detected, 8.8 px")
    assert blue.startswith("left marker (blue): it is too small")


def test_a_polygon_beside_its_blob_or_larger_or_smaller(picture):
    (problem,) = check_colors(robot(picture, red=RED + np.array((20, 0)))).sentences
    assert "6.0 px of the work area from" in problem
    (problem,) = check_colors(robot(picture, red=box(257, 257, 302, 302))).sentences
    assert problem.startswith("right marker (red): ")
    assert "has 576 px of the work area, its polygon 182" in problem
    (problem,) = check_colors(robot(picture, red=box(215, 215, 344, 344))).sentences
    assert "right marker (red): 39.9 % of its polygon" in problem


def test_a_robot_with_two_such_markers(picture):
    # A second red square, as far from the blue one as the first.
    double = filled(picture, box(80, 80, 159, 159), COLORS["red"])
    (problem,) = check_colors(robot(double)).sentences
    assert "two pairs of red and blue blobs" in problem


def test_the_smallest_markers_that_are_seen(picture):
    side = 4 * 400 / 24  # 4 px of the work area
    red, blue = box(250, 200, 250 + side, 200 + side), box(83, 200, 83 + side, 200 + side)
    small = robot(painted(red, blue), size=24.0, red=red, blue=blue)
    assert check_colors(small).ok


def test_a_marker_that_only_the_light_shows(picture):
    # V is 160 in the light and 153 in the shadow; red is 154 and more
    pale = filled(picture, RED, (140, 76, 76, 255))
    (problem,) = check_colors(robot(pale)).sentences
    assert problem.startswith("in the shadow: right marker (red): 0.0 %")
