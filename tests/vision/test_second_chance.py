"""The second chance: colours relative to brightness, where the classes as they are find no pair."""

import pickle

import numpy as np
import pytest

import robsim
from light import AREA, EMPTY, LIGHTS, MARKERS, Light, by_classes, by_hsv
from robsim import ColorClass, _core
from robsim.vision import detect

COLORS = robsim.load_colors()
SIZE = (300, 300)
POSES = ((170.0, 380.0, 0.4), (430.0, 150.0, -2.2))
GREY = (1.0, 1.0, 1.0)


@pytest.fixture(autouse=True)
def _path():
    before = _core.cpu_path()
    yield
    _core.force_cpu_path(before)


def off(detection, pose):
    """How far a detection is off (px of the area)."""
    assert detection.measurement is not None, detection.explanation
    return np.hypot(*(detection.measurement.pose[:2] - pose[:2]))


@pytest.mark.long
@pytest.mark.parametrize(
    "name",
    [
        *("exposure 0.15", "exposure 0.2", "exposure 0.25", "exposure 0.3", "exposure 0.35"),
        *("faded", "faded, exposure .5", "faded, Gaussian 5 %", "exposure .3, Gaussian 5 %"),
        *("cast 1.4, 1, 0.5", "cast .6, 1, 1.3 at .3", "wooden floor at .3", "green floor at .3"),
    ],
)
def test_what_the_classes_miss_is_found_relative_to_brightness(name):
    for i, pose in enumerate(POSES):
        frame = LIGHTS[name].frame(pose, SIZE, 3, i)
        assert by_classes(frame, second_chance=False).measurement is None
        detection = by_classes(frame)
        assert off(detection, pose) < (1.5 if "Gaussian" in name else 0.5)
        assert detection.by_second_chance
        assert detection.reason is None
        assert "second chance, by colours relative to brightness" in detection.explanation


@pytest.mark.long
@pytest.mark.parametrize("gradient", [(0.2, 1), (1, 0.2), (0.3, 1.2)])
def test_in_a_gradient_of_light_the_robot_is_found_everywhere(gradient):
    light = Light(gradient=gradient)
    for i, x in enumerate((70.0, 220.0, 530.0)):
        pose = (x, 300.0, 1.0)
        assert off(by_classes(light.frame(pose, SIZE, 4, i)), pose) < 0.5


@pytest.mark.parametrize("name", ["exposure 0.5", "exposure 1", "exposure 3", "cast 1.3, 1, 0.8"])
def test_where_a_pair_is_found_there_is_no_second_chance(name):
    frame = LIGHTS[name].frame(POSES[0], SIZE, 5, 0)
    detection = by_classes(frame)
    assert off(detection, POSES[0]) < 0.5
    assert not detection.by_second_chance
    assert detection == by_classes(frame, second_chance=False)


def test_strong_casts_and_overexposure_hide_the_robot_from_hsv_but_not_from_it():
    for name in ("cast 1.3, 1, 0.8", "cast 0.85, 1, 1.4", "exposure 3"):
        frame = LIGHTS[name].frame(POSES[0], SIZE, 6, 0)
        assert by_hsv(frame).measurement is None
        assert off(by_classes(frame), POSES[0]) < 0.5


@pytest.mark.long
@pytest.mark.parametrize("noise", ["clean", "Gaussian 10 %", "Gaussian 40 %", "uniform 60 %"])
@pytest.mark.parametrize("size", [(320, 240), (640, 480)])
def test_no_pose_is_reported_on_an_empty_floor(noise, size):
    for exposure in (0.3, 1):
        light = Light(exposure, noise=EMPTY[noise])
        for i in range(2):
            detection = by_classes(light.frame(None, size, 7, i))
            assert detection.measurement is None
            assert not detection.by_second_chance


def test_a_detection_that_finds_nothing_stays_as_it_was():
    frame = Light(0.3).frame(None, SIZE, 8, 0)
    assert by_classes(frame) == by_classes(frame, second_chance=False)


def test_the_robot_software_takes_the_second_chance():
    light = Light(0.2)
    frames = [light.frame(pose, SIZE, 9, i) for i, pose in enumerate(POSES)]
    seen = []

    def control(step):
        seen.append(step.detection)
        return 0, 0

    experiment = robsim.Experiment(frames, robot="lab", smoothing=1, control=control)
    experiment.run()
    frame = frames[0]
    blobs = robsim.find_blobs(frame, COLORS, markers=experiment.markers, smoothing=1)
    assert blobs == {"red": [], "blue": []}
    assert np.isfinite(experiment.trace.pose_measured).all()
    assert experiment.missed_detections == []
    assert [detection.by_second_chance for detection in seen] == [True, True]


