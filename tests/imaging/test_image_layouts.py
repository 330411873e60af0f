"""Images whose rows lie anywhere in memory are seen as their copies are."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import robsim
from robsim import Frame, find_blobs
from robsim.vision import rgb_to_yuv

COLORS = robsim.load_colors()


def blobs_in(image, **options):
    found = find_blobs(image, COLORS, minimum_area=1, **options)
    return {
        color: [(b.area, *b.centroid, b.bounding_box, b.at_border) for b in blobs]
        for color, blobs in found.items()
    }


VIEWS = {
    "every second row": lambda image: image[::2],
    "upside down": lambda image: image[::-1],
    "every third row from below": lambda image: image[::-3],
    "a part": lambda image: image[1:-2, 1:-1],
    "one column": lambda image: image[:, 3:4],
    "one row": lambda image: image[2:3],
    "one pixel": lambda image: image[2:3, 3:4],
    "a row, repeated": lambda image: np.broadcast_to(image[:1], image.shape),
    "read-only": lambda image: np.frombuffer(image.tobytes(), np.uint8).reshape(image.shape),
    "a memory map's kind": lambda image: image.view(np.memmap),
}


@pytest.mark.long
@pytest.mark.parametrize("view", VIEWS.values(), ids=VIEWS)
@settings(max_examples=30)
@given(width=st.integers(5, 41), height=st.integers(5, 20), seed=st.integers(0, 2**32))
def test_rows_may_lie_anywhere_in_memory(view, width, height, seed):
    palette = np.array([[220, 30, 30], [30, 60, 220], [100, 100, 100]], np.uint8)
    image = palette[np.random.default_rng(seed).integers(0, 3, (height, width))]
    seen = view(image)
    copy = np.array(seen, order="C")
    blobs = blobs_in(seen)
    assert blobs == blobs_in(copy)
    assert sum(map(len, blobs.values())) > 0 or (copy == 100).all(axis=2).any()
    np.testing.assert_array_equal(rgb_to_yuv(seen), rgb_to_yuv(copy))
    np.testing.assert_array_equal(Frame(seen).image, copy)
    noise = robsim.GaussianNoise(20)
    np.testing.assert_array_equal(noise.add(seen, 1), noise.add(copy, 1))


def test_a_blob_upside_down_is_upside_down():
    image = np.full((9, 7, 3), 100, np.uint8)
    image[1:3, 2:6] = (220, 30, 30)
    assert blobs_in(image)["red"] == [(8, 3.5, 1.5, (2, 1, 5, 2), False)]
    assert blobs_in(image[::-1])["red"] == [(8, 3.5, 6.5, (2, 6, 5, 7), False)]
