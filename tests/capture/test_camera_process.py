"""A separate process reads a camera: fresh frames, and nothing left behind."""

import contextlib
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

import robsim
from python_devices import PATIENT
from robsim.lab import FrameTimeoutError
from waiting import LONGER_AND_LONGER, keep_interpreter, wait_for

SUPPORT = Path(__file__).parents[1] / "support"

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
    while not server.released.wait(0.01):
        yield picture, len(picture)
with MjpegServer(endless) as server:
    print(server.url, flush=True)
    sys.stdin.read()
"""

READER = """
import sys, robsim
camera = robsim.Camera(sys.argv[1], back_end=sys.argv[2], open_timeout=300)
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


@pytest.fixture(params=["http", "ffmpeg"])
def options(request):
    if request.param == "ffmpeg":
        pytest.importorskip("cv2")
    return {"back_end": request.param, **PATIENT}


def worker_of(reader):
    """The process that reads a camera for a process."""
    for folder in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            is_ours = int((folder / "stat").read_text().rpartition(")")[2].split()[1]) == reader
            worker = b"robsim.lab.cameras._devices.worker"
            if is_ours and worker in (folder / "cmdline").read_bytes():
                return int(folder.name)
    raise AssertionError("no worker")


def has_ended(process):
    try:
        return (Path("/proc") / str(process) / "stat").read_text().rpartition(")")[2][1] == "Z"
    except OSError:
        return True


def test_frames_come_while_somebody_keeps_the_interpreter_and_the_process_ends(url, options):
    with robsim.Camera(url, **options) as camera:
        worker = worker_of(os.getpid())
        for seconds in LONGER_AND_LONGER:
            before = camera.counts.grabbed
            keep_interpreter(seconds)
            came = camera.counts.grabbed - before
            if came > 5:
                break
        assert came > 5
    wait_for(lambda: has_ended(worker))


@pytest.mark.slow
@pytest.mark.sanitized
@pytest.mark.parametrize("end", ["kill", "exit"])
def test_the_process_ends_with_its_reader(url, options, end):
    with child(READER, url, options["back_end"]) as reader:
        assert reader.stdout.readline() == "(64, 48)\n"
        worker = worker_of(reader.pid)
        reader.kill() if end == "kill" else reader.stdin.close()
    wait_for(lambda: has_ended(worker))


@pytest.mark.slow
@pytest.mark.sanitized
def test_a_process_that_dies_is_an_unplugged_camera(url, options):
    with robsim.Camera(url, reopen=True, **options) as camera:
        camera.read()
        os.kill(worker_of(os.getpid()), signal.SIGKILL)

        def is_reopened():
            with contextlib.suppress(FrameTimeoutError):
                camera.read(0.1)
            return camera.counts.reopened

        wait_for(is_reopened)
        camera.read()


INTERRUPTED = """
import signal, socket, sys, robsim
signal.signal(signal.SIGINT, signal.default_int_handler)
mute = socket.create_server(("127.0.0.1", 0))
try:
    robsim.Camera(f"http://127.0.0.1:{mute.getsockname()[1]}/", open_timeout=300)
except KeyboardInterrupt:
    print("interrupted", flush=True)
sys.stdin.read()
"""


def test_ctrl_c_while_a_camera_is_opened_ends_its_process():
    with child(INTERRUPTED) as reader:
        wait_for(lambda: has_worker(reader.pid))
        worker = worker_of(reader.pid)
        reader.send_signal(signal.SIGINT)
        assert reader.stdout.readline() == "interrupted\n"
        wait_for(lambda: has_ended(worker))
        reader.stdin.close()


def has_worker(reader):
    with contextlib.suppress(AssertionError):
        return bool(worker_of(reader))
    return False
