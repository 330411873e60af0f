"""Frames: the memory of others, and the drawn headings."""

import copy
import gc
import pickle
import weakref

import numpy as np
import pytest

import robsim
from python_devices import PATIENT
from refusals import refuses
from robsim import Frame
from robsim.lab import SimulatedLab
from robsim.trace import Session
from robsim.vision import (
    PlaneMap,
    classify,
    color_histograms,
    paint_classes,
    save_image,
    save_video,
)
from scenes import renderer

# --- the memory of others


COLORS = robsim.load_colors()
CAMERA = (150, 100)
POSE = (500.0, 700.0, 0.4)


def draw():
    return renderer(resolution=CAMERA)


@pytest.fixture(scope="module")
def drawn():
    return draw().render(POSE).copy()


def borrowed(image):
    return Frame(image, copy=False)


def wider(image, *, left=5, right=7):
    """The image as a part of a wider one: its rows have gaps between them."""
    return np.pad(image, ((2, 3), (left, right), (0, 0)))[2:-3, left:-right]


LAYOUTS = {
    "rows with gaps": wider,
    "a memoryview": lambda image: memoryview(image.tobytes()).cast("B", image.shape),
    "every second row": lambda image: np.repeat(image, 2, axis=0)[::2],
}


@pytest.mark.parametrize("lay_out", LAYOUTS.values(), ids=LAYOUTS)
def test_a_borrowed_frame_is_seen_as_its_copy(lay_out, drawn):
    frame, copy = borrowed(lay_out(drawn)), Frame(drawn)
    np.testing.assert_array_equal(frame.image, drawn)
    assert not frame.image.flags.writeable
    assert frame._repr_png_() == copy._repr_png_()
    for smoothing in (1, 3):
        found, expected = (
            robsim.find_blobs(f, COLORS, minimum_area=1, smoothing=smoothing) for f in (frame, copy)
        )
        assert found == expected
    for function in (
        lambda f: classify(f, COLORS)["red"],
        lambda f: paint_classes(f, classify(f, COLORS)),
        lambda f: color_histograms(f, (10, 10, 90, 80)),
    ):
        np.testing.assert_array_equal(function(frame), function(copy))


def test_it_shows_what_is_in_the_memory_now():
    memory = np.zeros((8, 10, 3), np.uint8)
    frame, copy = borrowed(memory), Frame(memory)
    assert np.shares_memory(frame.image, memory)
    memory[3, 4] = 200
    assert frame.image[3, 4, 0] == 200
    assert copy.image[3, 4, 0] == 0


@pytest.mark.long
def test_the_memory_lives_as_long_as_the_frame_and_its_images():
    class Memory(np.ndarray):
        pass

    memory = np.full((8, 10, 3), 7, np.uint8).view(Memory)
    is_alive = weakref.ref(memory)
    frame = borrowed(memory)
    del memory
    gc.collect()
    assert is_alive() is not None
    image = frame.image
    del frame
    gc.collect()
    assert (image == 7).all()
    del image
    gc.collect()
    assert is_alive() is None


def test_what_cannot_be_borrowed(drawn):
    for value in (bytearray(12), memoryview(bytes(24)).cast("H", (2, 2, 3)), drawn[:0]):
        refuses("image", borrowed, value)
    for apart in (drawn[:, ::2], drawn[:, :, ::-1], np.asfortranarray(drawn)):
        assert "ascontiguousarray" in refuses("image", borrowed, apart)


def test_numpy_takes_a_frame_for_its_pixels(drawn):
    frame = Frame(drawn)
    shown = np.asarray(frame)
    np.testing.assert_array_equal(shown, drawn)
    assert np.shares_memory(shown, frame.image)
    assert np.array(frame).flags.writeable
    assert np.asarray(frame, np.float64).dtype == np.float64


# --- drawing and noise into the memory of others


@pytest.mark.parametrize("headings", [0, 36])
@pytest.mark.parametrize("lay_out", [np.copy, wider], ids=["rows one after the other", "gaps"])
def test_drawing_into_given_memory(headings, lay_out, rng):
    into, fresh = (renderer(headings=headings, resolution=CAMERA) for _ in range(2))
    out = lay_out(np.full((*CAMERA[::-1], 3), 3, np.uint8))
    around = out.base
    before = None if around is None else around.copy()
    for k in range(6):
        pose, pan = (*rng.uniform(-50, 1250, 2), rng.uniform(-3, 3)), (k % 3, 40 * (k % 2))
        out[:] = k  # whatever was there before
        assert into.render(pose, pan, out=out) is out
        np.testing.assert_array_equal(out, fresh.render(pose, pan))
        np.testing.assert_array_equal(into.render(pose, pan), out)
    if before is not None:  # the gaps stay as they are
        before[2:-3, 5:-7] = around[2:-3, 5:-7]
        np.testing.assert_array_equal(around, before)


def test_what_cannot_be_drawn_into(drawn):
    read_only = np.frombuffer(drawn.tobytes(), np.uint8).reshape(drawn.shape)
    small, narrow = np.empty_like(drawn[:-1]), np.empty_like(drawn[:, :-1])
    for out in (read_only, drawn.astype(float), small, narrow, drawn[..., 0], drawn[::-1]):
        with pytest.raises((TypeError, ValueError), match="out"):
            draw().render((5, 4, 0), out=out)


