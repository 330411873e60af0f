"""Which pixel belongs to which class: exact on every path, also where most of an image is grey."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import robsim
from robsim import _core
from sizes import thorough

RED_AND_BLUE = [
    robsim.ColorClass("red", u=(0, 150), v=(156, 255)),
    robsim.ColorClass("blue", u=(156, 255), v=(0, 140)),
]
ALSO_GREY = [
    robsim.ColorClass("dark", y=(0, 90)),
    robsim.ColorClass("neutral", u=(118, 136)),
    robsim.ColorClass("all"),
]


def mask_of(image, color, window=1):
    """The pixels of a class, by the mean of the window around each, the slow way."""
    reach = window // 2
    margin = ((reach, reach), (reach, reach), (0, 0))
    padded = np.pad(robsim.vision.rgb_to_yuv(image).astype(int), margin, "edge")
    windows = np.lib.stride_tricks.sliding_window_view(padded, (window, window), axis=(0, 1))
    mean = windows.sum(axis=(-2, -1)) // window**2
    limits = np.array((color.y, color.u, color.v))
    return ((mean >= limits[:, 0]) & (mean <= limits[:, 1])).all(axis=2)


def grey_with_some_color(random, width, height):
    """A grey image with a few rectangles of any colour, some of them a pixel small."""
    grey = random.integers(0, 256, (height, width, 1))
    image = np.clip(grey + random.integers(-8, 9, (height, width, 3)), 0, 255).astype(np.uint8)
    for _ in range(random.integers(0, 5)):
        u, v = random.integers(width), random.integers(height)
        wide, high = random.integers(1, 30, 2)
        image[v : v + high, u : u + wide] = random.integers(0, 256, 3)
    return image


def any_pixels(random, width, height):
    return random.integers(0, 256, (height, width, 3), dtype=np.uint8)


def in_bands(random, width, height):
    """Rows upon rows of grey, of grey with some colour, and of any pixels, in any order."""
    image = grey_with_some_color(random, width, height)
    v = 0
    while v < height:
        band = image[v : v + random.integers(1, 40)]
        kind = random.integers(3)
        if kind == 0:
            band[:] = 90
        elif kind == 1:
            band[:] = any_pixels(random, width, len(band))
        v += len(band)
    return image


@pytest.fixture(autouse=True)
def _path():
    before = _core.cpu_path()
    yield
    _core.force_cpu_path(before)


@pytest.mark.long
@settings(max_examples=thorough(150, 50))
@given(
    width=st.integers(1, 400),
    height=st.integers(1, 100),
    window=st.sampled_from([1, 3, 5, 7, 9, 11, 13, 15]),
    draw=st.sampled_from([grey_with_some_color, any_pixels, in_bands]),
    seed=st.integers(0, 2**32 - 1),
    colors=st.sampled_from([RED_AND_BLUE, RED_AND_BLUE + ALSO_GREY]),
    path=st.sampled_from(_core.cpu_paths()),
)
def test_the_masks_are_those_of_the_slow_way(width, height, window, draw, seed, colors, path):
    image = draw(np.random.default_rng(seed), width, height)
    check_masks(image, colors, window, path)


@pytest.mark.long
@pytest.mark.parametrize("width", [4096, 4097, 8193])
def test_more_than_64_blocks_in_a_row(width):
    """Blocks at the ends of a word of blocks know their neighbours in the next word."""
    image = np.full((30, width, 3), 90, np.uint8)
    for edge in (4096, 8192):
        image[4:10, edge - 4 : edge] = image[18:24, edge : edge + 4] = (220, 20, 30)
    red = mask_of(image, RED_AND_BLUE[0], 5)
    if width > 4100:
        assert red[6, 4096]
        assert red[20, 4095]
    for path in _core.cpu_paths():
        _core.force_cpu_path(path)
        found = robsim.vision.classify(image, RED_AND_BLUE[:1], smoothing=5)["red"]
        np.testing.assert_array_equal(found, red)


def check_masks(image, colors, window, path):
    _core.force_cpu_path(path)
    masks = robsim.vision.classify(image, colors, smoothing=window)
    for color in colors:
        np.testing.assert_array_equal(masks[color.name], mask_of(image, color, window))


@pytest.mark.parametrize("smoothing", [1, 5])
def test_a_region_is_an_image_of_its_own(rng, smoothing):
    image = rng.integers(0, 256, (60, 150, 3), dtype=np.uint8)
    colors = [robsim.ColorClass("some", u=(150, 255)), robsim.ColorClass("other", v=(0, 120))]
    left, top, right, bottom = region = (13, 7, 120, 41)

    def blobs(image, region=None):
        return robsim.find_blobs(
            image, colors, minimum_area=2, smoothing=smoothing, region=region, maximum_count=999
        )

    cut = blobs(np.ascontiguousarray(image[top : bottom + 1, left : right + 1]))
    found = blobs(image, region)
    for color in colors:
        assert len(found[color.name]) == len(cut[color.name]) > 0
        for a, b in zip(found[color.name], cut[color.name], strict=True):
            assert (a.area, a.at_border) == (b.area, b.at_border)
            np.testing.assert_allclose(
                a.centroid, np.add(b.centroid, (left, top)), rtol=0, atol=1e-9
            )
            assert a.bounding_box == tuple(np.add(b.bounding_box, (left, top, left, top)))


def test_a_region_outside_the_image():
    image = np.zeros((8, 10, 3), np.uint8)
    for region in ((-1, 0, 5, 5), (0, 0, 10, 5), (0, 3, 5, 8), (4, 2, 3, 5), (4, 3, 6, 2)):
        with pytest.raises(ValueError, match=r"region.*10 x 8 px"):
            robsim.find_blobs(image, RED_AND_BLUE, region=region)


def test_classify_refuses_what_find_blobs_refuses():
    image = np.zeros((8, 10, 3), np.uint8)
    for smoothing in (0, 2, 17):
        for call in (robsim.vision.classify, robsim.find_blobs):
            with pytest.raises(ValueError, match="smoothing"):
                call(image, RED_AND_BLUE, smoothing=smoothing)
    with pytest.raises(ValueError, match="'red' twice"):
        robsim.vision.classify(image, RED_AND_BLUE[:1] * 2)


def test_with_markers_the_masks_are_those_that_their_blobs_are_of(rng):
    noise = robsim.GaussianNoise(30)
    sim = robsim.Simulation(robot="lab", measure=True, noise=noise, seed=1)
    frame, markers = sim.step().frame, sim.markers
    colors = list(sim.colors)
    masks = robsim.vision.classify(frame, colors, markers=markers)
    plain = robsim.vision.classify(frame, colors)
    assert (masks["red"] != plain["red"]).any()
    for color, blobs in robsim.find_blobs(frame, colors, markers=markers).items():
        for blob in blobs:
            left, top, right, bottom = blob.bounding_box
            assert masks[color][top : bottom + 1, left : right + 1].sum() >= blob.area
    same = robsim.vision.classify(frame, colors, markers=markers, smoothing=1)
    np.testing.assert_array_equal(same["red"], plain["red"])


def test_painted_classes():
    image = np.full((100, 100, 3), (150, 148, 146), np.uint8)
    image[30:50, 30:50] = (198, 36, 40)
    image[70:90, 70:90] = (30, 60, 220)
    classes = [
        *robsim.load_colors(),
        robsim.ColorClass("dark", y=(0, 80)),
        robsim.ColorClass("no color", y=(0, 10)),
    ]
    masks = robsim.vision.classify(robsim.Frame(image), classes)
    painted = robsim.vision.paint_classes(robsim.Frame(image), masks)
    assert painted[40, 40].tolist() == [255, 0, 0]
    assert painted[80, 80].tolist() == [255, 255, 255]  # blue and dark
    assert painted[5, 5].tolist() == [robsim.vision.rgb_to_yuv(image)[5, 5, 0] // 2] * 3
    alone = robsim.vision.paint_classes(image, {"dark": masks["dark"]})
    assert alone[80, 80].tolist() == [255, 0, 255]
