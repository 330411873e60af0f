"""GigE Vision cameras, by Aravis."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import parse_qsl, urlsplit

from robsim._core import pixel_formats
from robsim.base.text import quoted
from robsim.lab.cameras._devices.extensions import Extension, Sent
from robsim.lab.cameras.wishes import Wishes

if TYPE_CHECKING:
    from robsim._gige import GigeCamera

SCHEME, NAME = "gige", "GigE Vision"
#: The best one first.
CODINGS = tuple(dict.fromkeys(coding for _, coding, _, genicam in pixel_formats() if genicam))

EXTENSION = Extension(
    module="robsim._gige",
    cameras=NAME,
    library="Aravis 0.8",
    debian="libaravis-0.8-0",
    fedora="aravis",
    # Debian's aravis-0.8.pc requires libusb-1.0, which its package does not install.
    development="libaravis-dev libusb-1.0-0-dev",
)

#: Bytes: with a smaller socket buffer, packets of large frames are lost.
ENOUGH_RECEIVE_BUFFER = 4 << 20


def new_camera(url: str, wishes: Wishes) -> GigeCamera:
    """Return the closed device of an address such as ``"gige://192.168.1.20"``.

    Rare options follow a question mark: ``format``, a pixel format of GenICam instead of the
    coding, and ``packet_size`` (bytes).

    ValueError: the address is invalid. NoBackEndError: the extension is missing.
    """
    parts = urlsplit(url)
    if not parts.netloc or parts.path.strip("/"):
        raise ValueError(
            "a GigE Vision address must be gige:// and the camera's IP address, serial number "
            f"or name, got {quoted(url)}"
        )
    chosen = dict(parse_qsl(parts.query, keep_blank_values=True))
    pixel_format = chosen.pop("format", wishes.coding or "")
    packet_size = chosen.pop("packet_size", "0")
    if chosen or not packet_size.isdecimal() or int(packet_size) > 65535:
        raise ValueError(
            "the options of a GigE Vision address are format and packet_size (at most 65535 "
            "bytes), as in gige://192.168.1.20?format=BayerRG8&packet_size=8000, got "
            f"{quoted(url)}"
        )
    camera: GigeCamera = EXTENSION.load().GigeCamera(
        parts.netloc, format=pixel_format, packet_size=int(packet_size), **wishes.given
    )
    return camera


def sent_by(device: GigeCamera) -> Sent:
    """Return the output of an open device."""
    info = device.info
    assert info is not None  # the device is open
    return Sent(
        name=f"the GigE camera {info['serial'] or info['address']}",
        fps=info["fps"],
        region=info["region"],
        coding=info["coding"],
        advice=info["advice"],
    )


def largest_receive_buffer() -> int | None:
    """Return the largest receive buffer of a socket in bytes; None = unknown."""
    try:
        return int(Path("/proc/sys/net/core/rmem_max").read_text())
    except (OSError, ValueError):  # Linux only
        return None
