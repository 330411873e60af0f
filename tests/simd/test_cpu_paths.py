"""All paths of the hot loops give the same, bit for bit."""

import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import robsim
from robsim import _core
from scenes import renderer

PATHS = _core.cpu_paths()


@pytest.fixture(autouse=True)
def _path():
    before = _core.cpu_path()
    yield
    _core.force_cpu_path(before)


def on_each_path(function):
    results = []
    for path in PATHS:
        _core.force_cpu_path(path)
        assert _core.cpu_path() == path
        results.append(function())
    return results


def blobs(image, classes):
    found = robsim.find_blobs(image, classes, minimum_area=1, maximum_count=10_000)
    return {
        name: [(b.area, b.centroid.tolist(), b.bounding_box, b.at_border) for b in several]
        for name, several in found.items()
    }


def test_the_fastest_path_is_the_default():
    assert ["baseline", "avx2", "avx512"][: len(PATHS)] == PATHS
    assert _core.cpu_path() == PATHS[-1]


@pytest.mark.skipif(not Path("/proc/cpuinfo").exists(), reason="the system does not list them")
def test_the_paths_are_those_that_the_system_names():
    flags = set(re.findall(r"\w+", Path("/proc/cpuinfo").read_text()))
    wide = {"avx512f", "avx512bw", "avx512dq", "avx512vl", "avx512vbmi"}
    assert ("avx2" in PATHS) == ("avx2" in flags)
    assert ("avx512" in PATHS) == (wide | {"avx2"} <= flags)


@pytest.mark.parametrize("path", ["sse9", "", "AVX2"])
def test_a_path_that_there_is_not(path):
    with pytest.raises(ValueError, match=f"path must be one that this processor has, got '{path}'"):
        _core.force_cpu_path(path)


limits = st.tuples(st.integers(0, 255), st.integers(0, 255)).map(sorted).map(tuple)


@pytest.mark.long
@settings(max_examples=120, deadline=None)
@given(
    width=st.integers(1, 200),
    height=st.integers(1, 4),
    seed=st.integers(0, 2**32 - 1),
    ranges=st.lists(st.tuples(limits, limits, limits), min_size=1, max_size=9),
)
def test_blobs_of_random_pixels_and_classes(width, height, seed, ranges):
    image = np.random.default_rng(seed).integers(0, 256, (height, width, 3), dtype=np.uint8)
    classes = [robsim.ColorClass(f"color{i}", y=y, u=u, v=v) for i, (y, u, v) in enumerate(ranges)]
    first, *others = on_each_path(lambda: blobs(image, classes))
    for other in others:
        assert other == first


def test_every_colour_that_there_is():
    red, green = np.mgrid[0:256, 0:256].astype(np.uint8)
    classes = [
        robsim.ColorClass("low", u=(0, 127)),
        robsim.ColorClass("mid", y=(60, 99), v=(90, 170)),
    ]
    for blue in range(0, 256, 15):
        image = np.ascontiguousarray(np.dstack((red, green, np.full_like(red, blue))))
        first, *others = on_each_path(lambda image=image: blobs(image, classes))
        for other in others:
            assert other == first


def test_the_classes_are_those_of_rgb_to_yuv(rng):
    image = rng.integers(0, 256, (60, 131, 3), dtype=np.uint8)
    color = robsim.ColorClass("some", y=(40, 200), u=(90, 140), v=(120, 190))
    y, u, v = np.moveaxis(robsim.vision.rgb_to_yuv(image), 2, 0)
    belongs = (y >= 40) & (y <= 200) & (u >= 90) & (u <= 140) & (v >= 120) & (v <= 190)
    for found in on_each_path(lambda: blobs(image, [color])):
        assert sum(area for area, *_ in found["some"]) == belongs.sum()


def test_rows_with_a_stride_of_their_own(rng):
    image = rng.integers(0, 256, (50, 300, 3), dtype=np.uint8)
    part = image[5:40, 17:160]
    colors = robsim.load_colors()
    for found in on_each_path(lambda: blobs(part, colors)):
        assert found == blobs(part.copy(), colors)


@pytest.mark.long
@settings(max_examples=80, deadline=None)
@given(
    width=st.integers(1, 120),
    height=st.integers(1, 4),
    seed=st.integers(0, 2**64 - 1),
    index=st.integers(0, 2**40),
    kind=st.sampled_from(["uniform", "gaussian"]),
    percent=st.one_of(st.floats(0.01, 100), st.floats(0.01, 1e6)),
)
def test_noise(width, height, seed, index, kind, percent):
    clean = np.random.default_rng(seed).integers(0, 256, (height, width, 3), dtype=np.uint8)
    noise = _core.VisualNoise(kind, percent)
    first, *others = on_each_path(lambda: noise.add(clean, seed, index))
    for other in others:
        np.testing.assert_array_equal(other, first)


