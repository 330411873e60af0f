"""`VirtualBus`: the simulated lab as a camera on a FireWire bus that is not there."""

from __future__ import annotations

import os
import tempfile
import weakref
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

from robsim import _core
from robsim._base.checks import check_bool, check_choice, check_float, check_int
from robsim._base.text import quoted
from robsim.capture._devices.firewire import CODINGS
from robsim.capture._errors import NoBackEndError
from robsim.live._lab import SimulatedLab

FILTERS = ("rggb", "gbrg", "grbg", "bggr")
_MOST = 4  # cameras
_VARIABLE = "ROBSIM_VIRTUAL_BUS"  # as bus_memory.hpp has it
_LIBRARY = Path("preloaded", "virtual_bus.so")


@dataclass(frozen=True, kw_only=True)
class VirtualCamera:
    """A camera on a virtual FireWire bus: what it shows, and what it can.

    Parameters
    ----------
    lab : SimulatedLab
        What it shows; its frames are as wide as a multiple of 8 px, and of even height.
    codings : sequence of str
        How it can code pixels: of ``"yuv422"``, ``"rgb8"``, ``"yuv444"``, ``"raw8"``, ``"yuv411"``,
        ``"mono8"`` and ``"mono16"``.
    color_filter : str
        The Bayer filter of ``"raw8"``: ``"rggb"``, ``"gbrg"``, ``"grbg"`` or ``"bggr"``.
    is_fast : bool
        Whether it has the speed S800 of IEEE 1394b; otherwise S400.

    Raises
    ------
    TypeError, ValueError
        If an argument has the wrong type, or is none of these.
    """

    lab: SimulatedLab
    codings: Sequence[str] = CODINGS
    color_filter: str = "rggb"
    is_fast: bool = False

    def __post_init__(self) -> None:
        if not isinstance(self.lab, SimulatedLab):
            raise TypeError(f"lab must be a SimulatedLab, got {quoted(self.lab)}")
        if not isinstance(self.codings, (list, tuple)) or not self.codings:
            raise TypeError(f"codings must be a sequence of names, got {quoted(self.codings)}")
        for coding in self.codings:
            check_choice("a coding", coding, CODINGS)
        check_choice("color_filter", self.color_filter, FILTERS)
        check_bool("is_fast", self.is_fast)


