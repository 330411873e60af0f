"""Cameras that imitate real ones: the simulated lab on a FireWire bus, and as a GigE camera.

What they are made of is compiled by the target ``robsim_doubles`` of CMake, into a folder that
``./run`` puts on the path.
"""

import os
import tempfile
import weakref
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path

from robsim.lab import SimulatedLab
from robsim.lab.cameras._devices.firewire import CODINGS


@dataclass(frozen=True, kw_only=True)
class VirtualCamera:
    """A camera on a virtual FireWire bus: what it shows, and what it can.

    The frames of the lab are as wide as a multiple of 8 px, and of even height.
    """

    lab: SimulatedLab
    codings: tuple[str, ...] = CODINGS
    color_filter: str = "rggb"  # of raw8
    is_fast: bool = False  # S800 of IEEE 1394b; otherwise S400


class _Double:
    """What its server can is its own, too; it ends with `close`, or with nobody who has it."""

    _server = None

    def __getattr__(self, name):
        return getattr(self._server, name)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()


class VirtualBus(_Double):
    """A FireWire bus whose cameras, up to four, show simulated labs.

    Programs that are started with `environment` see it as the kernel's own, libdc1394 and all that
    builds on it included. The camera of each lab is taken as long as the bus goes on; while it is
    unplugged, so is the camera on the bus. What can be asked of the bus and go wrong with it, such
    as `unplug` and `reset`, stands in ``bus_server/module.cpp``.

    It imitates the interface of Linux (``linux/firewire-cdev.h``) and the registers of IIDC 1.31
    below the unmodified libdc1394, by a library that is loaded before the C library. A frame
    arrives as late as on a real bus: its packets take up to an interval. What it has not: damaged
    packets, and all that makers of cameras do in their own ways.
    """

    def __init__(self, *cameras, card_is_fast=True):
        extension = import_module("_bus_server")
        cameras = [
            VirtualCamera(lab=one) if isinstance(one, SimulatedLab) else one for one in cameras
        ]
        folder = tempfile.TemporaryDirectory(prefix="robsim-bus-")
        path = str(Path(folder.name, "bus"))
        self._server = extension.BusServer(
            path,
            [
                (one.lab.size, 1 / one.lab.dt, one.codings, one.color_filter, one.is_fast)
                for one in cameras
            ],
            [one.lab._open_device() for one in cameras],
            card_is_fast,
        )
        self._path = path
        self.close = weakref.finalize(self, _end, os.getpid(), self._server, folder)

    @property
    def environment(self):
        """The environment of a process that is to see the bus."""
        return os.environ | {"LD_PRELOAD": with_bus_library(), "ROBSIM_VIRTUAL_BUS": self._path}


class GigeServer(_Double):
    """The camera of a lab as a GigE Vision camera at 127.0.0.1.

    Each frame of the lab goes out once, in order, at the lab's rate, as RGB8, Bayer or Mono8,
    whichever the client chooses, or a part of it. The lab's faults are seen by the client: a torn
    frame comes with packets missing, a stalled camera sends nothing, and one that is unplugged does
    not answer. Its `failure` says why it has ended by itself.

    The camera is the fake one of Aravis. It sends at most 1000 frames/s of at most 2048 px a side,
    of exposure and gain only the brightness follows, and nobody must trust what else its registers
    say.
    """

    serial = "ROBSIM-1"
    url = "gige://127.0.0.1"

    def __init__(self, lab):
        self.lab = lab
        server = import_module("_gige_server").GigeServer
        self._server = server(lab._open_device(), self.serial, lab.size, 1 / lab.dt)
        self.close = weakref.finalize(self, _end, os.getpid(), self._server)


def _end(process, server, folder=None):
    if os.getpid() != process:  # it was forked from that one
        return
    server.close()
    if folder is not None:
        folder.cleanup()


def with_bus_library():
    """Return the LD_PRELOAD of a process that can see virtual buses."""
    library = str(Path(import_module("_bus_server").__file__).with_name("virtual_bus.so"))
    loaded = os.environ.get("LD_PRELOAD", "").split()  # a sanitizer comes first
    return " ".join([*loaded, *([] if library in loaded else [library])])
