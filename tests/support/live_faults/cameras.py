"""Cameras that go on until they are told what goes wrong."""

import itertools
import shutil
import tempfile
import threading
import time
from contextlib import contextmanager
from functools import cache
from pathlib import Path

import robsim
import sessions
from mjpeg_server import MjpegServer, jpeg

from . import wired
from .wired import LONG, Shown

SOFTWARE = ("lab", "http", "file", "generator")
#: What can go wrong with a camera of a kind.
CAN = {
    "lab": ("stall", "unplug"),
    "http": ("stall", "unplug", "torn", "size", "dead server"),
    "file": (),
    "generator": ("stall", "raises", "ends", "size", "order"),
    **wired.CAN,
}
FPS = 50
FILE_FRAMES = 45
PATIENCE = {"open_timeout": LONG}  # of a busy machine


def odd(image):
    """An image of another size."""
    return image[:48, :64].copy()


@contextmanager
def simulated_lab(rng):
    scenario = robsim.Scenario(area=(600, 600), resolution=(160, 160), seed=rng.randrange(1000))
    faults = robsim.lab.CameraFaults()
    if rng.random() < 0.4:
        faults = robsim.lab.CameraFaults(
            late=0.1, late_by=0.05, dropped=0.1, repeated=0.1, torn=0.1, drift=0.2
        )
    with (
        robsim.lab.SimulatedLab(scenario, fps=FPS, faults=faults) as lab,
        robsim.Camera(lab, **PATIENCE) as camera,
    ):
        yield Shown(camera, stall=lambda: lab.stall(LONG), unplug=lab.unplug)


@cache
def pictures():
    images, _ = sessions.driven()
    return [jpeg(image) for image in images], jpeg(odd(images[0]))


@contextmanager
def http_server(rng):
    whole, other = pictures()

    def parts():
        for picture in itertools.cycle(whole):
            time.sleep(1 / FPS)
            if made.order in ("unplug", "dead server"):
                return
            if made.order == "stall":
                server.released.wait(LONG)
                return
            if made.order == "torn":
                yield picture[: len(picture) // 2]
            else:
                yield other if made.order == "size" else picture

    made = Shown(**{"dead server": lambda: server._server.shutdown()})
    with MjpegServer(parts) as server:
        made.url = server.url
        with robsim.Camera(server.url, fps=FPS, **PATIENCE) as made.frames:
            yield made


@contextmanager
def played_file(rng):
    folder = tempfile.mkdtemp()  # a TemporaryDirectory would go with a forked child
    try:
        whole, _ = pictures()
        for k in range(FILE_FRAMES):
            Path(folder, f"{k:03d}.jpg").write_bytes(whole[k % len(whole)])
        with robsim.Camera(folder, fps=FPS, **PATIENCE) as camera:
            yield Shown(camera)
    finally:
        shutil.rmtree(folder)


@contextmanager
def generator(rng):
    released = threading.Event()
    made = Shown()

    def generate():
        images, _ = sessions.driven()
        epoch = time.monotonic()
        for k in itertools.count():
            time.sleep(1 / FPS)
            t = time.monotonic() - epoch
            image = images[k % len(images)]
            if made.order == "raises":
                raise ZeroDivisionError("of the fault")
            if made.order == "ends":
                return
            if made.order == "stall":
                released.wait(LONG)
            if made.order == "size":
                image = odd(image)
            if made.order == "order":
                t = 0.0
            yield robsim.Frame(image, t=t, t_arrival=t, epoch=epoch, index=k)

    made.frames = generate()
    try:
        yield made
    finally:
        released.set()


def camera_of(kind, rng):
    """Return the context of a camera of a kind."""
    software = dict(
        zip(SOFTWARE, (simulated_lab, http_server, played_file, generator), strict=True)
    )
    return software[kind](rng) if kind in software else wired.opened(kind, rng)