@pytest.mark.long
@pytest.mark.parametrize("robot", ["lab", "sheep"])
@pytest.mark.parametrize("headings", [0, 7])
def test_the_renderer(robot, headings, rng):
    draw = renderer(robot=robsim.load_robot(robot), headings=headings, resolution=(300, 260))
    poses = np.column_stack((rng.uniform(-60, 1260, (40, 2)), rng.uniform(-4, 4, 40)))
    edges = [(100.0, 1100.0, 0.0), (800.0, 600.0, np.pi / 2), (1e9, 0.0, 1.0)]
    for pose in [*poses, *edges]:
        first, *others = on_each_path(lambda pose=pose: draw.render(pose))
        for other in others:
            np.testing.assert_array_equal(other, first)


@pytest.mark.long
def test_headings_are_drawn_once_in_a_scene_and_the_same_in_each():
    def draw():
        # An adjust_background of its own makes a scene of its own.
        scene = renderer(headings=7, resolution=(300, 260), adjust_background=lambda floor: floor)
        return [scene.render((600.0, 500.0, heading)).copy() for heading in range(7)]

    first, *others = on_each_path(draw)
    for other in others:
        np.testing.assert_array_equal(other, first)


@pytest.mark.parametrize("rows", [1, 255, 256, 300])
def test_batch_least_squares(rows, rng):
    # Of the columns one is zero, and one is determined by others.
    phi = rng.normal(size=(rows, 6))
    phi[:, 2] = 0
    phi[:, 5] = phi[:, 0] - phi[:, 1]
    y = rng.normal(size=rows)
    first, *others = on_each_path(lambda: _core.least_squares(phi, y))
    for other in others:
        for name in ("theta", "standard_errors", "standard_errors_unscaled", "residual_rms"):
            np.testing.assert_array_equal(getattr(other, name), getattr(first, name))


@pytest.mark.parametrize("window", range(3, 17, 2))
def test_every_window(window, rng):
    image = rng.integers(0, 256, (40, 150, 3), dtype=np.uint8)
    colors = [
        robsim.ColorClass("bluish", u=(128, 255)),
        robsim.ColorClass("neither", u=(0, 127), v=(0, 127)),
    ]
    first, *others = on_each_path(lambda: robsim.vision.classify(image, colors, smoothing=window))
    assert all(mask.any() and not mask.all() for mask in first.values())
    for other in others:
        for name, mask in first.items():
            np.testing.assert_array_equal(other[name], mask)


# Widths around those of the registers, in pixels and in bytes.
ODD_WIDTHS = (1, 21, 22, 31, 33, 42, 63, 64, 65, 85, 127, 128, 129, 171, 191, 193, 255, 257, 321)


@pytest.mark.parametrize("width", ODD_WIDTHS)
def test_every_window_on_odd_widths(width, rng):
    image = rng.integers(0, 256, (20, width, 3), dtype=np.uint8)
    # Grey, but for a few pixels: means are computed in some blocks of a row only.
    grey = np.repeat(image[:, :, :1], 3, axis=2)
    grey[rng.integers(0, 20, 3), rng.integers(0, width, 3)] = (255, 0, 0)
    colors = [
        robsim.ColorClass("any", y=(90, 200)),
        robsim.ColorClass("reddish", v=(133, 255)),
        robsim.ColorClass("neither", y=(100, 255), u=(0, 127), v=(100, 127)),
    ]
    for pixels, classes in ((image, colors), (grey, colors[1:])):
        for window in range(1, 17, 2):
            first, *others = on_each_path(
                lambda p=pixels, c=classes, w=window: robsim.vision.classify(p, c, smoothing=w)
            )
            for other in others:
                for name, mask in first.items():
                    np.testing.assert_array_equal(other[name], mask)


def test_every_colour_that_there_is_smoothed():
    # A window of equal pixels has the class of the pixel.
    red, green = np.mgrid[0:256:3, 0:256:3].astype(np.uint8)
    classes = [robsim.ColorClass("some", y=(60, 120), u=(90, 255), v=(0, 170))]
    for blue in range(0, 256, 15):
        colors = np.dstack((red, green, np.full_like(red, blue)))
        image = np.ascontiguousarray(colors.repeat(3, 0).repeat(3, 1))
        belongs = robsim.vision.classify(np.ascontiguousarray(colors), classes)["some"]
        for masks in on_each_path(
            lambda image=image: robsim.vision.classify(image, classes, smoothing=3)
        ):
            np.testing.assert_array_equal(masks["some"][1::3, 1::3], belongs)


@pytest.mark.parametrize("kind", ["uniform", "gaussian"])
@pytest.mark.parametrize("percent", [0.3, 4, 40, 90])
def test_noise_of_wide_images(kind, percent, rng):
    # More bytes in a row than are kept back at a time for the tails of the distribution.
    clean = rng.integers(0, 256, (3, 2011, 3), dtype=np.uint8)
    noise = _core.VisualNoise(kind, percent)
    first, *others = on_each_path(lambda: noise.add(clean, 1, 2))
    for other in others:
        np.testing.assert_array_equal(other, first)


def test_a_run_in_noise():
    def run():
        sim = robsim.Simulation(
            resolution=(240, 240), noise=robsim.GaussianNoise(10), measure=True, seed=5
        )
        return sim.run(20).pose_measured, sim.frame.image

    first, *others = on_each_path(run)
    for other in others:
        for a, b in zip(other, first, strict=True):
            np.testing.assert_array_equal(a, b)
