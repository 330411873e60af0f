"""Which device a source stands for."""

from __future__ import annotations

import re
from dataclasses import dataclass
from os import PathLike
from typing import Any
from urllib.parse import urlsplit

from robsim._base.checks import check_choice, check_int, is_int
from robsim._base.text import one_line, quoted
from robsim._core import CaptureDevice, PlaneMap, PythonCamera, StreamedCamera
from robsim.capture._devices.opencv import (
    OF_ADDRESSES,
    OF_INDICES,
    OpenCvCamera,
    back_end_of_system,
)
from robsim.capture._devices.playback import Playback


@dataclass
class Source:
    """A device, and what is known of it before it is open."""

    name: str
    device: CaptureDevice
    dt: float | None = None
    area: tuple[int, int] | None = None
    plane_map: PlaneMap | None = None


def source_of(
    source: Any,
    *,
    back_end: str | None,
    size: tuple[int, int] | None,
    fps: float | None,
    open_timeout: float,
) -> Source:
    """Return the device of a source; it is not open yet."""
    dt = None if fps is None else 1 / fps
    if hasattr(source, "_open_device"):
        _refuse(back_end, "back_end", "an object of robsim")
        return Source(
            one_line(source),
            source._open_device(),
            dt=getattr(source, "dt", None) if dt is None else dt,
            area=getattr(source, "area", None),
            plane_map=getattr(source, "plane_map", None),
        )
    if is_int(source):
        index = check_int("source", source, minimum=0, maximum=99)
        chosen = _choice(back_end, OF_INDICES) or back_end_of_system()
        camera = OpenCvCamera(index, chosen, size=size, fps=fps)
        return Source(camera.name, _device(camera), dt=dt)
    if isinstance(source, str) and re.match(r"[a-z][a-z0-9+.-]+://", source):
        return _address(source, back_end, dt, open_timeout)
    if isinstance(source, (str, PathLike)):
        _refuse(back_end, "back_end", "a file or folder")
        playback = Playback(source, fps)
        return Source(playback.name, PythonCamera(playback), dt=playback.dt)
    raise TypeError(
        "source must be the number of a camera, an address, a file, a folder or a camera of "
        f"robsim, got {quoted(source)}"
    )


def _address(url: str, back_end: str | None, dt: float | None, open_timeout: float) -> Source:
    is_http = urlsplit(url).scheme == "http"
    chosen = _choice(back_end, ("http", *OF_ADDRESSES)) or ("http" if is_http else "ffmpeg")
    if chosen == "http":
        if not is_http:
            raise ValueError(f"back_end 'http' reads http:// alone, got {quoted(url)}")
        from robsim.capture._devices.http import HttpCamera  # what it needs costs milliseconds

        http = HttpCamera(url, open_timeout)
        return Source(http.name, PythonCamera(http), dt=dt)
    stream = OpenCvCamera(url, chosen, open_timeout=open_timeout)
    return Source(stream.name, _device(stream), dt=dt)


def _device(camera: OpenCvCamera) -> CaptureDevice:
    from robsim.capture._devices.opencv_process import OpenCvHere, OpenCvProcess, is_possible

    if is_possible():
        return StreamedCamera(OpenCvProcess(camera))
    return PythonCamera(OpenCvHere(camera), bgr=True)


def _choice(back_end: str | None, choices: tuple[str, ...]) -> str | None:
    return None if back_end is None else check_choice("back_end", back_end, choices)


def _refuse(value: object, name: str, source: str) -> None:
    if value is not None:
        raise ValueError(f"{name} must be None for {source}, got {quoted(value)}")