class VirtualBus:
    """A FireWire bus with cameras that show simulated labs, for rehearsals without hardware.

    Programs that are started with `environment` see it as the kernel's own, libdc1394 and all that
    builds on it included: ``robsim.Camera("firewire://")``, OpenCV, other viewers. No rights are
    needed. Linux only.

    Parameters
    ----------
    cameras : SimulatedLab, VirtualCamera, or sequence of these
        Its camera, or its one to four cameras. The camera of each lab is taken as long as the bus
        goes on; while it is unplugged, so is the camera on the bus.
    card_is_fast : bool
        Whether the computer's card has the speed S800 of IEEE 1394b; otherwise S400.

    Attributes
    ----------
    cameras : tuple of VirtualCamera
        Its cameras; the first one is number 0.

    Raises
    ------
    NoBackEndError
        If robsim was built without libdc1394, or this is not Linux.
    TypeError, ValueError
        If a camera is none, there are too many, or its frames have a size that FireWire cannot
        send.

    Notes
    -----
    It imitates the interface of Linux (``linux/firewire-cdev.h``) and the registers of IIDC 1.31
    below the unmodified libdc1394, by a library that is loaded before the C library. A frame
    arrives as late as on a real bus: its packets take up to an interval. What it has not: damaged
    packets, and all that makers of cameras do in their own ways.

    Examples
    --------
    >>> with robsim.live.SimulatedLab() as lab, robsim.live.VirtualBus(lab) as bus:
    ...     subprocess.run(["robsim", "live", "--camera", "firewire://"], env=bus.environment)
    """

    def __init__(
        self,
        cameras: SimulatedLab | VirtualCamera | Sequence[SimulatedLab | VirtualCamera],
        *,
        card_is_fast: bool = True,
    ) -> None:
        check_bool("card_is_fast", card_is_fast)
        if isinstance(cameras, (SimulatedLab, VirtualCamera)):
            cameras = (cameras,)
        if not isinstance(cameras, (list, tuple)):
            raise TypeError(
                "cameras must be a SimulatedLab, a VirtualCamera or a sequence of these, got "
                f"{quoted(cameras)}"
            )
        if not 1 <= len(cameras) <= _MOST:
            raise ValueError(f"cameras must be 1 to {_MOST}, got {len(cameras)}")
        self.cameras = tuple(
            VirtualCamera(lab=one) if isinstance(one, SimulatedLab) else one for one in cameras
        )
        for one in self.cameras:
            if not isinstance(one, VirtualCamera):
                raise TypeError(f"cameras must be SimulatedLab or VirtualCamera, got {quoted(one)}")
        self._library = _library()
        self._folder = tempfile.TemporaryDirectory(prefix="robsim-bus-")
        self._path = str(Path(self._folder.name, "bus"))
        try:
            self._server = _core.BusServer(
                self._path,
                [
                    (one.lab.size, 1 / one.lab.dt, list(one.codings), one.color_filter, one.is_fast)
                    for one in self.cameras
                ],
                [one.lab._open_device() for one in self.cameras],
                card_is_fast,
            )
        except BaseException:
            self._folder.cleanup()
            raise
        self._end = weakref.finalize(self, _end, self._server, self._folder)

    @property
    def environment(self) -> dict[str, str]:
        """dict: the environment of a process that is to see the bus: this one's, and two more."""
        before = os.environ.get("LD_PRELOAD", "").split()
        libraries = [*before, *([] if self._library in before else [self._library])]
        return {**os.environ, "LD_PRELOAD": " ".join(libraries), _VARIABLE: self._path}

    def guid(self, camera: int = 0) -> str:
        """Return the 16 digits of a camera's number: ``firewire://`` and these open it."""
        return self._server.guid_of(self._number(camera))

    def is_sending(self, camera: int = 0) -> bool:
        """Return whether somebody has told a camera to send, and not to stop."""
        return self._server.is_sending(self._number(camera))

    def lost_frames(self, camera: int = 0) -> int:
        """Return how many of a camera's frames were lost, since a reader was late."""
        return self._server.lost_frames(self._number(camera))

    def unplug(self, camera: int = 0) -> None:
        """Unplug a camera; any thread may call this."""
        self._server.unplug(self._number(camera))

    def plug_in(self, camera: int = 0) -> None:
        """Plug a camera in again, with its settings as after power-on."""
        self._server.plug_in(self._number(camera))

    def stall(self, seconds: float, camera: int = 0) -> None:
        """Let a camera be silent for a while (s)."""
        seconds = check_float("seconds", seconds, "s", minimum=0, maximum=3600)
        self._server.stall(self._number(camera), seconds)

    def deny(self, camera: int = 0, *, denied: bool = True) -> None:
        """Take the permission to read a camera away, or give it."""
        self._server.deny(self._number(camera), check_bool("denied", denied))

    def shorten(self, camera: int = 0, *, shortened: bool = True) -> None:
        """Let a camera say of regions that frames have fewer packets than they need, or no more."""
        self._server.shorten(self._number(camera), check_bool("shortened", shortened))

    def reset(self, *, power_fails: bool = False) -> None:
        """Reset the bus; where the power fails for a moment, cameras forget that they send."""
        self._server.reset(check_bool("power_fails", power_fails))

    def refuse(self, *, channels: bool = False, bandwidth: bool = False) -> None:
        """Say from now on that no channel, or no bandwidth, is left for others."""
        self._server.refuse(check_bool("channels", channels), check_bool("bandwidth", bandwidth))

    def _number(self, camera: Any) -> int:
        return check_int("camera", camera, minimum=0, maximum=len(self.cameras) - 1)

    def close(self) -> None:
        """End the bus, and give the cameras of the labs back."""
        self._end()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<VirtualBus with {len(self.cameras)} cameras>"


def _end(server: Any, folder: tempfile.TemporaryDirectory[str]) -> None:
    server.close()
    folder.cleanup()


def _library() -> str:
    """Return the path of the library that shows the bus."""
    path = Path(_core.__file__).parent / _LIBRARY
    if not path.exists():
        raise NoBackEndError(
            "a virtual FireWire bus needs Linux, and a robsim that was built with libdc1394: sudo "
            "apt-get install libdc1394-dev pkg-config, then pip install robsim from its source"
        )
    return str(path)
