"""What a camera promises its reader, and how its thread ends."""

import contextlib
import gc
import os
import subprocess
import sys
import textwrap
import threading
import time
import traceback
import warnings
import weakref

import numpy as np
import pytest

import robsim
from python_devices import PATIENT, EndlessCamera, SteppedCamera, read_on
from robsim.lab import CaptureError, UnpluggedError
from threads import forks, in_fork, in_thread
from waiting import wait_for

pytestmark = pytest.mark.threads


def numbered(count):
    """Return images that show their number."""
    return [np.full((24, 32, 3), k % 256, np.uint8) for k in range(count)]


class TimedCamera(SteppedCamera):
    """Its images were exposed at a rate, but for every eighth one, which comes twice as late."""

    def __init__(self, rate, count=62):
        super().__init__(numbered(count), permits=count + 1)
        intervals = np.where(np.arange(count) % 8 == 7, 2, 1) / rate
        self.exposed = iter(time.monotonic() - 15 + np.cumsum(intervals))

    def read(self):
        came = super().read()
        return came and (came[0], next(self.exposed))


@pytest.mark.parametrize(("rate", "told"), [(30, None), (20, None), (15, 15), (7.5, 7.5)])
def test_a_rate_that_a_camera_does_not_keep_is_told(rate, told):
    with robsim.Camera(TimedCamera(rate), fps=30, **PATIENT) as camera:
        wait_for(lambda: camera.counts.grabbed == 62)
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            robsim.Experiment(camera, measure=False, area=camera.size).run()
        assert camera._grabber.kept_rate == (told and pytest.approx((told, 30)))
    assert any(f"{told} frames/s, not 30" in str(one.message) for one in caught) == bool(told)


def grabber_threads():
    with open("/proc/self/status") as file:
        return next(int(line.split()[1]) for line in file if line.startswith("Threads:"))


def delivered(camera, source, count):
    """Let `count` more frames come, and wait till the last has."""
    wanted = camera.counts.grabbed + count
    source.permits.release(count)
    wait_for(lambda: camera.counts.grabbed >= wanted)


@pytest.fixture
def source():
    return SteppedCamera(numbered(300), permits=1)


def test_a_frame_that_is_held_does_not_change_and_other_memory_is_used_again(source):
    with robsim.Camera(source, **PATIENT) as camera:
        held = [camera.read()]
        for _ in range(5):
            delivered(camera, source, 3)
            held.append(camera.read())
        pixels = [frame.image for frame in held]
        places = set()
        for _ in range(20):
            delivered(camera, source, 2)
            places.add(camera.read().image.ctypes.data)
        assert len(places) <= 5
        assert not places & {image.ctypes.data for image in pixels}
        assert all((image == frame.index).all() for image, frame in zip(pixels, held, strict=True))
        assert not any(image.flags.owndata or image.flags.writeable for image in pixels)


def test_times_start_at_the_first_frame(source):
    before = time.monotonic()
    with robsim.Camera(source, **PATIENT) as camera:
        frame = camera.read()
        assert frame.t == 0
        assert before <= frame.epoch <= time.monotonic()
        delivered(camera, source, 3)
        later = camera.read()
    assert 0 < later.t <= later.t_arrival
    assert later.epoch == frame.epoch
    assert later.epoch + later.t_arrival <= time.monotonic()


@pytest.mark.long
def test_other_threads_run_while_a_reader_waits(source):
    with robsim.Camera(source, **PATIENT) as camera:
        camera.read()
        done = threading.Event()

        def count():
            for _ in range(1000):  # each gives the interpreter back
                time.sleep(0)
            done.set()
            source.permits.release()

        with in_thread(count):
            camera.read()
        assert done.is_set()


@pytest.mark.parametrize("error", [UnpluggedError("the cable"), ZeroDivisionError("of theirs")])
def test_an_error_of_the_camera_is_that_of_the_reader_each_time(error):
    source = SteppedCamera([*numbered(1), error], permits=2)
    lengths = []
    with robsim.Camera(source, **PATIENT) as camera:
        assert repr(read_on(camera)[1]) == repr(error)
        for _ in range(5):
            with pytest.raises(type(error)) as told:
                camera.read()
            lengths.append(len(list(traceback.walk_tb(told.value.__traceback__))))
    assert len(set(lengths)) == 1  # its traceback does not grow


def test_what_is_no_image_is_told():
    with pytest.raises(CaptureError, match=r"read\(\)"):
        robsim.Camera(SteppedCamera([np.zeros((4, 4), np.uint8)], permits=1), **PATIENT)


class TestTheEnd:
    def test_the_thread_ends_with_close(self, source):
        before = grabber_threads()
        camera = robsim.Camera(source, **PATIENT)
        assert grabber_threads() == before + 1
        camera.close()
        camera.close()
        assert grabber_threads() == before
        assert source.calls == ["open", "close"]

    def test_the_thread_ends_with_the_camera(self, source):
        before = grabber_threads()
        camera = robsim.Camera(source, **PATIENT)
        gone = weakref.ref(camera)
        del camera
        gc.collect()
        assert gone() is None
        assert grabber_threads() == before
        assert source.calls == ["open", "close"]

    def test_a_camera_whose_end_was_read_can_go(self):
        with robsim.Camera(EndlessCamera(numbered(1)[0], 3), **PATIENT) as camera:
            assert len(list(camera)) > 0
            with contextlib.suppress(EOFError):
                camera.read()
        kept = weakref.ref(camera)
        del camera
        gc.collect()
        assert kept() is None

    @forks
    def test_a_forked_process_is_told_that_the_camera_is_not_its_own(self, source):
        camera = robsim.Camera(source, **PATIENT)

        def look():
            for use in (camera.read, lambda: camera.counts):
                with pytest.raises(RuntimeError, match="opened in another process"):
                    use()
            camera.close()
            with robsim.Camera(SteppedCamera(numbered(3), permits=1), **PATIENT) as mine:
                assert mine.read().index == 0

        in_fork(look)
        assert camera.read().index == 0
        camera.close()


OPEN = f"""
import sys; sys.path.insert(0, {os.path.dirname(__file__) + "/../support"!r})
import numpy, robsim, python_devices
image = numpy.zeros((24, 32, 3), numpy.uint8)
camera = robsim.Camera(python_devices.EndlessCamera(image), **python_devices.PATIENT)
camera.read()
"""


def python(code):
    done = subprocess.run(
        [sys.executable, "-c", OPEN + textwrap.dedent(code)],
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    return done.returncode, done.stdout, done.stderr


@pytest.mark.slow
@pytest.mark.sanitized
@pytest.mark.long
@pytest.mark.parametrize("last", ["sys.exit(0)", "camera.self = camera"])
def test_python_ends_without_a_word_though_a_camera_is_open(last):
    assert python(last) == (0, "", "")


@pytest.mark.long
def test_ctrl_c_ends_the_wait_for_a_frame():
    code = """
    import _thread, signal, threading
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background ignores it
    source = python_devices.SteppedCamera([image], permits=1)
    camera = robsim.Camera(source, **python_devices.PATIENT)
    camera.read()
    try:
        threading.Timer(0.2, _thread.interrupt_main).start()
        camera.read()
    except KeyboardInterrupt:
        print("interrupted")
    """
    assert python(code) == (0, "interrupted\n", "")
