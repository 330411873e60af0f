"""Colours trained on regions of images."""

import numpy as np
import pytest

import robsim
from refusals import refuses
from robsim import ColorClass
from robsim.vision import color_histograms, rgb_to_yuv

CHANNELS = ("y", "u", "v")
RED, BLUE, FLOOR = (198, 36, 40), (30, 60, 220), (150, 148, 146)


def ranges(color):
    return [getattr(color, channel) for channel in CHANNELS]


def same(colors, others):
    assert [(c.name, *ranges(c)) for c in colors] == [(c.name, *ranges(c)) for c in others]


def plain(rgb, size=20):
    return np.full((size, size, 3), rgb, np.uint8)


def darkened(image):
    """As in the shadow."""
    return (image * 0.8).astype(np.uint8)


def single(y, u, v):
    """Histograms of pixels that are all alike."""
    histograms = np.zeros((3, 256), np.int64)
    histograms[np.arange(3), (y, u, v)] = 100
    return histograms


def scene():
    """A grey floor with a red and a blue square of 24 x 24 px."""
    image = plain(FLOOR, 120)
    image[30:54, 30:54] = RED
    image[70:94, 70:94] = BLUE
    return image


REGIONS = {"red": (30, 30, 53, 53), "blue": (70, 70, 93, 93)}


# --- histograms


def test_histograms_count_the_pixels_of_the_region(rng):
    image = rng.integers(0, 256, (40, 50, 3), dtype=np.uint8)
    yuv = rgb_to_yuv(image)[5:21, 10:31].reshape(-1, 3)
    expected = [np.bincount(channel, minlength=256) for channel in yuv.T]
    np.testing.assert_array_equal(color_histograms(image, (10, 5, 30, 20)), expected)
    frame = robsim.Frame(image)
    np.testing.assert_array_equal(color_histograms(frame, (10, 5, 30, 20)), expected)
    np.testing.assert_array_equal(color_histograms(image[::-1], (10, 19, 30, 34)), expected)


def test_regions_lie_within_the_image():
    assert color_histograms(plain(RED), (0, 0, 19, 19)).sum() == 1200
    for region in (
        *((-1, 0, 5, 5), (0, -1, 5, 5), (0, 0, 20, 5), (0, 0, 5, 20), (6, 0, 5, 5), (0, 6, 5, 5)),
        *((0, 0, 2**31 - 1, 5), (-(2**31), 0, 5, 5), (1, 2, 3), (0, 0, 5, 2**31)),
    ):
        refuses("region", color_histograms, plain(RED), region)
        refuses("region", ColorClass.from_region, plain(RED), region, name="red")


# --- the ranges


def test_red_and_blue_by_hand():
    # RED is Y 84, U 102, V 208: open away from 128, 52 wider towards it, at most to 154
    red = ColorClass.from_region(plain(RED), (0, 0, 19, 19), name="red")
    assert (red.name, *ranges(red)) == ("red", (0, 255), (0, 154), (156, 255))
    red = ColorClass.from_region(plain(RED), (0, 0, 19, 19), name="red", margin=60)
    assert ranges(red) == [(0, 255), (0, 162), (154, 255)]
    blue = ColorClass.from_histograms(single(74, 201, 95), name="blue")
    assert ranges(blue) == [(0, 255), (154, 255), (0, 147)]


def test_chroma_ranges():
    for uv, margin, expected in (
        *(((102, 208), 0, [(0, 102), (208, 255)]), ((102, 208), 255, [(0, 255), (154, 255)])),
        # a pale colour keeps half of what it has
        *(((128, 150), 50, [(78, 178), (139, 255)]), ((106, 128), 50, [(0, 117), (78, 178)])),
        # as far on both sides: V counts
        ((90, 90), 50, [(0, 140), (0, 109)]),
    ):
        color = ColorClass.from_histograms(single(80, *uv), name="any", margin=margin)
        assert ranges(color)[1:] == expected


