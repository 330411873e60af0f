import numpy as np
import pytest

import robsim
from refusals import refuses

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
