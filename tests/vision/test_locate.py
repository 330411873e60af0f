"""Blobs and robots: found, located, limited."""

import numpy as np
import pytest

import robsim
from refusals import SQUARE, refuses
from robsim import locate
from robsim.vision import Blob, MarkerLayout
from scenes import errors_of, false_poses, poses_within, renderer, rms
from sizes import thorough

# --- blobs


COLORS = {"red": (255, 0, 0), "blue": (0, 0, 255), "green": (0, 255, 0)}
CLASSES = [
    robsim.ColorClass("red", v=(200, 255)),
    robsim.ColorClass("blue", u=(200, 255)),
]


def painted(red, blue=None):
    image = np.full((*red.shape, 3), 128, np.uint8)
    image[red] = COLORS["red"]
    if blue is not None:
        image[blue & ~red] = COLORS["blue"]
    return image


def test_one_rectangle_in_an_8_x_8_image():
    red = np.zeros((8, 8), bool)
    red[2:4, 3:7] = True
    (blob,) = robsim.find_blobs(painted(red), CLASSES, minimum_area=1)["red"]
    assert blob.color == "red"
    assert blob.area == 8
    assert blob.bounding_box == (3, 2, 6, 3)
    assert not blob.at_border
    np.testing.assert_allclose(blob.centroid, (4.5, 2.5))


def test_a_blob_at_the_border_says_so():
    middle = slice(3, 5)
    for rows, columns in (
        *((middle, slice(0, 2)), (middle, slice(6, 8))),
        *((slice(0, 2), middle), (slice(6, 8), middle)),
    ):
        red = np.zeros((8, 8), bool)
        red[rows, columns] = True
        (blob,) = robsim.find_blobs(painted(red), CLASSES, minimum_area=1)["red"]
        assert blob.at_border


def test_diagonal_neighbours_belong_together():
    found = robsim.find_blobs(painted(np.eye(9, dtype=bool)), CLASSES, minimum_area=1)
    assert [blob.area for blob in found["red"]] == [9]


def test_minimum_area_and_largest_first():
    red = np.zeros((20, 60), bool)
    for i, side in enumerate((2, 5, 3, 4)):
        red[1 : 1 + side, 10 * i : 10 * i + side] = True
    image = painted(red)
    assert [b.area for b in robsim.find_blobs(image, CLASSES, minimum_area=9)["red"]] == [25, 16, 9]
    found = robsim.find_blobs(image, CLASSES, minimum_area=1, maximum_count=2)
    assert [b.area for b in found["red"]] == [25, 16]


def test_a_pixel_may_belong_to_several_classes():
    red = np.zeros((8, 8), bool)
    red[2:6, 2:6] = True
    classes = [robsim.ColorClass("warm", v=(150, 255)), robsim.ColorClass("red", v=(200, 255))]
    found = robsim.find_blobs(painted(red), classes, minimum_area=1)
    assert found["warm"][0].area == found["red"][0].area == 16


def test_32_classes_and_no_more(rng):
    image = rng.integers(0, 256, (20, 70, 3), dtype=np.uint8)
    classes = [robsim.ColorClass(f"y{i}", y=(8 * i, 8 * i + 7)) for i in range(32)]
    found = robsim.find_blobs(image, classes, minimum_area=1, maximum_count=9999)
    assert sum(blob.area for blobs in found.values() for blob in blobs) == 20 * 70
    with pytest.raises(ValueError, match="colors must be at most 32 classes, got 33"):
        robsim.find_blobs(image, [*classes, robsim.ColorClass("one more")])


def test_limits_of_the_options():
    image = painted(np.ones((8, 8), bool))
    for name in ("minimum_area", "maximum_count"):
        assert len(robsim.find_blobs(image, CLASSES, **{name: 1})["red"]) == 1
        for value in (0, -1, 2**63):
            refuses(name, robsim.find_blobs, image, CLASSES, **{name: value})
    refuses("colors", robsim.find_blobs, image, [CLASSES[0]] * 2)


# --- robots


@pytest.mark.long
def test_continuous_rotation_in_light_shadow_and_at_its_edge(rng):
    errors = errors_of(renderer(), poses_within(rng, thorough(1000, 300)))
    # Where the robot covers the red square in part, not to see it would be right, too.
    assert np.isfinite(errors).all()
    place, heading = rms(errors)
    assert place < 0.10
    assert heading < 0.15


def test_parked_exactly_along_an_axis():
    shifts = np.arange(0, 1, 0.25)
    poses = [
        (600 + dx, 700 + dy, heading)
        for dx in shifts
        for dy in shifts
        for heading in (0.0, np.pi / 2, np.pi, -np.pi / 2)
    ]
    errors = errors_of(renderer(), np.array(poses))
    assert np.hypot(errors[:, 0], errors[:, 1]).max() < 0.4


