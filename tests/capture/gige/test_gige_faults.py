"""GigE Vision: a camera that is torn, killed or gone, and comes again."""

import os
import subprocess
import sys

import pytest

from gige_cameras import (
    SCENARIO,
    camera_of,
    driven,
    measured,
    opened,
    program,
    served,
    ticks_of,
    wait_for_camera,
)
from robsim.lab import CameraFaults, FrameTimeoutError, UnpluggedError
from waiting import wait_for

SERVING = """
import sys
from gige_cameras import served
with served() as server:
    print("serving", flush=True)
    sys.stdin.read()
"""
READING = """
import sys
from gige_cameras import opened
with opened() as camera:
    print("reading", flush=True)
    sys.stdin.read()
"""
OPEN_AT_THE_END = """
import robsim
from doubles import GigeServer
from gige_cameras import SCENARIO, opened
lab = robsim.lab.SimulatedLab(SCENARIO, fps=100)
server = GigeServer(lab)
camera = opened()
"""


@pytest.fixture
def _finds_support(monkeypatch):
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(filter(None, sys.path)))


def is_lost(camera):
    """Whether a camera is unplugged; a time-out may come first."""
    try:
        camera.read(0.5)
    except UnpluggedError:
        return True
    except FrameTimeoutError:
        pass
    return False


@pytest.mark.slow
@pytest.mark.sanitized
def test_torn_and_dropped_frames_are_never_seen():
    with served(faults=CameraFaults(torn=0.3, dropped=0.2)) as server:
        with camera_of(server, query="?packet_size=1500") as camera:
            frames = driven(server, camera, 60)
            torn = camera.counts.torn
        ticks = ticks_of(server, frames)
    assert torn > 0
    assert ticks[-1] - ticks[0] > 60 + torn - 10


@pytest.mark.slow
@pytest.mark.sanitized
@pytest.mark.parametrize("reopen", [False, True])
def test_an_unplugged_camera_is_lost_or_opened_again_when_it_is_plugged_in(server, reopen):
    with camera_of(server, frame_timeout=0.3, reopen=reopen) as camera:
        driven(server, camera, 3)
        server.lab.unplug()
        if not reopen:
            wait_for(lambda: is_lost(camera))
            return
        wait_for(lambda: camera.counts.timeouts)
        server.lab.plug_in()
        wait_for(lambda: camera.counts.reopened)
        frames = driven(server, camera, 10)
        pose = server.lab.truth.pose[ticks_of(server, frames)[-1]]
    assert abs(measured(frames[-1])[:2] - pose[:2]).max() < 1


@pytest.mark.slow
@pytest.mark.usefixtures("_finds_support")
def test_a_server_that_is_killed_is_unplugged():
    with (
        program(sys.executable, "-c", SERVING, until="serving") as process,
        opened(area=SCENARIO.area) as camera,
    ):
        process.kill()
        wait_for(lambda: is_lost(camera))
        with pytest.raises(UnpluggedError, match="answers no more"):
            camera.read()
    with served():  # the port is free
        wait_for_camera()


@pytest.mark.slow
@pytest.mark.usefixtures("_finds_support")
def test_the_camera_lets_go_of_a_reader_that_was_killed(server):
    with program(sys.executable, "-c", READING, until="reading") as process:
        process.kill()
    with camera_of(server) as camera:  # busy at first
        ticks_of(server, driven(server, camera, 5))


@pytest.mark.slow
@pytest.mark.sanitized
def test_the_end_of_the_lab_is_the_end_of_its_server(server):
    wait_for_camera()
    assert not server.failure
    server.lab.close()
    wait_for(lambda: server.failure)


@pytest.mark.slow
@pytest.mark.sanitized
@pytest.mark.usefixtures("_finds_support")
def test_a_program_ends_with_an_open_camera_and_server():
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", OPEN_AT_THE_END],
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
