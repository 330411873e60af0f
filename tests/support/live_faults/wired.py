"""Cameras on the virtual FireWire bus and of GigE Vision on loopback, and what goes wrong there."""

import os
from contextlib import contextmanager, nullcontext

import gige_cameras
import robsim
from needs import needs_extension
from robsim.live import GigeServer, SimulatedLab, VirtualBus
from waiting import wait_for

KINDS = ("firewire", "gige")
SIZE = (160, 120)  # px
FPS = {"firewire": 30, "gige": 50}
LONG = 300  # s


class ServedLab:
    """A simulated lab that a bus or a server shows: `url` opens it, in a process that sees it."""

    can = ()

    def __init__(self, lab):
        self.lab = lab
        self.area = lab.area
        self.frames = None
        self.environment = dict(os.environ)

    def go_wrong(self, how):
        """Let something happen now."""
        self.acts()[how]()


class OnFireWire(ServedLab):
    can = (
        *("stall", "unplug", "plugged in again"),
        *("bus reset", "bus loses power", "no channel", "no bandwidth"),
    )
    url = "firewire://"

    def __init__(self, lab):
        super().__init__(lab)
        self.bus = VirtualBus(lab)
        self.environment = self.bus.environment
        self.close = self.bus.close

    def acts(self):
        return {
            "stall": lambda: self.bus.stall(LONG),
            "unplug": self.bus.unplug,
            "plugged in again": self.replug,
            "bus reset": self.bus.reset,
            "bus loses power": lambda: self.bus.reset(power_fails=True),
            "no channel": lambda: self.replug(channels=True),
            "no bandwidth": lambda: self.replug(bandwidth=True),
        }

    def replug(self, **refused):
        self.bus.refuse(**refused)
        self.bus.unplug()
        self.bus.plug_in()


class OnGige(ServedLab):
    can = ("stall", "unplug", "plugged in again", "dead server", "server starts anew")

    def __init__(self, lab):
        super().__init__(lab)
        self.server = GigeServer(lab)
        self.url = self.server.url

    def acts(self):
        return {
            "stall": lambda: self.lab.stall(LONG),
            "unplug": self.lab.unplug,
            "plugged in again": self.replug,
            "dead server": self.close,
            "server starts anew": self.start_anew,
        }

    def replug(self):
        self.lab.unplug()
        self.lab.plug_in()

    def start_anew(self):
        self.close()
        self.server = GigeServer(self.lab)

    def close(self):
        self.server.close()


SERVED = {"firewire": OnFireWire, "gige": OnGige}


@contextmanager
def served(kind, rng):
    """Show a lab, in half of the cases one whose camera drops, repeats and tears frames."""
    scenario = robsim.Scenario(area=(600, 450), resolution=SIZE, seed=rng.randrange(1000))
    faults = robsim.live.CameraFaults()
    if rng.random() < 0.5:
        faults = robsim.live.CameraFaults(dropped=0.1, repeated=0.1, torn=0.1)
    turn = gige_cameras.alone() if kind == "gige" else nullcontext()
    with turn, SimulatedLab(scenario, fps=FPS[kind], faults=faults) as lab:
        made = SERVED[kind](lab)
        try:
            yield made
        finally:
            made.close()


@contextmanager
def opened(kind, rng):
    """Read such a camera in this process; on FireWire it was started with the virtual bus."""
    with served(kind, rng) as made:
        if kind == "firewire":
            os.environ["ROBSIM_VIRTUAL_BUS"] = made.environment["ROBSIM_VIRTUAL_BUS"]
            wait_for(needs_extension("firewire").cameras)
        options = {"frame_timeout": 0.3, "reopen": rng.random() < 0.5}
        try:
            with gige_cameras.opened(made.url, area=made.area, **options) as camera:
                made.frames = camera
                yield made
        finally:
            os.environ.pop("ROBSIM_VIRTUAL_BUS", None)


def firewire(rng):
    """Read a camera on FireWire in this process."""
    return opened("firewire", rng)


def gige(rng):
    """Read a camera of GigE Vision in this process."""
    return opened("gige", rng)


def with_bus():
    """Return the environment of a process that can see virtual buses; there is none yet."""
    with SimulatedLab() as lab, VirtualBus(lab) as bus:
        return {**os.environ, "LD_PRELOAD": bus.environment["LD_PRELOAD"]}
