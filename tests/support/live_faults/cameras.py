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

SOFTWARE = ("lab", "http", "file", "generator")
KINDS = (*SOFTWARE, *wired.KINDS)
FPS = 50
DT = 1 / FPS  # s
FILE_FRAMES = 45
LONG = 300  # s
PATIENCE = {"open_timeout": LONG}  # of a busy machine
OTHER_SIZE = (64, 48)


class Frames:
    """The frames of a camera: ``frames`` for an Experiment, and what can go wrong with them."""

    can = ()

    def __init__(self):
        self.frames = None
        self.order = None

    def go_wrong(self, how):
        """Let it happen with the next frame."""
        self.order = how


class LabFrames(Frames):
    can = ("stall", "unplug")

    def __init__(self, lab):
        super().__init__()
        self.lab = lab

    def go_wrong(self, how):
        self.lab.stall(LONG) if how == "stall" else self.lab.unplug()


@contextmanager
def simulated_lab(rng):
    scenario = robsim.Scenario(area=(600, 600), resolution=(160, 160), seed=rng.randrange(1000))
    faults = robsim.live.CameraFaults()
    if rng.random() < 0.4:
        faults = robsim.live.CameraFaults(
            late=0.1, late_by=0.05, dropped=0.1, repeated=0.1, torn=0.1, drift=0.2
        )
    with robsim.live.SimulatedLab(scenario, fps=FPS, faults=faults) as lab:
        made = LabFrames(lab)
        with robsim.Camera(lab, **PATIENCE) as camera:
            made.frames = camera
            yield made


@cache
def pictures():
    images, _ = sessions.driven()
    return [jpeg(image) for image in images], jpeg(images[0][: OTHER_SIZE[1], : OTHER_SIZE[0]])


class ServedFrames(Frames):
    can = ("stall", "unplug", "torn", "size", "dead server")
    area = environment = None

    def parts(self):
        whole, other = pictures()
        for picture in itertools.cycle(whole):
            time.sleep(DT)
            if self.order in ("unplug", "dead server"):
                return
            if self.order == "torn":
                yield picture[: len(picture) // 2]
            elif self.order == "size":
                yield other
            elif self.order == "stall":
                self.server.released.wait(LONG)
                return
            else:
                yield picture

    def go_wrong(self, how):
        super().go_wrong(how)
        if how == "dead server":
            self.server._server.shutdown()


@contextmanager
def http_server(rng):
    made = ServedFrames()
    made.server = MjpegServer(made.parts)
    made.url = made.server.url
    with made.server, robsim.Camera(made.server.url, fps=FPS, **PATIENCE) as camera:
        made.frames = camera
        yield made


@contextmanager
def played_file(rng):
    made = Frames()
    images, _ = sessions.driven()
    folder = tempfile.mkdtemp()  # a TemporaryDirectory would go with a forked child
    try:
        for k in range(FILE_FRAMES):
            Path(folder, f"{k:03d}.jpg").write_bytes(pictures()[0][k % len(images)])
        with robsim.Camera(folder, fps=FPS, **PATIENCE) as camera:
            made.frames = camera
            yield made
    finally:
        shutil.rmtree(folder)


class GeneratedFrames(Frames):
    can = ("stall", "raises", "ends", "size", "order")

    def __init__(self):
        super().__init__()
        self.released = threading.Event()

    def generate(self):
        images, _ = sessions.driven()
        epoch = time.monotonic()
        for k in itertools.count():
            time.sleep(DT)
            t = time.monotonic() - epoch
            image = images[k % len(images)]
            if self.order == "raises":
                raise ZeroDivisionError("of the fault")
            if self.order == "ends":
                return
            if self.order == "stall":
                self.released.wait(LONG)
            if self.order == "size":
                image = image[: OTHER_SIZE[1], : OTHER_SIZE[0]].copy()
            if self.order == "order":
                t = 0.0
            yield robsim.Frame(image, t=t, t_arrival=t, epoch=epoch, index=k)


@contextmanager
def generator(rng):
    made = GeneratedFrames()
    made.frames = made.generate()
    try:
        yield made
    finally:
        made.released.set()


MADE = {
    "lab": simulated_lab,
    "http": http_server,
    "file": played_file,
    "generator": generator,
    "firewire": wired.firewire,
    "gige": wired.gige,
}
CAN = {
    "lab": LabFrames.can,
    "http": ServedFrames.can,
    "file": (),
    "generator": GeneratedFrames.can,
    **{kind: made.can for kind, made in wired.SERVED.items()},
}
