"""What is no image, or no option of a frame, is refused by all that take one."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as npst

import robsim
from refusals import (
    BEYOND_INT,
    IMAGE,
    INF,
    NAN,
    NO_IMAGE,
    NO_INT,
    NO_MAP,
    Refusal,
    options,
    refusals,
    refuses,
)
from robsim import Frame, find_blobs
from robsim.vision import rgb_to_yuv

COLORS = robsim.load_colors()
IMAGE_TAKERS = {
    "find_blobs": lambda image: find_blobs(image, COLORS),
    "rgb_to_yuv": rgb_to_yuv,
    "color_histograms": lambda image: robsim.vision.color_histograms(image, (0, 0, 0, 0)),
    "Frame": Frame,
    "UniformNoise.add": lambda image: robsim.UniformNoise(5).add(image, 1),
    "UniformNoise.add, off": lambda image: robsim.UniformNoise(0).add(image, 1),
}
takes_images = pytest.mark.parametrize("take", IMAGE_TAKERS.values(), ids=IMAGE_TAKERS)


@pytest.mark.long
@refusals([Refusal(take, "image", NO_IMAGE) for take in IMAGE_TAKERS.values()])
def test_what_is_no_image(refusal):
    refusal()


@refusals(
    options(
        Frame,
        {
            "t": ("now", 1j, [1], NAN, INF),
            "index": (-1, *NO_INT, *BEYOND_INT[2:]),
            "plane_map": NO_MAP,
            "time": (3,),
        },
        IMAGE,
    )
)
def test_options_of_a_frame(refusal):
    refusal()


OTHER_DTYPES = (
    npst.integer_dtypes(endianness="?")
    | npst.unsigned_integer_dtypes(endianness="?")
    | npst.floating_dtypes(endianness="?")
    | npst.complex_number_dtypes()
    | npst.byte_string_dtypes(max_len=3)
    | npst.unicode_string_dtypes(max_len=3)
).filter(lambda dtype: dtype != np.uint8)


@pytest.mark.long
@takes_images
@settings(max_examples=40)
@given(dtype=OTHER_DTYPES)
def test_images_of_other_types(take, dtype):
    message = refuses("image", take, np.zeros((8, 10, 3), dtype))
    assert "uint8" in message
    assert "(8, 10, 3)" in message


@pytest.mark.long
@takes_images
@settings(max_examples=60)
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
@settings(max_examples=60)
@given(rows=STEPS, columns=STEPS, channels=STEPS, fortran=st.booleans())
def test_images_of_any_stride(take, rows, columns, channels, fortran):
    whole = np.zeros((12, 12, 9), np.uint8, order="F" if fortran else "C")
    view = whole[::rows, ::columns, ::channels][:, :, :3]
    assume(view.shape[2] == 3)
    if view.strides[1:] == (3, 1):
        take(view)
    else:
        assert "ascontiguousarray(image)" in refuses("image", take, view)


def test_a_frame_is_an_image_to_find_blobs_only():
    assert find_blobs(Frame(IMAGE), COLORS) == {"red": [], "blue": []}
    refuses("image", rgb_to_yuv, Frame(IMAGE))
    refuses("image", Frame, Frame(IMAGE))
