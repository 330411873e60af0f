"""The second chance: colours relative to brightness, where the classes as they are find no pair."""

import pickle

import numpy as np
import pytest
from PIL import Image, ImageDraw

import robsim
from foreign_frames import BLUE, CASES, FLOOR, RED, Case, frame_at, layout_of
from robsim import ColorClass, _core
from robsim.vision import detect

COLORS = robsim.load_colors()
MARKERS = layout_of(Case())
SIZE = (300, 300)
POSES = ((170.0, 380.0, 0.4), (430.0, 150.0, -2.2))
GREY = (1.0, 1.0, 1.0)


@pytest.fixture(autouse=True)
def _path():
    before = _core.cpu_path()
    yield
    _core.force_cpu_path(before)


def by_classes(frame, *, second_chance=True):
    """As the default measurement does it, with and without a second chance."""
    blobs = robsim.find_blobs(frame, COLORS, markers=MARKERS)
    given = {"colors": COLORS} if second_chance else {}
    return detect(blobs, MARKERS, plane_map=frame.plane_map, image=frame, **given)


def off(detection, pose):
    """How far a detection is off (px of the area)."""
    assert detection.measurement is not None, detection.explanation
    return np.hypot(*(detection.measurement.pose[:2] - pose[:2]))


@pytest.mark.parametrize(
    "name",
    [
        *("exposure 0.15", "exposure 0.2", "exposure 0.3", "faded, exposure 0.5"),
        *("faded", "faded, Gaussian 5 %", "exposure 0.3, Gaussian 5 %", "yellow"),
        *("blue at 0.3", "wooden floor at 0.3", "green floor at 0.3"),
    ],
)
def test_what_the_classes_miss_is_found_relative_to_brightness(name):
    for pose in POSES:
        frame = frame_at(CASES[name], pose, SIZE)
        assert by_classes(frame, second_chance=False).measurement is None
        detection = by_classes(frame)
        assert off(detection, pose) < (1.5 if "Gaussian" in name else 0.5)
        assert detection.by_second_chance
        assert detection.reason is None
        assert "second chance" in detection.explanation


def test_in_a_gradient_of_light_the_robot_is_found_everywhere():
    for gradient in ((0.2, 1), (1, 0.2), (0.3, 1.2)):
        for x in (70.0, 220.0, 530.0):
            pose = (x, 300.0, 1.0)
            assert off(by_classes(frame_at(Case(gradient=gradient), pose, SIZE)), pose) < 0.5


def test_where_a_pair_is_found_there_is_no_second_chance():
    for name in ("exposure 0.5", "clean", "exposure 3", "reddish", "bluish"):
        frame = frame_at(CASES[name], POSES[0], SIZE)
        detection = by_classes(frame)
        assert off(detection, POSES[0]) < 0.5
        assert not detection.by_second_chance
        assert detection == by_classes(frame, second_chance=False)


@pytest.mark.parametrize("exposure", [1, 0.3])
def test_other_shapes_of_the_markers_colours_and_areas_are_not_seen(exposure):
    def dimmed(color):
        return tuple(int(exposure * level) for level in color)

    image = Image.new("RGB", (160, 160), dimmed(FLOOR))
    for side, color in ((1, RED), (-1, BLUE)):  # bent limbs
        bends = [(x, 80 + side * (21.5 + y)) for x, y in ((62, 10), (80, -10), (98, 10))]
        ImageDraw.Draw(image).line(bends, dimmed(color), width=6, joint="curve")
    frame = robsim.Frame(np.array(image))
    assert by_classes(frame).reason == "shape"
    experiment = robsim.Experiment([frame], robot="lab", area=(160, 160))
    experiment.run()
    assert experiment.trace.tracking().missed == {"shape": 1}


@pytest.mark.long
@pytest.mark.parametrize("noise", [{}, {"gaussian": 10}, {"gaussian": 40}, {"uniform": 60}])
def test_no_pose_is_reported_on_an_empty_floor(noise):
    for size in ((320, 240), (640, 480)):
        for exposure in (0.3, 1):
            for seed in range(2):
                detection = by_classes(frame_at(Case(exposure=exposure, **noise), None, size, seed))
                assert detection.measurement is None
                assert not detection.by_second_chance


def test_the_robot_software_takes_the_second_chance():
    frames = [frame_at(CASES["exposure 0.2"], pose, SIZE) for pose in POSES]
    seen = []

    def control(step):
        seen.append(step.detection)
        return 0, 0

    experiment = robsim.Experiment(frames, robot="lab", smoothing=1, control=control)
    experiment.run()
    blobs = robsim.find_blobs(frames[0], COLORS, markers=experiment.markers, smoothing=1)
    assert blobs == {"red": [], "blue": []}
    assert np.isfinite(experiment.trace.pose_measured).all()
    assert experiment.missed_detections == []
    assert [detection.by_second_chance for detection in seen] == [True, True]
    for copy in pickle.loads(pickle.dumps(seen)):
        assert copy == seen[seen.index(copy)]
        assert copy.by_second_chance


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


@pytest.mark.parametrize("path", _core.cpu_paths())
def test_the_masks_are_those_of_numpy_on_every_path(path, rng):
    _core.force_cpu_path(path)
    colors = [*COLORS, ColorClass("weak", u=(0, 121), v=(100, 140))]
    for shape in ((1, 1), (9, 64), (20, 131), (5, 3)):
        image = rng.integers(0, 256, (*shape, 3)) * rng.uniform(0.05, 1, (shape[0], 1, 1))
        image = image.astype(np.uint8)
        for window in (1, 3, 7, 15):
            for gains in (GREY, (1.0, 1.3, 2.9)):
                masks = _core.relative_masks(image, colors, window, gains, 3.3)
                for name, expected in slow_masks(image, colors, window, gains, 3.3).items():
                    np.testing.assert_array_equal(masks[name], expected)


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