def test_the_flag_belongs_to_the_value():
    frame = Light(0.2).frame(POSES[0], SIZE, 10, 0)
    detection = by_classes(frame)
    assert pickle.loads(pickle.dumps(detection)) == detection
    assert pickle.loads(pickle.dumps(detection)).by_second_chance


def test_colours_go_with_an_image():
    with pytest.raises(ValueError, match="colors must come with an image, got no image"):
        detect({"red": [], "blue": []}, MARKERS, colors=COLORS)


# --- the masks


def slow_masks(image, colors, window, gains, least_chroma):
    """The same in numpy, in single precision."""
    single = np.float32
    padded = np.pad(image.astype(int), ((window // 2,) * 2,) * 2 + ((0, 0),), mode="edge")
    sums = np.lib.stride_tricks.sliding_window_view(padded, (window, window), (0, 1)).sum((3, 4))
    r, g, b = (
        single(gain) / single(window**2) * sums[..., i].astype(single)
        for i, gain in enumerate(gains)
    )
    u = (single(64) * b - single(22) * r - single(42) * g) / single(128)
    v = (single(64) * r - single(54) * g - single(10) * b) / single(128)
    brightness = np.maximum(np.maximum(r, g), b)
    masks = {}
    for color in colors:
        limits = [(color.u, u), (color.v, v)]
        distance = single(max(max(low - 128, 128 - high) for (low, high), _ in limits))
        full = single(180) * min(distance / single(26), single(1))
        scale = np.maximum(brightness, single(least_chroma) * full / distance)
        inside = np.ones(u.shape, bool)
        for (low, high), chroma in limits:
            if low > 0:
                inside &= chroma >= single(low - 128) / full * scale
            if high < 255:
                inside &= chroma <= single(high - 128) / full * scale
        masks[color.name] = inside
    return masks


@pytest.mark.long
@pytest.mark.parametrize("path", _core.cpu_paths())
@pytest.mark.parametrize("window", [1, 3, 7, 15])
@pytest.mark.parametrize("shape", [(1, 1), (9, 64), (20, 131), (5, 3)])
def test_the_masks_are_those_of_numpy_on_every_path(path, window, shape, rng):
    _core.force_cpu_path(path)
    image = rng.integers(0, 256, (*shape, 3)) * rng.uniform(0.05, 1, (shape[0], 1, 1))
    image = image.astype(np.uint8)
    weak = ColorClass("weak", u=(0, 121), v=(100, 140))
    for gains in (GREY, (1.0, 1.3, 2.9)):
        masks = _core.relative_masks(image, [*COLORS, weak], window, gains, 3.3)
        expected = slow_masks(image, [*COLORS, weak], window, gains, 3.3)
        for name, mask in masks.items():
            np.testing.assert_array_equal(mask, expected[name])


def test_a_colour_belongs_by_its_saturation_not_by_its_brightness():
    for level in (255, 120, 40, 20):
        least = np.ceil(level * (1 - 0.285)) - 1  # a saturation of 29 %
        most = np.floor(level * (1 - 0.295)) + 1
        reds = np.array([[(level, most - 2, most - 2), (level, least + 2, least + 2)]], np.uint8)
        masks = _core.relative_masks(reds, COLORS, 1, GREY, 0.1)
        assert masks["red"].tolist() == [[True, False]], level
        assert not masks["blue"].any()


def test_colours_that_drown_in_noise_belong_to_none():
    dark_red = np.full((1, 1, 3), (12, 4, 4), np.uint8)  # V - 128 is 4
    for least_chroma, belongs in ((3.9, True), (4.1, False)):
        masks = _core.relative_masks(dark_red, COLORS, 1, GREY, least_chroma)
        assert masks["red"].all() == belongs


def test_classes_that_need_brightness_have_no_second_chance():
    white = ColorClass("white", y=(200, 255), u=(118, 138), v=(118, 138))
    limited = ColorClass("red", y=(30, 200), v=(154, 255))
    grey_too = ColorClass("any", v=(120, 255))
    image = np.full((2, 2, 3), (200, 20, 20), np.uint8)
    masks = _core.relative_masks(image, [white, limited, grey_too], 1, GREY, 1)
    assert not any(mask.any() for mask in masks.values())


def test_the_frames_are_those_of_the_scene():
    frame = Light().frame(POSES[0], SIZE, 1, 0)
    (x, y, heading), (forward, right) = POSES[0], MARKERS.positions["right"]
    sine, cosine = np.sin(heading), np.cos(heading)
    red = x + forward * cosine - right * sine, y + forward * sine + right * cosine
    u, v = frame.plane_map.to_pixel(red).astype(int)
    assert frame.image.shape == (*SIZE[::-1], 3)
    assert frame.plane_map.to_world((0, 0)) == pytest.approx((AREA[0] / SIZE[0] - 1) / 2)
    assert frame.image[v, u] == pytest.approx((198, 36, 40), abs=2)
