"""The device of a source."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from types import MappingProxyType, ModuleType
from typing import Any

from robsim._core import CaptureDevice, PlaneMap, PythonCamera, StreamedCamera
from robsim.base.checks import check_choice, check_int, is_int
from robsim.base.text import one_line, quoted
from robsim.base.warn import warn_user
from robsim.lab.cameras._devices import firewire, gige
from robsim.lab.cameras._devices.called import CalledCamera
from robsim.lab.cameras._devices.opencv import (
    OF_ADDRESSES,
    OF_INDICES,
    OpenCvCamera,
    back_end_of_system,
    is_rtsp,
)
from robsim.lab.cameras._devices.playback import Playback
from robsim.lab.cameras.wishes import Wishes

_SAME_RATE = 0.01  # of the requested rate
_BY_OPENCV = ("http", "https", "rtsp", "rtsps", "rtmp", "rtp", "srt", "tcp", "udp")
_FFMPEG_OPTIONS = "OPENCV_FFMPEG_CAPTURE_OPTIONS"
# Without sound: its packets alone would end the probe.
_SMALL_PROBE = "rtsp_transport;tcp|allowed_media_types;video|probesize;32"


@dataclass
class Source:
    """A device, and its known properties before the first frame."""

    name: str
    device: CaptureDevice
    dt: float | None = None
    area: tuple[int, int] | None = None
    plane_map: PlaneMap | None = None
    headings: int | None = None  # number of headings of a simulated robot
    region: tuple[int, int, int, int] | None = None
    coding: str | None = None
    advice: str = ""  # for torn frames
    # Otherwise times of exposure are estimates from arrivals, or have an unknown offset.
    knows_exposure: Callable[[], bool] = lambda: False


def source_of(source: Any, wishes: Wishes, *, open_timeout: float) -> Source:
    """Return the device of a source; a bus device is already open, to know its output."""
    for bus in (firewire, gige):
        if isinstance(source, str) and source.startswith(f"{bus.SCHEME}://"):
            return _on_bus(bus, source, wishes)
    wishes.refuse(_kind_of(source), "region", "coding", "features")
    dt, back_end = wishes.dt, wishes.back_end
    methods = [getattr(source, name, None) for name in ("open", "read", "close")]
    if hasattr(source, "_open_device") or all(map(callable, methods)):
        wishes.refuse("an object", "back_end")
        device, knows_exposure = _object(source)
        return Source(
            one_line(source),
            device,
            dt=getattr(source, "dt", None) if dt is None else dt,
            area=getattr(source, "area", None),
            plane_map=getattr(source, "plane_map", None),
            headings=getattr(source, "_headings", None),
            knows_exposure=knows_exposure,
        )
    if is_int(source):
        index = check_int("source", source, minimum=0, maximum=99)
        chosen = _choice(back_end, OF_INDICES) or back_end_of_system()
        camera = OpenCvCamera(index, chosen, size=wishes.size, fps=wishes.fps)
        camera.check()
        return Source(camera.name, _device(camera), dt=dt)
    if isinstance(source, str) and re.match(r"[a-z][a-z0-9+.-]+://", source):
        return _address(source, back_end, dt, open_timeout)
    if isinstance(source, (str, PathLike)):
        _refuse_almost_an_address(source)
        wishes.refuse("a file or folder", "back_end")
        playback = Playback(source, wishes.fps)
        return Source(
            playback.name, PythonCamera(playback), dt=playback.dt, headings=playback.headings
        )
    raise TypeError(
        "source must be the number of a camera, an address, a file, a folder or an object with "
        f"open, read and close, got {quoted(source)}"
    )


def _object(source: Any) -> tuple[CaptureDevice, Callable[[], bool]]:
    """Return the device of an object, and whether it knows the time of its last exposure."""
    if hasattr(source, "_open_device"):
        device = source._open_device()
        if isinstance(device, PythonCamera):
            raise TypeError("an object with read must have bgr, True or False, not _open_device")
        return device, lambda: True
    camera = CalledCamera(source)
    bgr = bool(getattr(source, "bgr", False))
    return PythonCamera(camera, bgr=bgr), lambda: camera.knows_exposure


def _refuse_almost_an_address(source: str | PathLike[str]) -> None:
    meant = meant_address(source) if isinstance(source, str) else None
    if meant is not None and not Path(source).exists():
        raise FileNotFoundError(
            f"there is no file or folder {one_line(source)}; did you mean {meant!r}?"
        )


def meant_address(text: str) -> str | None:
    """Return the address meant by an invalid one, such as firewire:0; None = no suggestion."""
    if node := re.fullmatch(r"/dev/(video|fw)\d{1,2}", text):
        return f"{firewire.SCHEME}://" if node[1] == "fw" else text.removeprefix("/dev/video")
    if re.fullmatch(r"\d{1,3}(\.\d{1,3}){3}", text):
        return f"{gige.SCHEME}://{text}"
    bus = re.fullmatch(r"(fire[ -]?wire|gige|https?|rtsp)(?:[:/ ]+(.*))?", text.strip(), re.I)
    if bus is None:
        return None
    scheme, rest = re.sub(r"[ -]", "", bus[1].lower()), bus[2] or ""
    if not rest and scheme != firewire.SCHEME:
        rest = "ADDRESS"
    return f"{scheme}://{rest}"


def _kind_of(source: Any) -> str:
    if isinstance(source, str) and re.match(r"[a-z][a-z0-9+.-]+://", source):
        return "an address such as this"
    return "a camera by number" if is_int(source) else "a file, a folder or an object"


def _on_bus(bus: ModuleType, url: str, wishes: Wishes) -> Source:
    wishes.refuse(bus.NAME, "back_end")
    if wishes.coding is not None:
        check_choice("coding", wishes.coding, bus.CODINGS)
    device = bus.new_camera(url, wishes)
    device.open()
    sent = bus.sent_by(device)
    if sent.fps and wishes.fps is not None and abs(sent.fps / wishes.fps - 1) > _SAME_RATE:
        warn_user(
            f"{sent.name} sends {sent.fps:.4g} frames/s; {wishes.fps:g} were requested: its mode, "
            "its exposure or the bus allows no closer rate; a smaller size or region, a shorter "
            "exposure or coding 'raw8' may"
        )
    return Source(
        sent.name,
        device,
        dt=1 / sent.fps if sent.fps else wishes.dt,
        region=sent.region,
        coding=sent.coding,
        advice=sent.advice,
        knows_exposure=lambda: bus is firewire,
    )


def _address(url: str, back_end: str | None, dt: float | None, open_timeout: float) -> Source:
    scheme = url.partition("://")[0]
    if scheme not in _BY_OPENCV:
        known = ", ".join((firewire.SCHEME, gige.SCHEME, *_BY_OPENCV))
        raise ValueError(
            f"source must be an address with a scheme of {known}, got {quoted(scheme)}"
        )
    is_http = scheme == "http"
    chosen = _choice(back_end, ("http", *OF_ADDRESSES)) or ("http" if is_http else "ffmpeg")
    if chosen == "http":
        if not is_http:
            raise ValueError(f"back_end 'http' only reads http://, got {quoted(url)}")
        from robsim.lab.cameras._devices.http import HttpCamera  # slow to load

        http = HttpCamera(url, open_timeout)
        return Source(http.name, _device(http), dt=dt)
    stream = OpenCvCamera(url, chosen, open_timeout=open_timeout)
    environment = _small_probe() if is_rtsp(url) and chosen == "ffmpeg" else {}
    return Source(stream.name, _device(stream, environment), dt=dt)


def _small_probe() -> dict[str, str]:
    """Return options that stop FFmpeg from reading a second of frames before the first one."""
    if _FFMPEG_OPTIONS in os.environ:
        warn_user(
            f"{_FFMPEG_OPTIONS} is set, so robsim does not choose {_SMALL_PROBE!r}: without "
            "these options the first frame comes up to a second later"
        )
        return {}
    return {_FFMPEG_OPTIONS: _SMALL_PROBE}


def _device(camera: Any, environment: Mapping[str, str] = MappingProxyType({})) -> CaptureDevice:
    from robsim.lab.cameras._devices.process import CameraHere, CameraProcess, is_possible

    if is_possible():
        return StreamedCamera(CameraProcess(camera, environment))
    return PythonCamera(CameraHere(camera), bgr=True)


def _choice(back_end: str | None, choices: tuple[str, ...]) -> str | None:
    return None if back_end is None else check_choice("back_end", back_end, choices)
