"""Colours judged by the mean of a window: exact, and what finds the robot in noise."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import robsim
from robsim import _core


def smoothed_mask(image, color, window):
    """The pixels of a class, by the mean of the window around each, the slow way."""
    reach = window // 2
    margin = ((reach, reach), (reach, reach), (0, 0))
    padded = np.pad(robsim.rgb_to_yuv(image).astype(int), margin, "edge")
    windows = np.lib.stride_tricks.sliding_window_view(padded, (window, window), axis=(0, 1))
    mean = windows.sum(axis=(-2, -1)) // window**2
    limits = np.array((color.y, color.u, color.v))
    return ((mean >= limits[:, 0]) & (mean <= limits[:, 1])).all(axis=2)


def area_and_moments(mask):
    v, u = np.nonzero(mask)
    return len(u), int(u.sum()), int(v.sum())


@settings(max_examples=60, deadline=None)
@given(
    width=st.integers(1, 150),
    height=st.integers(1, 40),
    window=st.sampled_from([3, 5, 7, 9, 11, 13, 15]),
    seed=st.integers(0, 2**32 - 1),
    path=st.sampled_from(_core.cpu_paths()),
)
def test_it_is_the_mean_of_the_window(width, height, window, seed, path):
    random = np.random.default_rng(seed)
    image = random.integers(0, 256, (height, width, 3), dtype=np.uint8)
    classes = [
        robsim.ColorClass("some", u=(118, 136)),
        robsim.ColorClass("other", y=(110, 255), v=(0, 130)),
        robsim.ColorClass("all"),
    ]
    before = _core.cpu_path()
    _core.force_cpu_path(path)
    try:
        found = robsim.find_blobs(
            image, classes, minimum_area=1, maximum_count=10_000, smoothing=window
        )
    finally:
        _core.force_cpu_path(before)
    for color in classes:
        area, sum_u, sum_v = area_and_moments(smoothed_mask(image, color, window))
        blobs = found[color.name]
        assert sum(blob.area for blob in blobs) == area
        assert sum(blob.area * blob.centroid[0] for blob in blobs) == pytest.approx(sum_u)
        assert sum(blob.area * blob.centroid[1] for blob in blobs) == pytest.approx(sum_v)


def test_images_of_different_sizes_one_after_the_other(rng):
    color = robsim.ColorClass("some", u=(120, 140))
    for shape in ((30, 200, 3), (3, 5, 3), (50, 65, 3)):
        image = rng.integers(0, 256, shape, dtype=np.uint8)
        found = robsim.find_blobs(image, [color], minimum_area=1, maximum_count=9999, smoothing=5)
        assert sum(b.area for b in found["some"]) == smoothed_mask(image, color, 5).sum()


@pytest.mark.parametrize("window", [0, 2, 4, 17, -3])
def test_other_windows_are_refused(window):
    image = np.zeros((20, 20, 3), np.uint8)
    with pytest.raises(ValueError, match="smoothing must be"):
        robsim.find_blobs(image, robsim.load_colors(), smoothing=window)
    with pytest.raises(ValueError, match="smoothing must"):
        robsim.Simulation(smoothing=window).run(1)


@pytest.mark.parametrize("noise", ["uniform", "gaussian"])
def test_the_robot_is_found_in_noise_of_40_percent(noise):
    # Noise that is clipped at black and white takes contrast away: limits nearer to neutral, 128.
    colors = [robsim.ColorClass("red", v=(156, 255)), robsim.ColorClass("blue", u=(156, 255))]
    sim = robsim.Simulation(
        robot="lab",
        rotation="continuous",
        noise=noise,
        noise_percent=40,
        measure=True,
        smoothing=7,
        colors=colors,
        control=robsim.DriveAround(),
        seed=4,
    )
    tracking = sim.run(200).tracking()
    print(tracking)
    assert tracking.valid >= 199
    assert tracking.false == 0
    assert tracking.rms_xy < 0.7
    assert tracking.rms_heading_deg < 1.3
