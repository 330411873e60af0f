"""Frames on the memory of others, and images drawn into it."""

import contextlib
import gc
import mmap
import weakref
from multiprocessing.shared_memory import SharedMemory

import numpy as np
import pytest

import robsim
from refusals import NO_IMAGE, Refusal, refusals, refuses
from robsim import Frame
from robsim.vision import classify, color_histograms, paint_classes, score_color
from scenes import renderer

COLORS = robsim.load_colors()
CAMERA = (300, 200)


def draw():
    return renderer(resolution=CAMERA)


def drawn():
    return draw().render((500.0, 700.0, 0.4)).copy()


def wider(image, *, left=5, right=7):
    """The image as a part of a wider one: its rows have gaps between them."""
    return np.pad(image, ((2, 3), (left, right), (0, 0)))[2:-3, left:-right]


LAYOUTS = {
    "rows one after the other": lambda image: image,
    "rows with gaps": wider,
    "read-only": lambda image: np.frombuffer(image.tobytes(), np.uint8).reshape(image.shape),
    "a memoryview": lambda image: memoryview(image.tobytes()).cast("B", image.shape),
    "another buffer": lambda image: memoryview(bytearray(image.tobytes())).cast("B", image.shape),
    "every second row": lambda image: np.repeat(image, 2, axis=0)[::2],
}
in_all_layouts = pytest.mark.parametrize("lay_out", LAYOUTS.values(), ids=LAYOUTS)


@pytest.mark.long
@in_all_layouts
def test_a_borrowed_frame_is_seen_as_its_copy(lay_out):
    image = drawn()
    frame, copy = Frame(lay_out(image), copy=False), Frame(image)
    np.testing.assert_array_equal(frame.image, image)
    assert not frame.image.flags.writeable
    assert frame._repr_png_() == copy._repr_png_()
    for smoothing in (1, 3):
        found, expected = (
            robsim.find_blobs(f, COLORS, minimum_area=1, smoothing=smoothing) for f in (frame, copy)
        )
        assert {c: [(*b.centroid, b.area) for b in blobs] for c, blobs in found.items()} == {
            c: [(*b.centroid, b.area) for b in blobs] for c, blobs in expected.items()
        }
    for function in (
        lambda f: classify(f, COLORS)["red"],
        lambda f: paint_classes(f, classify(f, COLORS)),
        lambda f: color_histograms(f, (10, 10, 90, 80)),
    ):
        np.testing.assert_array_equal(function(frame), function(copy))
    scores = [
        score_color(f, COLORS[0], [(10, 10, 90, 80)], repeats=2, seed=1) for f in (frame, copy)
    ]
    assert scores[0] == scores[1]


def test_a_run_on_borrowed_frames_measures_as_one_on_copies():
    sim = robsim.Simulation(
        measure=True, resolution=(480, 480), control=robsim.DriveAround(), seed=2
    )
    frames = [sim.step().frame for _ in range(8)]
    borrowed = [
        Frame(wider(f.image), copy=False, t=f.t, index=f.index, plane_map=f.plane_map)
        for f in frames
    ]
    trace = robsim.Experiment(borrowed).run()
    np.testing.assert_array_equal(trace.pose_measured, sim.trace.pose_measured)


def test_it_shows_what_is_in_the_memory_now():
    memory = np.zeros((8, 10, 3), np.uint8)
    borrowed, copy = Frame(memory, copy=False), Frame(memory)
    assert np.shares_memory(borrowed.image, memory)
    memory[3, 4] = 200
    assert borrowed.image[3, 4, 0] == 200
    assert copy.image[3, 4, 0] == 0


@pytest.mark.long
def test_the_memory_lives_as_long_as_the_frame_and_its_images():
    class Memory(np.ndarray):
        pass

    memory = np.full((8, 10, 3), 7, np.uint8).view(Memory)
    is_alive = weakref.ref(memory)
    frame = Frame(memory, copy=False)
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


def test_shared_memory_between_two_mappings():
    with contextlib.closing(SharedMemory(create=True, size=8 * 10 * 3)) as shared:
        try:
            other = SharedMemory(shared.name)
            pixels = np.ndarray((8, 10, 3), np.uint8, buffer=shared.buf)
            frame = Frame(other.buf[:240].cast("B", (8, 10, 3)), copy=False)
            pixels[:] = 90
            assert (frame.image == 90).all()
            with pytest.raises(BufferError):
                other.close()
            del frame, pixels
            other.close()
        finally:
            shared.unlink()


def test_a_memory_map_of_a_file(tmp_path):
    image = drawn()
    (tmp_path / "pixels").write_bytes(image.tobytes())
    with (tmp_path / "pixels").open("rb") as file:
        mapped = mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)
    frame = Frame(memoryview(mapped).cast("B", image.shape), copy=False)
    np.testing.assert_array_equal(frame.image, image)


@refusals(
    Refusal(lambda value: Frame(value, copy=False), "image", NO_IMAGE),
    Refusal(
        lambda value: Frame(value, copy=False),
        "image",
        (
            b"abc",
            bytearray(12),
            memoryview(bytes(12)),
            memoryview(bytes(24)).cast("H", (2, 2, 3)),
        ),
    ),
)
def test_what_cannot_be_borrowed(refusal):
    refusal()


def test_pixels_that_do_not_lie_side_by_side_cannot_be_borrowed():
    for image in (drawn()[:, ::2], drawn()[:, :, ::-1], np.asfortranarray(drawn())):
        assert "ascontiguousarray" in refuses(
            "image", lambda value: Frame(value, copy=False), image
        )


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


def test_a_frame_drawn_with_noise_in_shared_memory():
    noise = robsim.GaussianNoise(10)
    expected = noise.add(drawn(), 5, 3)
    with contextlib.closing(SharedMemory(create=True, size=expected.nbytes)) as shared:
        try:
            memory = np.ndarray(expected.shape, np.uint8, buffer=shared.buf)
            draw().render((500.0, 700.0, 0.4), out=memory)
            noise.add(memory, 5, 3, out=memory)
            np.testing.assert_array_equal(Frame(memory, copy=False).image, expected)
            del memory
        finally:
            shared.unlink()


READ_ONLY = np.frombuffer(bytes(300 * 200 * 3), np.uint8).reshape(200, 300, 3)
TOO_SMALL = np.zeros((200, 299, 3), np.uint8)
UPSIDE_DOWN = np.zeros((200, 300, 3), np.uint8)[::-1]


@refusals(
    Refusal(
        lambda value: draw().render((5, 4, 0), out=value),
        "out",
        (5, "out", READ_ONLY.astype(float), READ_ONLY, TOO_SMALL, TOO_SMALL[..., 0], UPSIDE_DOWN),
    )
)
def test_what_cannot_be_drawn_into(refusal):
    refusal()


def test_numpy_takes_a_frame_for_its_pixels():
    image = np.arange(4 * 5 * 3, dtype=np.uint8).reshape(4, 5, 3)
    frame = robsim.Frame(image)
    shown = np.asarray(frame)
    np.testing.assert_array_equal(shown, image)
    assert np.shares_memory(shown, frame.image)
    assert np.array(frame).flags.writeable
    assert np.asarray(frame, np.float64).dtype == np.float64
