"""Cameras on FireWire: IIDC, by libdc1394."""

from __future__ import annotations

import importlib
import re
from typing import Any

from robsim._base.text import quoted
from robsim.capture._errors import NoBackEndError
from robsim.capture._features import CameraFeatures

SCHEME = "firewire"
CODINGS = ("yuv422", "rgb8", "yuv444", "raw8", "yuv411", "mono8", "mono16")

_INSTALL = (
    "FireWire needs libdc1394: sudo apt-get install libdc1394-25 (Debian, Ubuntu), dnf install "
    "libdc1394 (Fedora)"
)
_REBUILD = (
    "this robsim was built without libdc1394: sudo apt-get install libdc1394-dev pkg-config, then "
    "pip install --force-reinstall --no-binary robsim robsim"
)


def extension() -> Any:
    """Return the extension that reads FireWire.

    Raises
    ------
    NoBackEndError
        If it, or what it needs, is not there; the message says what to install.
    """
    try:
        return importlib.import_module("robsim._firewire")
    except ModuleNotFoundError as error:
        raise NoBackEndError(_REBUILD) from error
    except ImportError as error:  # a library of the system is missing
        raise NoBackEndError(f"{_INSTALL} ({error})") from error


def new_camera(
    url: str,
    *,
    size: tuple[int, int] | None,
    region: tuple[int, int, int, int] | None,
    fps: float | None,
    coding: str | None,
    features: CameraFeatures | None,
) -> Any:
    """Return the device of an address such as ``"firewire://"``; it is not open yet.

    Raises
    ------
    ValueError
        If the address is none.
    NoBackEndError
        If FireWire cannot be read here.
    """
    choice = url.removeprefix(f"{SCHEME}://").lower()
    if not re.fullmatch(r"|\d{1,2}|[0-9a-f]{16}", choice):
        raise ValueError(
            "an address of FireWire must be firewire:// (the first camera), firewire://1 (the "
            "second one, and so on), or firewire:// and the 16 digits of the camera's number, got "
            f"{quoted(url)}"
        )
    wishes = (features or CameraFeatures())._wishes()
    return extension().FireWireCamera(
        choice, size=size, region=region, fps=fps, coding=coding or "", features=wishes
    )
