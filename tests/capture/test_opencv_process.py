"""What OpenCV reads, it reads in a process of its own: fresh frames, and nothing left behind."""

import contextlib
import ctypes
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

import robsim
from robsim.capture import FrameTimeoutError

pytest.importorskip("cv2")

SUPPORT = Path(__file__).parents[1] / "support"
SOON = 30  # s

pytestmark = [
    pytest.mark.long,
    pytest.mark.threads,
    pytest.mark.skipif(not Path("/proc/self/cmdline").exists(), reason="needs /proc"),
]

# Its own process: it must go on while this one's interpreter is kept.
SERVER = f"""
import sys
import numpy as np
sys.path.insert(0, {str(SUPPORT)!r})
from mjpeg_server import MjpegServer, jpeg
picture = jpeg(np.full((48, 64, 3), 99, np.uint8))
def endless():
    while not server.released.wait(0.02):
        yield picture, len(picture)
with MjpegServer(endless) as server:
    print(server.url, flush=True)
    sys.stdin.read()
"""

READER = """
import sys, robsim
camera = robsim.Camera(sys.argv[1], back_end="ffmpeg")
print(camera.size, flush=True)
sys.stdin.read()
"""


def child(code, *arguments):
    pipe = subprocess.PIPE
    return subprocess.Popen(
        [sys.executable, "-c", code, *arguments], stdin=pipe, stdout=pipe, text=True
    )


@pytest.fixture(scope="module")
def url():
    with child(SERVER) as server:
        yield server.stdout.readline().strip()
        server.stdin.close()


def workers(reader):
    """The processes that read cameras by OpenCV for a process."""
    found = []
    for folder in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            is_ours = int((folder / "stat").read_text().rpartition(")")[2].split()[1]) == reader
            if is_ours and b"robsim.capture._devices.worker" in (folder / "cmdline").read_bytes():
                found.append(int(folder.name))
    return found


def has_ended(process):
    try:
        return (Path("/proc") / str(process) / "stat").read_text().rpartition(")")[2][1] == "Z"
    except OSError:
        return True


def waits(condition):
    end = time.monotonic() + SOON
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.02)


def test_frames_do_not_wait_for_who_keeps_the_interpreter(url):
    usleep = ctypes.PyDLL(None).usleep
    with robsim.Camera(url, back_end="ffmpeg") as camera:
        before = camera.read(SOON)
        usleep(600_000)  # 30 frames
        after = camera.read(SOON)
    assert after.index - before.index > 8
    assert after.t_arrival - before.t_arrival > 0.2


@pytest.mark.slow
@pytest.mark.sanitized
@pytest.mark.parametrize("end", ["kill", "exit"])
def test_the_process_ends_with_its_reader(url, end):
    with child(READER, url) as reader:
        assert reader.stdout.readline() == "(64, 48)\n"
        (worker,) = workers(reader.pid)
        if end == "kill":
            reader.kill()
        else:
            reader.stdin.close()
    waits(lambda: has_ended(worker))


def test_the_process_ends_with_the_camera(url):
    with robsim.Camera(url, back_end="ffmpeg"):
        (worker,) = workers(os.getpid())
    waits(lambda: has_ended(worker))


@pytest.mark.slow
@pytest.mark.sanitized
def test_a_process_that_dies_is_an_unplugged_camera(url):
    with robsim.Camera(url, back_end="ffmpeg", reopen=True) as camera:
        camera.read(SOON)
        (worker,) = workers(os.getpid())
        os.kill(worker, signal.SIGKILL)

        def is_reopened():
            with contextlib.suppress(FrameTimeoutError):
                camera.read(0.1)
            return camera.counts.reopened > 0

        waits(is_reopened)
        camera.read(SOON)