# --- images in OpenCV's order


def test_from_bgr_exchanges_red_and_blue(rng):
    image = rng.integers(0, 256, (3, 4, 3), dtype=np.uint8)
    plane_map = PlaneMap.scaled((4, 3), (40, 30))
    frame = Frame.from_bgr(image, t=2.5, index=7, plane_map=plane_map, headings=8)
    np.testing.assert_array_equal(frame.image, image[..., ::-1])
    assert (frame.t, frame.index, frame.headings) == (2.5, 7, 8)
    np.testing.assert_array_equal(frame.plane_map.matrix, plane_map.matrix)
    wide = np.zeros((3, 8, 3), np.uint8)[:, :4]
    assert Frame.from_bgr(wide).image.shape == (3, 4, 3)
    refuses("image", Frame.from_bgr, image[..., 0])
    refuses("index", Frame.from_bgr, image, index=-1)


# --- drawn headings


AREA = (400, 300)
ROUNDED = np.radians(10) / np.sqrt(12)  # of 36 headings


def simulation(**options):
    return robsim.Simulation(robot="lab", area=AREA, seed=1, **options)


def heading_sd(frame):
    markers = robsim.load_robot("lab").marker_layout()
    blobs = robsim.find_blobs(frame, robsim.load_colors(), markers=markers)
    return np.sqrt(robsim.locate(blobs, markers, image=frame).covariance[2, 2])


@pytest.fixture(scope="module")
def frame():
    return simulation().step().frame


def test_of_the_simulation(frame):
    assert frame.headings == 36
    assert copy.deepcopy(frame).headings == pickle.loads(pickle.dumps(frame)).headings == 36
    assert frame != robsim.Frame(frame.image, t=frame.t, plane_map=frame.plane_map)
    assert heading_sd(frame) == pytest.approx(ROUNDED, rel=0.02)
    assert simulation(headings=None).step().frame.headings is None


def test_an_array_does_not_tell(frame):
    plain = robsim.Frame(frame.image, plane_map=frame.plane_map)
    assert plain.headings is None
    assert heading_sd(plain) < ROUNDED / 10
    assert heading_sd(robsim.Frame(frame.image, headings=36)) == heading_sd(frame)


@pytest.mark.parametrize("headings", [36, None])
def test_of_the_simulated_lab(headings):
    world = robsim.Scenario(robot="lab", area=AREA, headings=headings, seed=1)
    with SimulatedLab(world, fps=50) as lab, robsim.Camera(lab, **PATIENT) as camera:
        assert camera.read(300).headings == headings


@pytest.mark.long
def test_of_a_video(tmp_path, frame):
    pytest.importorskip("cv2")
    for name in ("run.mkv", "run.webm"):
        save_video(tmp_path / name, [frame] * 3, fps=5)
        recording = robsim.Recording(tmp_path / name)
        assert recording.headings == 36
        assert [frame.headings for frame in recording] == [36, 36, 36]
        assert robsim.Recording(tmp_path / name, headings=72).headings == 72
        with robsim.Camera(tmp_path / name, **PATIENT) as camera:
            assert camera.read(300).headings == 36
    for frames in ([frame, frame.image], [simulation(headings=None).step().frame]):
        save_video(tmp_path / "other.mkv", frames, fps=5)
        assert robsim.Recording(tmp_path / "other.mkv").headings is None


def test_headings_of_a_folder_are_given(tmp_path, frame):
    save_image(tmp_path / "0.png", frame.image)
    assert robsim.Recording(tmp_path).headings is None
    assert next(iter(robsim.Recording(tmp_path, headings=36))).headings == 36
    for take in (robsim.Recording, lambda folder, headings: robsim.Frame(frame.image, headings=0)):
        with pytest.raises(ValueError, match="headings"):
            take(tmp_path, headings=0)


def recorded(folder, headings):
    drawing = simulation(headings=headings)
    frames = [drawing.step().frame for _ in range(2)]
    with robsim.Experiment(frames, record=folder, area=AREA) as experiment:
        experiment.run()
    return Session(folder)


@pytest.mark.parametrize("headings", [36, None])
def test_of_a_session(tmp_path, headings):
    pytest.importorskip("cv2")
    session = recorded(tmp_path / "run", headings)
    assert [seen.frame.headings for seen in session] == [headings, headings]
    assert session.trace.info.headings == headings


def test_the_trace_of_an_experiment_tells_what_its_frames_do():
    drawing = simulation()
    first, second = drawing.step().frame, drawing.step().frame
    plain = robsim.Frame(second.image, t=1.0)
    with robsim.Experiment([first, second, None, plain], area=AREA, measure=True) as experiment:
        assert experiment.run(3).info.headings == 36
        assert "drawn in 36 headings" in str(experiment.trace.tracking())
        experiment.reset()
        assert experiment.trace.info.headings is None
        assert experiment.run().info.headings is None
