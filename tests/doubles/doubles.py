"""Cameras that imitate real ones: the simulated lab as a camera on a FireWire bus.

What they are made of is compiled by the target ``robsim_doubles`` of CMake, into a folder that
``./run`` puts on the path.
"""

import os
import tempfile
import weakref
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path

from robsim.capture._devices.firewire import CODINGS
from robsim.live import SimulatedLab


@dataclass(frozen=True, kw_only=True)
class VirtualCamera:
    """A camera on a virtual FireWire bus: what it shows, and what it can.

    The frames of the lab are as wide as a multiple of 8 px, and of even height.
    """

    lab: SimulatedLab
    codings: tuple[str, ...] = CODINGS
    color_filter: str = "rggb"  # of raw8
    is_fast: bool = False  # S800 of IEEE 1394b; otherwise S400


class VirtualBus:
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

    def __getattr__(self, name):
        return getattr(self._server, name)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()


def _end(process, server, folder):
    if os.getpid() == process:  # not one that was forked from it
        server.close()
        folder.cleanup()


def with_bus_library():
    """Return the LD_PRELOAD of a process that can see virtual buses."""
    library = str(Path(import_module("_bus_server").__file__).with_name("virtual_bus.so"))
    loaded = os.environ.get("LD_PRELOAD", "").split()  # a sanitizer comes first
    return " ".join([*loaded, *([] if library in loaded else [library])])
