"""Which pixel belongs to which colour class, and the picture of it."""

import numpy as np
import pytest

import robsim
from robsim import ColorClass, load_colors
from robsim.vision import rgb_to_yuv
from robsim.vision._color_masks import paint_classes


@pytest.mark.parametrize("smoothing", [1, 3, 7, 15])
def test_masks_are_those_of_find_blobs(smoothing, rng):
    image = rng.integers(0, 256, (33, 47, 3), dtype=np.uint8)
    colors = [ColorClass("one", u=(120, 140)), ColorClass("two", y=(100, 255), v=(0, 130))]
    masks = robsim.vision.classify(image, colors, smoothing=smoothing)
    blobs = robsim.find_blobs(
        image, colors, minimum_area=1, maximum_count=10_000, smoothing=smoothing
    )
    for color in colors:
        v, u = np.nonzero(masks[color.name])
        found = blobs[color.name]
        assert sum(blob.area for blob in found) == len(u) > 0
        assert sum(blob.area * blob.centroid[0] for blob in found) == pytest.approx(u.sum())
        assert sum(blob.area * blob.centroid[1] for blob in found) == pytest.approx(v.sum())


def test_painted_classes():
    image = np.full((100, 100, 3), (150, 148, 146), np.uint8)
    image[30:50, 30:50] = (198, 36, 40)
    image[70:90, 70:90] = (30, 60, 220)
    classes = [*load_colors(), ColorClass("dark", y=(0, 80)), ColorClass("no color", y=(0, 10))]
    masks = robsim.vision.classify(robsim.Frame(image), classes)
    painted = paint_classes(robsim.Frame(image), masks)
    assert painted[40, 40].tolist() == [255, 0, 0]
    assert painted[80, 80].tolist() == [255, 255, 255]  # blue and dark
    assert painted[5, 5].tolist() == [rgb_to_yuv(image)[5, 5, 0] // 2] * 3
    alone = paint_classes(image, {"dark": masks["dark"]})
    assert alone[80, 80].tolist() == [255, 0, 255]


def test_painted_classes_are_those_of_classify():
    with pytest.raises(TypeError, match="masks must be a dict of str to bool arrays, as"):
        paint_classes(np.zeros((4, 4, 3), np.uint8), load_colors())