def test_percentiles_leave_out_no_more(rng):
    for percentile in (0, 0.1, 10, 33.3, 49.99):
        counts = rng.integers(0, 5, 256) * (rng.random(256) < 0.2)
        lower, upper = ColorClass.from_histograms(
            np.stack(3 * [counts]), name="x", percentile=percentile, margin=0, limit_y=True
        ).y
        outside = percentile / 100 * counts.sum()
        assert counts[:lower].sum() <= outside + 1e-9
        assert counts[upper + 1 :].sum() <= outside + 1e-9
        assert lower == 0 or counts[: lower + 1].sum() > outside - 1e-9
        assert upper == 255 or counts[upper:].sum() > outside - 1e-9


def test_brightness_is_limited_if_asked_for():
    red = ColorClass.from_region(plain(RED), (0, 0, 19, 19), name="red", margin=20, limit_y=True)
    assert ranges(red) == [(64, 104), (0, 122), (188, 255)]
    white = ColorClass.from_region(
        plain((250, 250, 250)), (0, 0, 9, 9), name="white", margin=20, limit_y=True
    )
    assert ranges(white) == [(230, 255), (108, 148), (108, 148)]


def test_a_region_without_a_colour_is_refused():
    with pytest.raises(ValueError, match=r"U 126\.\.126 and V 129\.\.129"):
        ColorClass.from_region(plain((150, 148, 146)), (0, 0, 19, 19), name="red")


def test_in_dim_light_a_colour_may_be_as_weak_as_all_are():
    # a quarter of the luma, 6 to 16 levels
    for luma, weakest in ((80, 16), (64, 16), (40, 10), (20, 6), (0, 6)):
        color = ColorClass.from_histograms(single(luma, 128, 128 + weakest), name="red")
        assert color.v == (128 + weakest // 2, 255)
        with pytest.raises(ValueError, match="hardly any colour"):
            ColorClass.from_histograms(single(luma, 128, 128 + weakest - 1), name="red")


def test_wrong_options_and_histograms():
    for option, values in {"percentile": (-0.1, 50, np.nan), "margin": (-1, 256)}.items():
        for value in values:
            refuses(
                option,
                ColorClass.from_region,
                plain(RED),
                (0, 0, 9, 9),
                name="red",
                **{option: value},
            )
    for histograms in (
        *(np.zeros((3, 255)), np.zeros((256, 3)), np.zeros((3, 256))),
        *(np.full((3, 256), value) for value in (-1, 0.5, np.inf, 1e300)),
    ):
        refuses("histograms", ColorClass.from_histograms, histograms, name="red")


def test_widened():
    color = ColorClass("red", y=(10, 255), u=(0, 150), v=(160, 200))
    same([color.widened(20)], [ColorClass("red", u=(0, 170), v=(140, 220))])
    same([color.widened(-10)], [ColorClass("red", y=(20, 255), u=(0, 140), v=(170, 190))])
    same([color.widened(0)], [color])
    same([color.widened(255)], [ColorClass("red")])
    refuses("v", color.widened, -21)
    for margin in (-256, 256):
        refuses("margin", color.widened, margin)


# --- what trained colours find


@pytest.mark.parametrize("light", ["light", "shadow"])
def test_trained_in_light_they_find_the_markers_in_shadow_and_noise(light):
    image = scene()
    colors = [ColorClass.from_region(image, box, name=name) for name, box in REGIONS.items()]
    shown = darkened(image) if light == "shadow" else image
    for noise in (None, robsim.UniformNoise(40), robsim.GaussianNoise(40)):
        noisy = shown if noise is None else noise.add(shown, 1)
        blobs = robsim.find_blobs(noisy, colors, minimum_area=60, smoothing=7)
        for name, (left, top, *_) in REGIONS.items():
            (blob,) = blobs[name]
            assert abs(blob.centroid - (left + 11.5, top + 11.5)).max() < 2
            assert 400 < blob.area < 750
