"""GigE Vision: a camera that is busy, silent, torn or gone, and comes again."""

import os
import signal
import subprocess
import sys
import time

import pytest

import robsim
from gige_cameras import (
    SCENARIO,
    camera_of,
    driven,
    measured,
    program,
    served,
    ticks_of,
    wait_for_camera,
)
from robsim.capture import (
    CameraBusyError,
    CaptureError,
    FrameTimeoutError,
    NoBackEndError,
    UnpluggedError,
)
from robsim.live import CameraFaults, GigeServer, SimulatedLab

SERVING = """
import sys, time
import robsim
from gige_cameras import served
with served() as server:
    print("serving", flush=True)
    time.sleep(100)
"""
READING = """
import sys, time
import robsim
with robsim.Camera("gige://127.0.0.1") as camera:
    camera.read()
    print("reading", flush=True)
    time.sleep(100)
"""


@pytest.fixture
def python(monkeypatch):
    """Starts a program in Python that finds what the tests do."""
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(filter(None, sys.path)))
    return lambda text, until: program(sys.executable, "-c", text, until=until)


def read_on(camera):
    while True:
        camera.read()


def test_without_aravis_it_is_said_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "robsim._gige", None)
    with pytest.raises(NoBackEndError, match="this robsim was built without Aravis"):
        robsim.Camera("gige://127.0.0.1")
    with SimulatedLab(SCENARIO) as lab, pytest.raises(NoBackEndError, match="libaravis-dev"):
        GigeServer(lab)
    assert any("libaravis-dev" in line for line in robsim.capture.find_cameras().missing)


@pytest.mark.parametrize(
    ("url", "message"),
    [
        ("gige://", "must be gige:// and the camera"),
        ("gige://127.0.0.1/path", "must be gige:// and the camera"),
        ("gige://127.0.0.1?packet_size=big", "may choose format and packet_size"),
        ("gige://127.0.0.1?packet_size=65536", "may choose format and packet_size"),
        ("gige://127.0.0.1?colour=red", "may choose format and packet_size"),
    ],
)
def test_addresses_that_are_none(url, message):
    with pytest.raises(ValueError, match=message):
        robsim.Camera(url)


def test_a_back_end_that_does_not_read_them():
    with pytest.raises(ValueError, match="back_end must be None for GigE Vision"):
        robsim.Camera("gige://127.0.0.1", back_end="ffmpeg")


@pytest.mark.slow
@pytest.mark.sanitized
def test_an_address_serves_one_camera():
    with served() as server:
        with SimulatedLab(SCENARIO) as lab, pytest.raises(CameraBusyError, match="3956 of"):
            GigeServer(lab)
        with camera_of(server) as camera:  # the first one goes on
            camera.read()


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        ({"address": "203.0.113.7"}, CaptureError, "an interface of this computer"),
        ({"address": "localhost"}, ValueError, "address must be an IPv4 address"),
        ({"address": 3}, TypeError, "address must be a str, got 3"),
        ({"serial": ""}, ValueError, "serial must have 1 to 15 characters"),
        ({"serial": "x" * 16}, ValueError, "serial must have 1 to 15 characters"),
        ({"serial": 7}, TypeError, "serial must be a str, got 7"),
    ],
)
def test_what_cannot_be_served(arguments, error, message):
    with SimulatedLab(SCENARIO) as lab, pytest.raises(error, match=message):
        GigeServer(lab, **arguments)


def test_frames_that_are_too_large_or_no_lab():
    large = SCENARIO.replace(resolution=(2049, 100))
    with SimulatedLab(large) as lab, pytest.raises(ValueError, match="at most 2048 px a side"):
        GigeServer(lab)
    with pytest.raises(TypeError, match="lab must be a SimulatedLab, got 0"):
        GigeServer(0)


@pytest.mark.slow
@pytest.mark.sanitized
def test_silence_is_a_timeout_and_frames_come_again():
    with served() as server, camera_of(server, frame_timeout=0.2) as camera:
        driven(server, camera, 3)
        server.lab.stall(1.0)
        with pytest.raises(FrameTimeoutError):
            read_on(camera)
        camera.read(timeout=5)
        ticks_of(server, driven(server, camera, 10))
        assert camera.counts.timeouts >= 1


