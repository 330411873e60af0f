"""Pixels as cameras send them, beside the formulae in real numbers."""

import numpy as np
import pytest

from robsim import _core
from robsim.lab.cameras._devices import firewire, gige
from sent_pixels import from_rgb

UNITS = {"yuv411": "UYYVYY", "yuv422": "UYVY", "yuyv": "YUYV", "yuv444": "UYV"}
FILTERS = ("rggb", "grbg", "gbrg", "bggr")
FORMATS = [name for name, *_ in _core.pixel_formats()]
BITS_OF_PIXEL = {
    "mono16": 16, "yuv411": 12, "yuv422": 16, "yuyv": 16, "yuv444": 24, "rgb8": 24, "bgr8": 24
}  # fmt: skip


@pytest.fixture(params=_core.cpu_paths())
def _path(request):
    before = _core.cpu_path()
    _core.force_cpu_path(request.param)
    yield
    _core.force_cpu_path(before)


on_every_path = pytest.mark.usefixtures("_path")


def planes_of(raw, format_):
    """Y, and U and V of each pixel, of the order of a unit."""
    order = UNITS[format_]
    units = raw.reshape(len(raw), -1, len(order)).astype(float)
    y = units[..., [i for i, letter in enumerate(order) if letter == "Y"]]
    u, v = (np.repeat(units[..., order.index(letter)], y.shape[2], axis=1) for letter in "UV")
    return y.reshape(len(raw), -1), u - 128, v - 128


def rgb_of_yuv(y, u, v):
    # ITU-R BT.601 with K_R = 0.299, K_B = 0.114, all of 0 .. 255
    red = y + 1.402 * v
    blue = y + 1.772 * u
    green = (y - 0.299 * red - 0.114 * blue) / 0.587
    return np.clip(np.stack((red, green, blue), axis=2), 0, 255)


