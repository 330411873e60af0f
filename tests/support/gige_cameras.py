"""GigE Vision cameras on loopback. An address has one camera: one test at a time has it."""

import contextlib
import fcntl
import os
import subprocess
import tempfile
from pathlib import Path

import numpy as np

import robsim
from doubles import GigeServer
from python_devices import PATIENT
from robsim import _core
from robsim.lab import CameraBusyError, NoCameraError, SimulatedLab, UdpMotors, UnpluggedError
from sent_pixels import from_rgb
from surroundings import needs_double, needs_extension
from waiting import wait_for

ADDRESS = "127.0.0.1"
URL = f"gige://{ADDRESS}"
FPS = 100
SCENARIO = robsim.Scenario(
    area=(1200, 900), resolution=(320, 240), headings=None, start=(400, 420, 0.4), seed=3
)
DRIVE = (8.0, 5.0)
BAYER = {"RG": "rggb", "GR": "grbg", "GB": "gbrg", "BG": "bggr"}


@contextlib.contextmanager
def alone():
    """Wait until no other test has a camera on loopback."""
    with Path(tempfile.gettempdir(), f"robsim-gige-{os.getuid()}.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield


@contextlib.contextmanager
def served(scenario=SCENARIO, *, fps=FPS, **options):
    """Serve a lab; the server is told, and its `lab`."""
    needs_double("gige")
    with SimulatedLab(scenario, fps=fps, **options) as lab, GigeServer(lab) as server:
        yield server


def opened(url=URL, **options):
    """Open a camera; on a busy machine client or server may be late, and it is lost again."""

    def attempt():
        try:
            return robsim.Camera(url, **PATIENT | options)
        except (NoCameraError, CameraBusyError, UnpluggedError):
            return None

    return wait_for(attempt)


def camera_of(server, query="", **options):
    """Return the camera that a server serves, as users open it."""
    return opened(server.url + query, area=server.lab.area, **options)


def driven(server, camera, count):
    """Return frames of a robot that drives a curve."""
    frames = []
    with UdpMotors(server.lab.address) as motors:
        while len(frames) < count:
            frames.append(camera.read(300))
            motors(DRIVE)
    return frames


def ticks_of(server, frames, sent_as=lambda image: image):
    """Return the tick that each frame shows, to the byte: each later than the one before."""
    truth, renderer = server.lab.truth, robsim.simulation.Renderer(server.lab._world.scene)
    ticks, tick = [], -1
    for frame in frames:
        arrived = frame.epoch + frame.t_arrival
        tick += 1
        while not np.array_equal(frame.image, sent_as(renderer.render(truth.pose[tick]))):
            tick += 1
            assert tick < len(truth), "this frame shows no later tick of the lab"
            assert truth.t[tick] <= arrived, "this frame shows nothing that the lab has seen"
        ticks.append(tick)
    return ticks


def through(pixel_format):
    """Return what becomes of an image on its way through a pixel format of GenICam."""
    if pixel_format == "RGB8":
        return lambda image: image
    name = f"bayer_{BAYER[pixel_format[5:7]]}" if pixel_format.startswith("Bayer") else "mono8"

    def converted(image):
        height, width = image.shape[:2]
        return _core.to_rgb(from_rgb(image, name), width, height, name)

    return converted


def measured(frame, scenario=SCENARIO):
    """Return the pose that vision sees."""
    layout = scenario._marker_layout
    blobs = robsim.find_blobs(frame, robsim.load_colors(), markers=layout)
    return robsim.locate(blobs, layout, plane_map=frame.plane_map).pose


@contextlib.contextmanager
def program(*command, until=None):
    """Run a program beside, until it has written a text; it is killed at the end."""
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.STDOUT}
    process = subprocess.Popen(command, text=True, bufsize=1, **pipes)
    try:
        if until is not None:
            for line in process.stdout:
                if until in line:
                    break
            else:
                raise AssertionError(f"{command} has ended without {until!r}")
        yield process
    finally:
        process.kill()
        process.stdin.close()
        process.stdout.close()
        process.wait()


def wait_for_camera():
    """Wait until a camera answers on loopback."""
    find = needs_extension("gige").find_cameras
    wait_for(lambda: any(one["address"] == ADDRESS for one in find(0.05)))
