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
from sizes import thorough

pytestmark = pytest.mark.filterwarnings("ignore:a noise of")  # of less than 1 %

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


def check_all_equal(function):
    """All paths give the same; return what they give."""
    first, *others = on_each_path(function)
    for other in others:
        np.testing.assert_equal(other, first)
    return first


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


def test_the_classes_are_those_of_rgb_to_yuv(rng):
    image = rng.integers(0, 256, (60, 131, 3), dtype=np.uint8)
    color = robsim.ColorClass("some", y=(40, 200), u=(90, 140), v=(120, 190))
    y, u, v = np.moveaxis(robsim.vision.rgb_to_yuv(image), 2, 0)
    belongs = (y >= 40) & (y <= 200) & (u >= 90) & (u <= 140) & (v >= 120) & (v <= 190)
    for found in on_each_path(lambda: blobs(image, [color])):
        assert sum(area for area, *_ in found["some"]) == belongs.sum()


limits = st.tuples(st.integers(0, 255), st.integers(0, 255)).map(sorted).map(tuple)


@pytest.mark.long
@settings(max_examples=thorough(120, 60))
@given(
    width=st.integers(1, 200),
    height=st.integers(1, 4),
    seed=st.integers(0, 2**32 - 1),
    ranges=st.lists(st.tuples(limits, limits, limits), min_size=1, max_size=9),
)
def test_blobs_of_random_pixels_and_classes(width, height, seed, ranges):
    image = np.random.default_rng(seed).integers(0, 256, (height, width, 3), dtype=np.uint8)
    classes = [robsim.ColorClass(f"color{i}", y=y, u=u, v=v) for i, (y, u, v) in enumerate(ranges)]
    check_all_equal(lambda: blobs(image, classes))


@pytest.mark.long
def test_every_colour_that_there_is():
    red, green = np.mgrid[0:256, 0:256].astype(np.uint8)
    classes = [
        robsim.ColorClass("low", u=(0, 127)),
        robsim.ColorClass("mid", y=(60, 99), v=(90, 170)),
    ]
    some = [robsim.ColorClass("some", y=(60, 120), u=(90, 255), v=(0, 170))]
    for blue in range(0, 256, 15):
        image = np.dstack((red, green, np.full_like(red, blue)))
        check_all_equal(lambda image=image: blobs(image, classes))
        # A window of equal pixels has the class of the pixel.
        few = np.ascontiguousarray(image[::3, ::3])
        large = np.ascontiguousarray(few.repeat(3, 0).repeat(3, 1))
        smoothed = check_all_equal(
            lambda large=large: robsim.vision.classify(large, some, smoothing=3)
        )
        plain = robsim.vision.classify(few, some)
        np.testing.assert_array_equal(smoothed["some"][1::3, 1::3], plain["some"])


# Widths around those of the registers, in pixels and in bytes.
ODD_WIDTHS = (1, 21, 22, 31, 33, 42, 63, 64, 65, 85, 127, 128, 129, 171, 191, 193, 255, 257, 321)


@pytest.mark.long
@pytest.mark.parametrize("window", range(1, 17, 2))
def test_every_window_on_odd_widths(window, rng):
    colors = [
        robsim.ColorClass("any", y=(90, 200)),
        robsim.ColorClass("reddish", v=(133, 255)),
        robsim.ColorClass("neither", y=(100, 255), u=(0, 127), v=(100, 127)),
        robsim.ColorClass("bluish", u=(128, 255)),
    ]
    for width in ODD_WIDTHS:
        image = rng.integers(0, 256, (20, width, 3), dtype=np.uint8)
        # Grey, but for a few pixels: means are computed in some blocks of a row only.
        grey = np.repeat(image[:, :, :1], 3, axis=2)
        grey[rng.integers(0, 20, 3), rng.integers(0, width, 3)] = (255, 0, 0)
        for pixels, classes in ((image, colors), (grey, colors[1:])):
            masks = check_all_equal(
                lambda p=pixels, c=classes: robsim.vision.classify(p, c, smoothing=window)
            )
            if width > 100 and pixels is image:
                assert 0 < masks["bluish"].mean() < 1


@pytest.mark.long
@settings(max_examples=thorough(80, 40))
@given(
    width=st.integers(1, 120),
    height=st.integers(1, 4),
    seed=st.integers(0, 2**64 - 1),
    index=st.integers(0, 2**40),
    kind=st.sampled_from([robsim.UniformNoise, robsim.GaussianNoise]),
    percent=st.floats(0.01, 100),
)
def test_noise(width, height, seed, index, kind, percent):
    clean = np.random.default_rng(seed).integers(0, 256, (height, width, 3), dtype=np.uint8)
    check_all_equal(lambda: kind(percent).add(clean, seed, index))


@pytest.mark.parametrize("kind", [robsim.UniformNoise, robsim.GaussianNoise])
def test_noise_of_wide_images(kind, rng):
    # More bytes in a row than are kept back at a time for the tails of the distribution.
    clean = rng.integers(0, 256, (3, 2011, 3), dtype=np.uint8)
    for percent in (0.3, 4, 40, 90):
        check_all_equal(lambda percent=percent: kind(percent).add(clean, 1, 2))


@pytest.mark.long
@pytest.mark.parametrize(("robot", "headings"), [("lab", 0), ("sheep", 0), ("lab", 7)])
def test_the_renderer(robot, headings, rng):
    robot = robsim.load_robot(robot)
    poses = np.column_stack((rng.uniform(-60, 1260, (40, 2)), rng.uniform(-4, 4, 40)))
    edges = [(100.0, 1100.0, 0.0), (800.0, 600.0, np.pi / 2), (1e9, 0.0, 1.0)]

    def draw():
        # An adjust_background of its own makes a scene of its own, and in it the headings.
        options = {"headings": headings, "adjust_background": lambda floor: floor}
        own = renderer(robot=robot, resolution=(300, 260), **options)
        return [own.render(pose).copy() for pose in [*poses, *edges]]

    check_all_equal(draw)


@pytest.mark.parametrize("rows", [1, 255, 256, 300])
def test_estimators(rows, rng):
    # Of the columns one is zero, and one is determined by others.
    phi = rng.normal(size=(rows, 6))
    phi[:, 2] = 0
    phi[:, 5] = phi[:, 0] - phi[:, 1]
    y = rng.normal(size=rows)

    def estimates():
        fit = robsim.estimation.least_squares(phi, y)
        recursive = robsim.RecursiveLeastSquares(6, n_filters=3, forgetting=0.98)
        history = recursive.update(np.repeat(phi[:, None], 3, 1), np.column_stack((y, 2 * y, -y)))
        errors = (fit.standard_errors, fit.standard_errors_unscaled, fit.residual_rms)
        return fit.theta, *errors, history, recursive.P

    check_all_equal(estimates)


def test_a_run_in_noise():
    def run():
        sim = robsim.Simulation(
            resolution=(240, 240), noise=robsim.GaussianNoise(10), measure=True, seed=5
        )
        return sim.run(20).pose_measured, sim.frame.image

    check_all_equal(run)
