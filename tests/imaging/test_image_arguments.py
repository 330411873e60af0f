"""Which arrays are images, wherever their rows lie; what is none is refused by name."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as npst

import robsim
from refusals import IMAGE, refuses
from robsim import Frame, find_blobs
from robsim.vision import rgb_to_yuv

COLORS = robsim.load_colors()
IMAGE_TAKERS = {
    "find_blobs": lambda image: find_blobs(image, COLORS),
    "rgb_to_yuv": rgb_to_yuv,
    "Frame": Frame,
    "UniformNoise.add": lambda image: robsim.UniformNoise(5).add(image, 1),
}
takes_images = pytest.mark.parametrize("take", IMAGE_TAKERS.values(), ids=IMAGE_TAKERS)


@pytest.mark.long
@takes_images
@settings(max_examples=40)
@given(shape=npst.array_shapes(min_dims=0, max_dims=5, min_side=0, max_side=9))
def test_images_of_any_shape(take, shape):
    image = np.zeros(shape, np.uint8)
    if len(shape) == 3 and shape[2] == 3 and image.size:
        take(image)
    else:
        refuses("image", take, image)


STEPS = st.sampled_from([-3, -2, -1, 1, 2, 3])


@pytest.mark.long
@takes_images
@settings(max_examples=40)
@given(rows=STEPS, columns=STEPS, channels=STEPS, fortran=st.booleans())
def test_images_of_any_stride(take, rows, columns, channels, fortran):
    whole = np.zeros((12, 12, 9), np.uint8, order="F" if fortran else "C")
    view = whole[::rows, ::columns, ::channels][:, :, :3]
    assume(view.shape[2] == 3)
    if view.strides[1:] == (3, 1):
        take(view)
    else:
        assert "ascontiguousarray(image)" in refuses("image", take, view)


def test_limits_of_a_frame():
    assert Frame(IMAGE, index=0).index == 0
    refuses("index", Frame, IMAGE, index=-1)
    refuses("t", Frame, IMAGE, t=np.nan)
    assert find_blobs(Frame(IMAGE), COLORS) == {"red": [], "blue": []}
    refuses("image", rgb_to_yuv, Frame(IMAGE))
    refuses("image", Frame, Frame(IMAGE))


# --- rows anywhere in memory


def blobs_in(image, **options):
    found = find_blobs(image, COLORS, minimum_area=1, **options)
    return {
        color: [(b.area, *b.centroid, b.bounding_box, b.at_border) for b in blobs]
        for color, blobs in found.items()
    }


VIEWS = {
    "every third row from below": lambda image: image[::-3],
    "a part": lambda image: image[1:-2, 1:-1],
    "one column": lambda image: image[:, 3:4],
    "one pixel": lambda image: image[2:3, 3:4],
    "a row, repeated": lambda image: np.broadcast_to(image[:1], image.shape),
    "read-only": lambda image: np.frombuffer(image.tobytes(), np.uint8).reshape(image.shape),
}


@pytest.mark.parametrize("view", VIEWS.values(), ids=VIEWS)
@settings(max_examples=10)
@given(width=st.integers(5, 41), height=st.integers(5, 20), seed=st.integers(0, 2**32))
def test_rows_may_lie_anywhere_in_memory(view, width, height, seed):
    palette = np.array([[220, 30, 30], [30, 60, 220], [100, 100, 100]], np.uint8)
    image = palette[np.random.default_rng(seed).integers(0, 3, (height, width))]
    seen = view(image)
    copy = np.array(seen, order="C")
    assert blobs_in(seen) == blobs_in(copy)
    np.testing.assert_array_equal(rgb_to_yuv(seen), rgb_to_yuv(copy))
    np.testing.assert_array_equal(Frame(seen).image, copy)
    noise = robsim.GaussianNoise(20)
    np.testing.assert_array_equal(noise.add(seen, 1), noise.add(copy, 1))
