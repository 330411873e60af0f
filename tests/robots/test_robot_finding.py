"""Robots and their markers in pictures."""

import numpy as np
import pytest
from PIL import Image, ImageFilter

from drawn_robots import COLORS, box, covered, painted, random_robot, star
from robsim import ColorClass, load_colors
from robsim.vision import BlobMarker, RobotDefinition, check_colors, robot_from_image
from sizes import thorough

pytestmark = pytest.mark.kernels


# --- robots out of plain pictures


RED, BLUE = box(240, 240, 319, 319), box(80, 240, 159, 319)

FIVE_POINTED = np.array(
    [
        *((250, 100), (270, 140), (315, 140), (280, 170), (295, 215)),
        *((250, 190), (205, 215), (220, 170), (185, 140), (230, 140)),
    ]
)


def by_color(robot):
    return {marker.color: marker.polygon for marker in robot.markers.values()}


def assert_fits(robot, color, mask):
    """The marker's polygon has the area and the centroid of the mask."""
    down, right = np.nonzero(mask)
    layout = robot.marker_layout()
    (role,) = (role for role, name in layout.colors.items() if name == color)
    unit = robot.size / robot.image.shape[1]
    assert layout.areas[role] == pytest.approx(len(down) * unit**2)
    (place,) = robot.to_robot_frame([(right.mean(), down.mean())])
    np.testing.assert_allclose(layout.positions[role], place, atol=1e-6)


def is_color(image, name):
    return (image == COLORS[name]).all(axis=2)


def test_what_is_not_given_has_the_documented_default():
    robot = robot_from_image("toy", painted(RED, BLUE))
    assert (robot.name, robot.size, robot.alignment) == ("toy", 120, 0)
    np.testing.assert_allclose(robot.centre, [199.5, 199.5], atol=0.01)
    assert check_colors(robot).ok


@pytest.mark.long
def test_a_marker_has_the_area_and_the_centroid_of_its_blob(rng):
    for _ in range(thorough(10, 3)):
        image = painted(star(rng, np.array((280, 200)), 70), star(rng, np.array((110, 190)), 70))
        robot = robot_from_image("toy", image)
        for name in ("red", "blue"):
            assert_fits(robot, name, is_color(image, name))


@pytest.mark.long
@pytest.mark.parametrize(
    ("shape", "share"),
    [
        (box(200, 100, 279, 179), 0.95),
        (box(200, 60, 211, 199), 0.9),  # a strip
        ([(200, 60), (210, 60), (300, 190), (290, 190)], 0.9),  # aslant
        (FIVE_POINTED, 0.85),
    ],
)
def test_a_marker_has_the_shape_of_its_blob(shape, share):
    image = painted(np.array(shape, float), box(60, 240, 119, 299))
    robot = robot_from_image("toy", image)
    assert len(by_color(robot)["red"]) <= 40
    drawn, found = is_color(image, "red"), covered(by_color(robot)["red"], image)
    assert (drawn & found).sum() / (drawn | found).sum() > share


def test_a_blob_among_others_of_its_colour_and_in_its_box():
    image = painted(RED, BLUE)
    image[100:150, 260:280] = COLORS["red"]  # apart, smaller
    image[240:319, 240:300] = (70, 70, 70, 255)  # leaves an L of the marker
    image[250:290, 245:285] = COLORS["red"]  # within the box of the L
    image[240, 245:285] = COLORS["red"]  # in its top row, too
    of_the_l = np.zeros(image.shape[:2], bool)
    of_the_l[240:320, 300:320] = of_the_l[319, 240:320] = True
    assert_fits(robot_from_image("toy", image), "red", is_color(image, "red") & of_the_l)


def test_a_ring_gives_a_polygon_that_does_not_cross_itself():
    image = painted(RED, BLUE)
    image[262:298, 262:298] = (70, 70, 70, 255)
    # A robot whose polygons cross themselves is refused.
    assert len(by_color(robot_from_image("toy", image))["red"]) >= 3


