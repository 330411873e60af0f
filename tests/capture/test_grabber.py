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
import weakref

import numpy as np
import pytest

import robsim
import sanitizers
from python_cameras import EndlessCamera, SteppedCamera, read_on
from robsim.capture import CaptureError, FrameTimeoutError, UnpluggedError
from threads import in_thread

pytestmark = [
    pytest.mark.threads,
    pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning"),
]


def numbered(count):
    """Return images that show their number."""
    return [np.full((24, 32, 3), k % 256, np.uint8) for k in range(count)]


def grabber_threads():
    with open("/proc/self/status") as file:
        return next(int(line.split()[1]) for line in file if line.startswith("Threads:"))


def delivered(camera, source, count):
    """Let `count` more frames come, and wait till the last has."""
    wanted = camera.counts.grabbed + count
    source.permits.release(count)
    while camera.counts.grabbed < wanted:
        time.sleep(0.001)


@pytest.fixture
def source():
    stepped = SteppedCamera(numbered(300))
    stepped.permits.release()
    return stepped


def test_a_slow_reader_gets_what_came_last(source):
    with robsim.Camera(source) as camera:
        camera.read()
        for _ in range(10):
            delivered(camera, source, 7)
            frame = camera.read()
            assert frame.index == camera.counts.grabbed - 1
            assert (frame.image == frame.index).all()
        assert camera.counts.dropped == 60
        assert camera.counts.delivered == 11


def test_no_frame_comes_twice(source):
    with robsim.Camera(source) as camera:
        camera.read()
        with pytest.raises(FrameTimeoutError, match=r"within 0.01 s: it can be tried again"):
            camera.read(0.01)
        delivered(camera, source, 1)
        assert camera.read().index == 1


def test_a_frame_that_is_held_does_not_change(source):
    with robsim.Camera(source) as camera:
        held = [camera.read()]
        for _ in range(12):
            delivered(camera, source, 3)
            held.append(camera.read())
        delivered(camera, source, 30)
        pixels = [frame.image for frame in held]
        assert all((image == frame.index).all() for image, frame in zip(pixels, held, strict=True))
        assert not any(image.flags.owndata or image.flags.writeable for image in pixels)


def test_its_memory_is_used_again(source):
    with robsim.Camera(source) as camera:
        places = {camera.read().image.ctypes.data}
        for _ in range(60):
            delivered(camera, source, 2)
            places.add(camera.read().image.ctypes.data)
    assert len(places) <= 5


def test_times_start_at_the_first_frame(source):
    before = time.monotonic()
    with robsim.Camera(source) as camera:
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
    with robsim.Camera(source) as camera:
        camera.read()
        done = threading.Event()

        def count():
            for _ in range(1000):  # each gives the interpreter back
                time.sleep(0)
            done.set()
            source.permits.release()

        with in_thread(count):
            camera.read(60)
        assert done.is_set()


def test_an_error_of_the_camera_is_that_of_the_reader():
    source = SteppedCamera([*numbered(1), UnpluggedError("the cable")])
    source.permits.release(2)
    with robsim.Camera(source) as camera:
        assert isinstance(read_on(camera)[1], UnpluggedError)
        with pytest.raises(UnpluggedError, match="the cable"):
            camera.read()


def test_any_other_exception_passes_as_it_is():
    source = SteppedCamera([*numbered(1), ZeroDivisionError("of theirs")])
    source.permits.release(2)
    with robsim.Camera(source) as camera:
        assert repr(read_on(camera)[1]) == "ZeroDivisionError('of theirs')"


def test_what_is_no_image_is_told():
    source = SteppedCamera([np.zeros((4, 4), np.uint8)])
    source.permits.release()
    with pytest.raises(CaptureError, match=r"read\(\) must be a uint8 RGB array"):
        robsim.Camera(source)