def test_a_wrong_offset_oscillates_around_the_true_centre():
    headings = np.deg2rad(np.arange(0, 360, 10))
    poses = np.column_stack((np.full((36, 2), 400.0), headings))
    errors = errors_of(renderer(), poses, markers=robsim.vision.MarkerLayout(43, 15))
    expected = np.column_stack((np.cos(headings), np.sin(headings)))
    np.testing.assert_allclose(errors[:, :2], expected, atol=0.15)


def test_no_false_pose_of_a_robot_half_out_of_the_view(rng):
    along = rng.uniform(0, 1200, 200)
    across = rng.uniform(-40, 40, 200)
    side = rng.integers(4, size=200)
    x = np.choose(side, [along, along, across, 1199 - across])
    y = np.choose(side, [across, 1199 - across, along, along])
    errors = errors_of(renderer(), np.column_stack((x, y, rng.uniform(-np.pi, np.pi, 200))))
    assert not false_poses(errors).any()
    assert 0.02 < np.isfinite(errors[:, 0]).mean() < 0.9


@pytest.mark.long
def test_no_false_pose_among_discs_as_red_and_as_large_as_the_marker(rng):
    places = rng.uniform(50, 1150, (40, 2))
    v, u = np.mgrid[:30, :30]

    def scatter(background):
        for x, y in places:
            left, top = int(x) - 15, int(y) - 15
            is_disc = (left + u - x) ** 2 + (top + v - y) ** 2 < 13**2
            background[top : top + 30, left : left + 30][is_disc] = (199, 37, 41)
        return background

    errors = errors_of(renderer(adjust_background=scatter), poses_within(rng, thorough(300, 120)))
    assert not false_poses(errors).any()
    assert np.isfinite(errors[:, 0]).mean() > 0.7


# --- limits


RIGHT = np.add(SQUARE, (0, 50))


def test_limits_of_a_layout():
    good = {"distance": 43, "offset": 14}
    assert MarkerLayout(**good, distance_tolerance=1e-3).distance == 43
    for name, values in {
        "distance": (0, 1e-4, -43, np.inf),
        "offset": (np.inf, np.nan),
        "distance_tolerance": (0, -1, np.nan),
        "area_tolerance": (1, 0.5, np.nan),
    }.items():
        for value in values:
            refuses(name, MarkerLayout, **good | {name: value})
    flat, few = [[0, 0], [1, 1], [2, 2]], SQUARE[:2]
    for wrong in (
        *({"right": RIGHT, "left": polygon} for polygon in (flat, few, SQUARE * np.nan)),
        *({"right": RIGHT}, {"right": RIGHT, "back": SQUARE}, (RIGHT, SQUARE)),
    ):
        refuses("markers", MarkerLayout.from_markers, wrong)
    with pytest.raises(ValueError, match="distance"):
        MarkerLayout.from_markers({"right": SQUARE, "left": SQUARE})


CROSSED = np.array(((0, 0), (10, 10.001), (10, 0), (0, 10)))
ROUND = 9 * np.column_stack([f(np.linspace(0, 2 * np.pi, 1001)) for f in (np.cos, np.sin)])


def test_polygons_beyond_all_bounds():
    for polygon, words in (
        (SQUARE * 1e160, "1e9 px"),
        (SQUARE * 1e-160, "area"),
        (CROSSED, "cross"),
        (ROUND, "1000 points, got 1001"),
    ):
        with pytest.raises(ValueError, match=rf"^markers\['right'\].*{words}"):
            MarkerLayout.from_markers({"right": polygon, "left": np.add(SQUARE, (0, -50))})
        polygons = {"right": SQUARE - SQUARE.mean(axis=0), "left": polygon}
        with pytest.raises(ValueError, match=rf"^polygons\['left'\].*{words}"):
            MarkerLayout.from_positions({"right": (0, 9), "left": (0, -9)}, polygons=polygons)


def test_as_many_blobs_are_considered_as_the_markers_say():
    """The blob like the marker is the third largest."""

    def blob(color, area, place):
        return Blob(color, area=area, centroid=place, bounding_box=(0, 0, 9, 9))

    blobs = {
        "red": [blob("red", 900, (50, 9)), blob("red", 800, (9, 50)), blob("red", 90, (100, 143))],
        "blue": [blob("blue", 90, (100, 100))],
    }
    layouts = [MarkerLayout(43, 14, maximum_blobs=most) for most in (2, 3)]
    found = [locate(blobs, layout) for layout in layouts]
    assert found[0] is None
    assert found[1] is not None
