"""Cameras on FireWire: IIDC, by libdc1394."""

from __future__ import annotations

import re
from typing import Any

from robsim._core import pixel_formats
from robsim.base.text import quoted
from robsim.lab.cameras._devices.extensions import Extension, Sent
from robsim.lab.cameras.wishes import Wishes

SCHEME, NAME = "firewire", "FireWire"
#: The best one first.
CODINGS = tuple(
    dict.fromkeys(
        coding for _, coding, worth, _ in sorted(pixel_formats(), key=lambda row: -row[2]) if worth
    )
)

EXTENSION = Extension(
    module="robsim._firewire",
    cameras=NAME,
    library="libdc1394",
    debian="libdc1394-25",
    fedora="libdc1394",
    development="libdc1394-dev",
)


def new_camera(url: str, wishes: Wishes) -> Any:
    """Return the closed device of an address such as ``"firewire://"``.

    ValueError: the address is invalid. NoBackEndError: the extension is missing.
    """
    choice = url.removeprefix(f"{SCHEME}://").lower()
    if not re.fullmatch(r"|[0-9]{1,2}|[0-9a-f]{16}", choice):
        raise ValueError(
            "a FireWire address must be firewire:// (the first camera), firewire://1 (the second "
            "camera, and so on), or firewire:// with the camera's 16-digit number, got "
            f"{quoted(url)}"
        )
    return EXTENSION.load().FireWireCamera(choice, coding=wishes.coding or "", **wishes.given)


def sent_by(device: Any) -> Sent:
    """Return the output of an open device."""
    video = device.video
    return Sent(
        name=f"the FireWire camera {device.guid}",
        fps=video["fps"],
        region=video["region"],
        coding=video["coding"],
    )