@pytest.mark.slow
@pytest.mark.long
@pytest.mark.skipif(
    sanitizers.ADDRESS or sanitizers.THREAD, reason="the sanitizers keep what was freed"
)
def test_a_long_stream_needs_no_more_memory():
    import resource

    source = EndlessCamera(numbered(3)[2], 100_000)
    with robsim.Camera(source) as camera:
        taken = 0
        sizes = []
        for frame in camera:
            taken += 1
            assert frame.image[0, 0, 0] == 2
            if taken % 100 == 0:
                sizes.append(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
        counts = camera.counts
    assert counts.grabbed == 100_000
    assert counts.delivered == taken == counts.grabbed - counts.dropped
    assert sizes[-1] - sizes[len(sizes) // 4] < 2000  # kB; a frame leaked each time: 230 000


class TestTheEnd:
    def test_the_thread_ends_with_close(self, source):
        before = grabber_threads()
        camera = robsim.Camera(source)
        assert grabber_threads() == before + 1
        camera.close()
        camera.close()
        assert grabber_threads() == before
        assert source.calls == ["open", "close"]

    def test_the_thread_ends_with_the_camera(self, source):
        before = grabber_threads()
        camera = robsim.Camera(source)
        gone = weakref.ref(camera)
        del camera
        gc.collect()
        assert gone() is None
        assert grabber_threads() == before
        assert source.calls == ["open", "close"]

    def test_the_thread_ends_if_opening_fails(self):
        before = grabber_threads()
        with pytest.raises(FrameTimeoutError, match=r"no frame within open_timeout = 0.05 s"):
            robsim.Camera(SteppedCamera([]), open_timeout=0.05)
        assert grabber_threads() == before

    def test_a_reader_that_waits_is_told_of_a_close(self, source):
        camera = robsim.Camera(source)
        camera.read()
        told = []

        def read():
            with pytest.raises(ValueError, match="the camera is closed"):
                camera.read(60)
            told.append(True)

        with in_thread(read):
            camera.close()
        assert told

    @pytest.mark.long
    def test_a_camera_that_hangs_is_left_behind(self):
        endless = EndlessCamera(numbered(1)[0])
        before = grabber_threads()
        camera = robsim.Camera(endless)
        endless.hangs.set()
        with contextlib.suppress(FrameTimeoutError):
            while True:
                camera.read(0.05)
        camera.close()
        endless.goes_on.set()
        while grabber_threads() > before:
            time.sleep(0.001)

    @pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
    @pytest.mark.skipif(
        sanitizers.ADDRESS or sanitizers.THREAD,
        reason="the sanitizers take no new threads in a process forked beside others",
    )
    def test_a_forked_process_is_told_that_the_camera_is_not_its_own(self, source):
        camera = robsim.Camera(source)
        child = os.fork()
        if child == 0:
            try:
                for use in (camera.read, lambda: camera.counts):
                    with pytest.raises(RuntimeError, match="opened in another process"):
                        use()
                camera.close()
                del camera
                own = SteppedCamera(numbered(3))
                own.permits.release()
                with robsim.Camera(own) as mine:
                    assert mine.read().index == 0
                os._exit(0)
            except BaseException as error:
                print(repr(error), file=sys.__stderr__, flush=True)
                os._exit(1)
        assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
        assert camera.read().index == 0
        camera.close()


def python(code):
    start = f"import sys; sys.path.insert(0, {os.path.dirname(__file__) + '/../support'!r})\n"
    done = subprocess.run(
        [sys.executable, "-c", start + textwrap.dedent(code)],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    return done.returncode, done.stdout, done.stderr


OPEN = """
import numpy, robsim, python_cameras
endless = python_cameras.EndlessCamera(numpy.zeros((24, 32, 3), numpy.uint8))
camera = robsim.Camera(endless)
camera.read()
"""


@pytest.mark.slow
@pytest.mark.sanitized
@pytest.mark.long
@pytest.mark.parametrize(
    "last",
    ["", "import sys; sys.exit(0)", "camera.self = camera", "few = [*zip(range(9), camera)]"],
)
def test_python_ends_without_a_word_though_a_camera_is_open(last):
    assert python(OPEN + last) == (0, "", "")


@pytest.mark.long
def test_ctrl_c_ends_the_wait_for_a_frame():
    code = """
    import signal, threading
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background ignores it
    source = python_cameras.SteppedCamera([numpy.zeros((24, 32, 3), numpy.uint8)])
    source.permits.release()
    camera = robsim.Camera(source)
    camera.read()
    import _thread
    threading.Timer(0.2, _thread.interrupt_main).start()
    try:
        camera.read(50)
    except KeyboardInterrupt:
        print("interrupted")
    """
    assert python(OPEN + textwrap.dedent(code)) == (0, "interrupted\n", "")


def test_a_camera_whose_end_was_read_can_go():
    with robsim.Camera(EndlessCamera(np.zeros((24, 32, 3), np.uint8), 3)) as camera:
        assert len(list(camera)) > 0
        with contextlib.suppress(EOFError):
            camera.read()
    kept = weakref.ref(camera)
    del camera
    gc.collect()
    assert kept() is None


def test_an_error_that_is_told_again_has_one_traceback():
    source = SteppedCamera([np.zeros((24, 32, 3), np.uint8), UnpluggedError("gone")])
    source.permits.release(2)
    lengths = []
    with robsim.Camera(source) as camera:
        read_on(camera)
        for _ in range(5):
            with pytest.raises(UnpluggedError) as told:
                camera.read()
            lengths.append(len(list(traceback.walk_tb(told.value.__traceback__))))
    assert len(set(lengths)) == 1


@pytest.mark.slow
@pytest.mark.sanitized
@pytest.mark.long
def test_a_run_that_was_stopped_while_it_waited_does_not_count_for_the_next():
    source = SteppedCamera([np.zeros((24, 32, 3), np.uint8)] * 2)
    source.permits.release()
    with robsim.Camera(source) as camera:
        experiment = robsim.Experiment(
            camera, send=lambda u: None, control=lambda step: (0, 0), frame_timeout=1
        )
        experiment.run(1)
        threading.Timer(0.15, experiment.stop).start()
        experiment.run(1)
        time.sleep(1)
        threading.Timer(0.15, source.permits.release).start()
        assert experiment.run(1).t.size == 2