def test_the_outline_lies_close_around_what_is_opaque():
    image = painted(RED, BLUE)
    robot = robot_from_image("toy", image)
    opaque = image[..., 3] > 127
    within = covered(robot.outline, image)
    assert not (opaque & ~within).any()
    assert within.sum() < 1.02 * opaque.sum()
    assert len(robot.outline) <= 40


def test_the_outline_of_an_opaque_picture_is_its_edge():
    image = painted(RED, BLUE)[:360]
    image[..., 3] = 255
    with pytest.warns(UserWarning, match="no transparency, so its border is the outline"):
        outline = robot_from_image("toy", image).outline
    assert {tuple(point) for point in outline} == {
        (-0.5, -0.5),
        (399.5, -0.5),
        (399.5, 359.5),
        (-0.5, 359.5),
    }


def test_what_is_given_is_taken():
    robot = robot_from_image(
        "toy",
        painted(RED, BLUE),
        size=90,
        alignment=30,
        centre=(190, 210),
        outline=box(20, 20, 380, 380),
        markers={"red": RED + 1, "blue": BLUE - 1},
    )
    assert (robot.size, robot.alignment) == (90, 30)
    np.testing.assert_array_equal(robot.centre, (190, 210))
    np.testing.assert_array_equal(robot.outline, box(20, 20, 380, 380))
    np.testing.assert_array_equal(by_color(robot)["red"], RED + 1)
    np.testing.assert_array_equal(by_color(robot)["blue"], BLUE - 1)


@pytest.mark.long
def test_a_large_picture_is_scaled_down_with_its_points():
    large = np.array(Image.fromarray(painted(RED, BLUE)).resize((2000, 2000)))
    robot = robot_from_image(
        "toy", large, markers={"red": 5 * (RED + 0.5) - 0.5}, centre=(999.5, 1249.5)
    )
    assert robot.image.shape == (1000, 1000, 4)
    np.testing.assert_allclose(robot.centre, (499.5, 624.5))
    np.testing.assert_allclose(by_color(robot)["red"], 2.5 * (RED + 0.5) - 0.5)
    assert robot.marker_layout().distance == pytest.approx(160 * 120 / 400, abs=0.1)


@pytest.mark.long
@pytest.mark.parametrize("seed", range(thorough(5, 2)))
def test_a_photo_with_noise_and_blur(seed):
    rng = np.random.default_rng(seed)
    image = Image.fromarray(painted(RED, BLUE)).convert("RGB").filter(ImageFilter.GaussianBlur(2))
    noisy = np.clip(np.array(image) + rng.normal(0, 12, (400, 400, 3)), 0, 255).astype(np.uint8)
    noisy = np.dstack((noisy, np.full((400, 400), 255, np.uint8)))
    robot = robot_from_image("toy", noisy, outline=box(0, 0, 399, 399))
    assert check_colors(robot).ok
    assert robot.marker_layout().distance == pytest.approx(160 * 120 / 400, abs=0.3)


@pytest.mark.parametrize("name", ["red", "blue"])
def test_a_picture_without_a_marker(name):
    image = painted(RED, BLUE)
    image[is_color(image, name)] = (70, 70, 70, 255)
    with pytest.raises(ValueError, match=f"{name} marker.*--colors or --marker-colors"):
        robot_from_image("toy", image)
    given = {name: {"red": RED, "blue": BLUE}[name]}
    assert robot_from_image("toy", image, markers=given).name == "toy"


def test_what_cannot_be_found():
    with pytest.raises(ValueError, match="blue marker"):
        robot_from_image("toy", painted(RED, BLUE), colors=[ColorClass("red", v=(164, 255))])
    image = painted(RED, BLUE)
    image[..., 3] = 0
    with pytest.raises(ValueError, match="outline: the image is transparent"):
        robot_from_image("toy", image)


# --- the check of markers


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
    assert problem.startswith("left marker (blue): unknown colour blue, known: red")


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