@pytest.mark.slow
@pytest.mark.sanitized
def test_torn_frames_are_counted_and_never_seen():
    faults = CameraFaults(torn=0.3)
    with served(faults=faults) as server:
        with camera_of(server, query="?packet_size=1500") as camera:
            frames = driven(server, camera, 60)
            torn = camera.counts.torn
        ticks_of(server, frames)
    assert 5 <= torn <= 60


@pytest.mark.slow
def test_dropped_frames_are_missing():
    with served(faults=CameraFaults(dropped=0.3)) as server:
        with camera_of(server) as camera:
            frames = driven(server, camera, 60)
        ticks = ticks_of(server, frames)
    assert ticks[-1] - ticks[0] > 65


@pytest.mark.slow
@pytest.mark.sanitized
def test_an_unplugged_camera_times_out_first_and_is_lost_then():
    with served() as server, camera_of(server, frame_timeout=0.5) as camera:
        driven(server, camera, 3)
        server.lab.unplug()
        kinds = []
        end = time.monotonic() + 20
        while UnpluggedError not in kinds and time.monotonic() < end:
            try:
                camera.read()
            except CaptureError as error:
                kinds.append(type(error))
        assert kinds[0] is FrameTimeoutError
        assert kinds[-1] is UnpluggedError


@pytest.mark.slow
@pytest.mark.sanitized
def test_it_is_opened_again_when_it_is_plugged_in():
    with served() as server, camera_of(server, frame_timeout=0.3, reopen=True) as camera:
        driven(server, camera, 3)
        server.lab.unplug()
        with pytest.raises(FrameTimeoutError):
            read_on(camera)
        server.lab.plug_in()
        end = time.monotonic() + 30
        while camera.counts.reopened == 0:
            assert time.monotonic() < end
            time.sleep(0.05)
        camera.read(timeout=5)
        frames = driven(server, camera, 10)
        ticks = ticks_of(server, frames)
        pose = server.lab.truth.pose[ticks[-1]]
    assert abs(measured(frames[-1])[:2] - pose[:2]).max() < 1


@pytest.mark.slow
def test_a_server_that_is_killed_is_unplugged(python):
    with python(SERVING, until="serving") as process:
        camera = robsim.Camera("gige://127.0.0.1", area=SCENARIO.area, frame_timeout=0.5)
        with camera:
            camera.read()
            os.kill(process.pid, signal.SIGKILL)
            with pytest.raises(FrameTimeoutError):
                read_on(camera)
            deadline = time.monotonic() + 20
            error = None
            while not isinstance(error, UnpluggedError):
                assert time.monotonic() < deadline
                try:
                    camera.read()
                except CaptureError as raised:
                    error = raised
            assert "answers no more" in str(error)
    with served() as server, camera_of(server) as camera:  # the port is free
        ticks_of(server, driven(server, camera, 3))


@pytest.mark.slow
def test_a_second_reader_is_told_that_it_is_busy():
    with served() as server, camera_of(server) as first:
        with pytest.raises(CameraBusyError, match="another program has the camera"):
            camera_of(server, open_timeout=20)
        ticks_of(server, driven(server, first, 5))


@pytest.mark.slow
def test_the_camera_lets_go_of_a_reader_that_was_killed(python):
    with served() as server:
        with python(READING, until="reading") as process:
            os.kill(process.pid, signal.SIGKILL)
        end = time.monotonic() + 30
        while True:
            try:
                camera = camera_of(server, open_timeout=20)
                break
            except CameraBusyError:
                assert time.monotonic() < end
        with camera:
            ticks_of(server, driven(server, camera, 5))


@pytest.mark.slow
@pytest.mark.sanitized
def test_the_end_of_the_lab_is_the_end_of_its_server():
    with SimulatedLab(SCENARIO, fps=100) as lab, GigeServer(lab) as server:
        wait_for_camera()
        assert server.failure is None
        lab.close()
        end = time.monotonic() + 10
        while server.failure is None:
            assert time.monotonic() < end
            time.sleep(0.01)


@pytest.mark.slow
@pytest.mark.sanitized
def test_a_program_ends_with_an_open_camera_and_server(python):
    text = """
import robsim
from gige_cameras import SCENARIO
lab = robsim.live.SimulatedLab(SCENARIO, fps=100)
server = robsim.live.GigeServer(lab)
camera = robsim.Camera(server.url)
camera.read()
"""
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", text], capture_output=True, text=True, timeout=60
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
