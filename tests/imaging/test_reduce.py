"""Frames made smaller for the screen."""

import numpy as np
import pytest

import robsim
from robsim import _core


def means_of_blocks(image, factor):
    height, width = (side // factor for side in image.shape[:2])
    blocks = image[: height * factor, : width * factor].astype(int)
    sums = blocks.reshape(height, factor, width, factor, 3).sum((1, 3))
    return (sums + factor**2 // 2) // factor**2


def test_a_pixel_is_the_mean_of_its_block(rng):
    for size, width, factor in (
        *(((8, 8), 4, 2), ((6, 6), 2, 3), ((9, 13), 6, 2)),
        *(((41, 43), 10, 4), ((7, 6), 5, 1)),
    ):
        image = rng.integers(0, 256, (*size, 3), dtype=np.uint8)
        smaller = _core.reduced(robsim.Frame(image), width)
        np.testing.assert_array_equal(smaller, means_of_blocks(image, factor))
    part = rng.integers(0, 256, (12, 20, 3), dtype=np.uint8)[:, 4:16]
    smaller = _core.reduced(robsim.Frame(part, copy=False), 6)
    np.testing.assert_array_equal(smaller, means_of_blocks(part, 2))


def test_a_width_of_nothing_is_refused():
    with pytest.raises(ValueError, match="width"):
        _core.reduced(robsim.Frame(np.zeros((4, 4, 3), np.uint8)), 0)


def test_large_factors_go_in_steps_and_never_below_the_width():
    image = np.full((1600, 2000, 3), 255, np.uint8)
    smaller = _core.reduced(robsim.Frame(image), 230)
    assert smaller.shape == (200, 250, 3)
    assert (smaller == 255).all()