@on_every_path
def test_yuv_is_within_a_level_of_its_real_numbers(rng):
    for format_ in UNITS:
        for width in (4, 32, 36, 636):
            raw = rng.integers(0, 256, (7, width * BITS_OF_PIXEL[format_] // 8), dtype=np.uint8)
            image = _core.to_rgb(raw, width, 7, format_)
            assert np.abs(image - rgb_of_yuv(*planes_of(raw, format_))).max() < 0.6


def channel_of_pixels(filter_, shape):
    at = np.array(["rgb".index(letter) for letter in filter_]).reshape(2, 2)
    return np.tile(at, (shape[0] // 2 + 1, shape[1] // 2 + 1))[: shape[0], : shape[1]]


def debayered(raw, filter_):
    """The mean of what has the colour: the pixel itself, else those beside it, else at corners."""
    mirrored = np.pad(raw, 1, mode="reflect").astype(int)
    channels = np.pad(channel_of_pixels(filter_, raw.shape), 1, mode="reflect")
    rings = [[(0, 0)], [(0, 1), (0, -1), (1, 0), (-1, 0)], [(1, 1), (1, -1), (-1, 1), (-1, -1)]]
    image = np.zeros((*raw.shape, 3), np.uint8)
    for v, u, channel in np.ndindex(image.shape):
        for ring in rings:
            places = [(v + 1 + dv, u + 1 + du) for dv, du in ring]
            found = [mirrored[place] for place in places if channels[place] == channel]
            if found:
                image[v, u, channel] = (sum(found) + len(found) // 2) // len(found)
                break
    return image


@on_every_path
def test_missing_colours_are_means_of_their_neighbours(rng):
    for filter_ in FILTERS:
        for height, width in ((2, 2), (3, 3), (5, 31), (2, 67)):
            raw = rng.integers(0, 256, (height, width), dtype=np.uint8)
            image = _core.to_rgb(raw, width, height, f"bayer_{filter_}")
            np.testing.assert_array_equal(image, debayered(raw, filter_))


@on_every_path
def test_grey_of_two_bytes_has_the_high_one_first(rng):
    for bits in (8, 12, 16):
        grey = rng.integers(0, 1 << bits, (3, 50))
        image = _core.to_rgb(grey.astype(">u2").tobytes(), 50, 3, "mono16", bits)
        np.testing.assert_array_equal(image[..., 1], grey >> (bits - 8))
    beyond = _core.to_rgb(bytes([0x1F, 0xFF, 0x0F, 0xF0]), 2, 1, "mono16", 12)
    assert beyond[0, :, 0].tolist() == [255, 255]


@pytest.mark.parametrize("format_", FORMATS)
def test_what_is_sent_is_what_comes(format_):
    # A hue for each block of 4 x 2 px, so that pixels which share chroma are equal
    colors = np.array([(200, 30, 40), (20, 90, 210), (128, 128, 128), (250, 240, 10)], np.uint8)
    image = np.repeat(np.repeat(np.tile(colors, (4, 3, 1)), 4, axis=1), 2, axis=0)
    raw = from_rgb(image, format_)
    assert len(raw) == image[..., 0].size * BITS_OF_PIXEL.get(format_, 8) // 8
    again = _core.to_rgb(raw, image.shape[1], image.shape[0], format_)
    assert from_rgb(again, format_) == raw or format_ in UNITS
    if "mono" in format_:
        luma = np.rint(image @ (0.299, 0.587, 0.114))
        np.testing.assert_array_equal(again, np.repeat(luma[..., None], 3, axis=2))
    elif format_ in UNITS:
        assert np.abs(again.astype(int) - image).max() <= 2
    elif format_ in ("rgb8", "bgr8"):
        np.testing.assert_array_equal(again, image)
    else:
        own = channel_of_pixels(format_[6:], image.shape[:2])[..., None]
        np.testing.assert_array_equal(
            np.take_along_axis(again, own, 2), np.take_along_axis(image, own, 2)
        )


def test_chroma_that_is_sent_is_the_mean_of_its_pixels(rng):
    image = rng.integers(0, 256, (3, 8, 3), dtype=np.uint8)
    luma = image @ (0.299, 0.587, 0.114)
    for format_, order in UNITS.items():
        n = order.count("Y")
        raw = np.frombuffer(from_rgb(image, format_), np.uint8).reshape(3, -1)
        y, u, v = planes_of(raw, format_)
        assert np.abs(y - luma).max() <= 0.51
        for sent, of, factor in ((u, image[..., 2], 1.772), (v, image[..., 0], 1.402)):
            means = ((of - luma) / factor).reshape(3, -1, n).mean(axis=2)
            assert np.abs(sent[:, ::n] - np.minimum(means, 127)).max() <= 0.51


@pytest.mark.parametrize("format_", FORMATS)
def test_a_byte_too_few_is_refused(format_):
    for height, width in ((2, 4), (48, 64)):
        raw = bytes(width * height * BITS_OF_PIXEL.get(format_, 8) // 8)
        assert _core.to_rgb(raw, width, height, format_).shape == (height, width, 3)
        with pytest.raises(ValueError, match=f"{len(raw)} bytes, got {len(raw) - 1}"):
            _core.to_rgb(raw[1:], width, height, format_)


@pytest.mark.parametrize(
    ("format_", "size", "expected"),
    [
        ("yuv422", (5, 4), "multiple of 2 px"),
        ("yuv411", (6, 4), "multiple of 4 px"),
        ("bayer_rggb", (1, 4), "2 x 2 px"),
        ("bayer_bggr", (4, 1), "2 x 2 px"),
        ("mono8", (0, 4), "1 x 1 px"),
        ("rgb8", (4, -1), "1 x 1 px"),
        ("yuv422", (2**31 - 2, 2**31 - 1), "9223372023969873924 bytes"),
        ("nv12", (4, 4), "format"),
    ],
)
def test_sizes_that_a_format_does_not_have_are_refused(format_, size, expected):
    with pytest.raises(ValueError, match=expected):
        _core.to_rgb(bytes(64), *size, format_)


@pytest.mark.parametrize(
    ("bus", "codings"),
    [
        (firewire, "yuv422 rgb8 yuv444 raw8 yuv411 mono8 mono16"),
        (gige, "rgb8 raw8 yuv422 mono8"),
    ],
)
def test_the_codings_of_a_bus_stand_in_the_order_of_their_worth(bus, codings):
    assert list(bus.CODINGS) == codings.split()
