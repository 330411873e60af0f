"""Cameras on the virtual FireWire bus and of GigE Vision on loopback, and what goes wrong there."""

import os
from contextlib import contextmanager, nullcontext

import gige_cameras
import robsim
from doubles import GigeServer, VirtualBus, with_bus_library
from robsim.lab import SimulatedLab
from surroundings import needs_extension
from waiting import wait_for

CAN = {
    "firewire": (
        *("stall", "unplug", "plugged in again"),
        *("bus reset", "bus loses power", "no channel", "no bandwidth"),
    ),
    "gige": ("stall", "unplug", "plugged in again", "dead server", "server starts anew"),
}
SIZE = (160, 120)  # px
FPS = {"firewire": 30, "gige": 50}
LONG = 300  # s


class Shown:
    """What an Experiment takes, its `frames`, and the acts by which that goes wrong."""

    url = area = environment = None

    def __init__(self, frames=None, **acts):
        self.frames, self.acts, self.order = frames, acts, None

    def go_wrong(self, how):
        """Let it happen now, or with the next frame."""
        self.order = how
        self.acts.get(how, lambda: None)()


@contextmanager
def on_firewire(lab):
    with VirtualBus(lab) as bus:

        def replug(**refused):
            bus.refuse(**refused)
            bus.unplug()
            bus.plug_in()

        made = Shown(stall=lambda: bus.stall(LONG), unplug=bus.unplug)
        made.acts |= {
            "plugged in again": replug,
            "bus reset": bus.reset,
            "bus loses power": lambda: bus.reset(power_fails=True),
            "no channel": lambda: replug(channels=True),
            "no bandwidth": lambda: replug(bandwidth=True),
        }
        made.url, made.environment = "firewire://", bus.environment
        yield made


@contextmanager
def on_gige(lab):
    servers = [GigeServer(lab)]

    def replug():
        lab.unplug()
        lab.plug_in()

    def start_anew():
        servers[-1].close()
        servers.append(GigeServer(lab))

    made = Shown(stall=lambda: lab.stall(LONG), unplug=lab.unplug)
    made.acts |= {
        "plugged in again": replug,
        "dead server": servers[0].close,
        "server starts anew": start_anew,
    }
    made.url = servers[0].url
    try:
        yield made
    finally:
        servers[-1].close()


@contextmanager
def served(kind, rng):
    """Show a lab, in half of the cases one whose camera drops, repeats and tears frames."""
    scenario = robsim.Scenario(area=(600, 450), resolution=SIZE, seed=rng.randrange(1000))
    faults = robsim.lab.CameraFaults()
    if rng.random() < 0.5:
        faults = robsim.lab.CameraFaults(dropped=0.1, repeated=0.1, torn=0.1)
    turn, show = (gige_cameras.alone(), on_gige) if kind == "gige" else (nullcontext(), on_firewire)
    with turn, SimulatedLab(scenario, fps=FPS[kind], faults=faults) as lab, show(lab) as made:
        made.area = lab.area
        yield made


@contextmanager
def opened(kind, rng):
    """Read such a camera in this process; on FireWire it was started with the virtual bus."""
    with served(kind, rng) as made:
        if kind == "firewire":
            os.environ |= made.environment
            wait_for(needs_extension("firewire").cameras)
        options = {"frame_timeout": 0.3, "reopen": rng.random() < 0.5}
        try:
            with gige_cameras.opened(made.url, area=made.area, **options) as made.frames:
                yield made
        finally:
            os.environ.pop("ROBSIM_VIRTUAL_BUS", None)


def with_bus():
    """Return the environment of a process that can see virtual buses; there is none yet."""
    return os.environ | {"LD_PRELOAD": with_bus_library()}
