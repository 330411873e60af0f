"""`GigeServer`: the simulated lab as a GigE Vision camera."""

from __future__ import annotations

import weakref
from ipaddress import IPv4Address
from typing import Any, Self

from robsim._base.text import quoted
from robsim.capture._devices import gige
from robsim.live._lab import SimulatedLab

_LONGEST_SERIAL = 15  # characters, of a register of GigE Vision
_LARGEST_SIDE = 2048  # px, of Aravis' fake camera


class GigeServer:
    """The camera of a simulated lab as a GigE Vision camera, which any viewer can open.

    Each frame of the lab goes out once, in order, at the lab's rate, as RGB8, Bayer or Mono8,
    whichever the client chooses, or a part of it. A client can be another program, such as Aravis'
    viewer, or ``robsim.Camera(server.url)``. Native threads do the work.

    Parameters
    ----------
    lab : SimulatedLab
        The lab: its camera is taken as long as the server goes on. Its faults are seen by the
        client: a torn frame comes with packets missing, a stalled camera sends nothing, and one
        that is unplugged does not answer.
    address : str
        IPv4 address of an interface of this computer, where clients reach it; "127.0.0.1" = from
        this computer alone. An address has one camera, since the port of GigE Vision is 3956.
    serial : str
        Serial number that the camera tells, of 1 to 15 characters of ASCII.

    Attributes
    ----------
    address, serial : str
        As given.
    lab : SimulatedLab
        The lab.

    Raises
    ------
    CaptureError
        If it cannot be served: NoBackEndError without Aravis, CameraBusyError if another camera is
        served at that address.
    TypeError, ValueError
        If an argument has the wrong type or is out of range, or frames have more than 2048 px a
        side.

    Notes
    -----
    The camera is the fake one of Aravis. It sends at most 1000 frames/s, of exposure and gain only
    the brightness follows, and nobody must trust what else its registers say.

    Examples
    --------
    >>> with robsim.live.SimulatedLab() as lab, robsim.live.GigeServer(lab) as server:
    ...     with robsim.Camera(server.url) as camera:
    ...         frame = camera.read()
    """

    def __init__(
        self, lab: SimulatedLab, *, address: str = "127.0.0.1", serial: str = "ROBSIM-1"
    ) -> None:
        if not isinstance(lab, SimulatedLab):
            raise TypeError(f"lab must be a SimulatedLab, got {quoted(lab)}")
        self.lab, self.address, self.serial = lab, _address(address), _serial(serial)
        if max(lab.size) > _LARGEST_SIDE:
            raise ValueError(
                f"lab must have frames of at most {_LARGEST_SIDE} px a side to be served, got "
                f"{lab.size[0]} x {lab.size[1]} px"
            )
        self._server = gige.EXTENSION.load().GigeServer(
            lab._open_device(),
            address=self.address,
            serial=self.serial,
            size=lab.size,
            fps=1 / lab.dt,
        )
        self._end = weakref.finalize(self, self._server.close)

    @property
    def url(self) -> str:
        """What `robsim.Camera` opens."""
        return f"gige://{self.address}"

    @property
    def sent_frames(self) -> int:
        """Number of whole frames that went out to a client."""
        return int(self._server.sent)

    @property
    def failure(self) -> str | None:
        """Why it has ended by itself, such as that the lab is closed; None = it goes on."""
        return str(self._server.failure) or None

    def close(self) -> None:
        """End it, and give the camera of the lab back."""
        self._end()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<GigeServer {self.serial} at {self.url}>"


def _address(address: Any) -> str:
    if not isinstance(address, str):
        raise TypeError(f"address must be a str, got {quoted(address)}")
    try:
        return str(IPv4Address(address))
    except ValueError:
        raise ValueError(
            f"address must be an IPv4 address of this computer, got {quoted(address)}"
        ) from None


def _serial(serial: Any) -> str:
    if not isinstance(serial, str):
        raise TypeError(f"serial must be a str, got {quoted(serial)}")
    if not (1 <= len(serial) <= _LONGEST_SERIAL and serial.isascii() and serial.isprintable()):
        raise ValueError(
            f"serial must have 1 to {_LONGEST_SERIAL} characters of ASCII, got {quoted(serial)}"
        )
    return serial
