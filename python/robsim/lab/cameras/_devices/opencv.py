"""Cameras opened by OpenCV: by number, and streams."""

from __future__ import annotations

import os
import sys
import time
from typing import Any
from urllib.parse import urlsplit

from robsim.base.text import one_line
from robsim.lab.cameras._devices.freshness import OLD, Freshness
from robsim.lab.cameras._devices.jpeg import decoded
from robsim.lab.cameras.errors import (
    CameraBusyError,
    FrameTimeoutError,
    NoBackEndError,
    NoCameraError,
    NoPermissionError,
    UnpluggedError,
    unreached,
)
from robsim.vision.imaging.video import load_opencv, quiet

OF_ADDRESSES = ("ffmpeg", "gstreamer")
OF_INDICES = ("v4l2", "msmf", "dshow", "avfoundation", "gstreamer")
_NUMBER = {
    "ffmpeg": "CAP_FFMPEG",
    "gstreamer": "CAP_GSTREAMER",
    "v4l2": "CAP_V4L2",
    "msmf": "CAP_MSMF",
    "dshow": "CAP_DSHOW",
    "avfoundation": "CAP_AVFOUNDATION",
}

# s: a stream with a shorter stall continues afterwards.
_STALL = 5.0


def back_end_of_system() -> str:
    return {"win32": "msmf", "darwin": "avfoundation"}.get(sys.platform, "v4l2")


def is_rtsp(source: int | str) -> bool:
    return isinstance(source, str) and urlsplit(source).scheme in ("rtsp", "rtsps")


def back_ends(cv2: Any) -> tuple[str, ...]:
    """List the supported back ends that this OpenCV build includes."""
    has = cv2.videoio_registry.hasBackend
    return tuple(name for name, number in _NUMBER.items() if has(getattr(cv2, number)))


class OpenCvCamera:
    """The camera of a number or address opened by OpenCV; its images are BGR.

    A camera by number receives requests of a size (width, height in px) and a rate (1/s). A stream
    opens within `open_timeout` (s). Old RTSP frames, by the camera's stamps, are skipped.
    NoBackEndError: OpenCV, or this back end of OpenCV, is missing.
    """

    def __init__(
        self,
        source: int | str,
        back_end: str,
        *,
        size: tuple[int, int] | None = None,
        fps: float | None = None,
        open_timeout: float = 5.0,
    ) -> None:
        #: The arguments for opening the camera in another process.
        self.options: dict[str, Any] = {
            **{"source": source, "back_end": back_end, "size": size, "fps": fps},
            "open_timeout": open_timeout,
        }
        self._source = source
        self._node = f"/dev/video{source}" if back_end == "v4l2" else None
        self.name = _without_login(source) if isinstance(source, str) else f"camera {source}"
        try:
            self._cv2 = load_opencv("reading this camera")
        except ImportError as error:
            raise NoBackEndError(str(error)) from error
        there = back_ends(self._cv2)
        if back_end not in there:
            raise NoBackEndError(
                f"the installed OpenCV has no back end {back_end!r}, only {', '.join(there)}: "
                "choose an available back end, or install another OpenCV"
            )
        self._back_end = getattr(self._cv2, _NUMBER[back_end])
        self._wanted = {"CAP_PROP_FPS": fps}
        if size is not None:
            self._wanted |= {"CAP_PROP_FRAME_WIDTH": size[0], "CAP_PROP_FRAME_HEIGHT": size[1]}
        self.open_timeout = open_timeout
        self._has_timeouts = back_end == "ffmpeg"
        self._capture: Any = None
        self._is_raw = False
        self._freshness = Freshness() if is_rtsp(source) else None
        self._n_passed = 0

    def check(self) -> None:
        """Raise errors that are detectable without opening the camera."""
        if self._node is not None:
            _check_node(self._node)

    def open(self) -> None:
        """Open the camera, once."""
        with quiet(self._cv2):
            self._capture = self._cv2.VideoCapture(self._source, self._back_end, self._parameters())
        if self._capture.isOpened():
            self._is_raw = isinstance(self._source, str) and self._takes_packets()
            return
        self.close()
        if isinstance(self._source, str):
            self._check_host(self._source)
            raise NoCameraError(
                f"{self.name} answers, but OpenCV cannot open a stream: check the path, the user "
                "and the password"
            )
        if self._node is not None:
            raise CameraBusyError(
                f"{self._node} exists but does not open: another program uses the camera (fuser "
                f"{self._node} names it), or {self._node} is not a camera (try the next number)"
            )
        raise NoCameraError(
            f"{self.name} does not open: check that the camera is plugged in and that no other "
            "program uses it"
        )

    def _parameters(self) -> list[int]:
        cv2 = self._cv2
        parameters: list[int] = []
        if isinstance(self._source, int):
            for name, value in self._wanted.items():
                if value is not None:
                    parameters += [getattr(cv2, name), round(value)]
        elif self._has_timeouts:
            parameters += [cv2.CAP_PROP_OPEN_TIMEOUT_MSEC, round(1000 * self.open_timeout)]
            parameters += [cv2.CAP_PROP_READ_TIMEOUT_MSEC, round(1000 * _STALL)]
            parameters += [cv2.CAP_PROP_N_THREADS, 1]  # more hold back a frame each
        return parameters

    def _takes_packets(self) -> bool:
        """Request the packets of MJPEG, because FFmpeg would fill up torn images."""
        code = int(self._capture.get(self._cv2.CAP_PROP_FOURCC))
        is_mjpeg = self._has_timeouts and code.to_bytes(4, "little") == b"MJPG"
        return is_mjpeg and bool(self._capture.set(self._cv2.CAP_PROP_FORMAT, -1))

    def _check_host(self, url: str) -> None:
        import socket  # not with robsim: it costs milliseconds

        parts = urlsplit(url)
        try:
            port = parts.port or {"rtsp": 554, "http": 80, "https": 443}.get(parts.scheme)
            if port is None or not parts.hostname:
                return
            socket.create_connection((parts.hostname, port), self.open_timeout).close()
        except (OSError, ValueError) as error:
            raise unreached(self.name, self.open_timeout, error) from error

    def read(self) -> tuple[Any, float | None, float, int, int] | None:
        """Return the next image in the form of `PythonCamera`; None if it was old."""
        begun = time.monotonic()
        with quiet(self._cv2):
            is_read = self._capture.grab()
            arrived = time.monotonic()
            age = self._age(arrived) if is_read else None
            if age is not None and age > OLD:
                self._n_passed += 1
                return None
            if is_read:
                is_read, pixels = self._capture.retrieve()
        if is_read:
            image = decoded(pixels.tobytes()) if self._is_raw else pixels
            n_passed = self._n_passed if image is not None else 0
            self._n_passed -= n_passed
            return image, None if age is None else arrived - age, arrived, n_passed, 0
        if time.monotonic() - begun > 0.9 * _STALL:
            raise FrameTimeoutError(f"{self.name} has sent nothing for {_STALL:g} s")
        raise UnpluggedError(f"{self.name} stopped delivering: was it switched off or unplugged?")

    def _age(self, arrived: float) -> float | None:
        if self._freshness is None:
            return None
        return self._freshness.age(self._capture.get(self._cv2.CAP_PROP_POS_MSEC) / 1000, arrived)

    def close(self) -> None:
        """Release the camera."""
        if self._capture is not None:
            self._capture.release()
        self._capture = None


def _check_node(node: str) -> None:
    if not os.path.exists(node):
        raise NoCameraError(
            f"there is no {node}: is the camera plugged in? `robsim cameras` lists all cameras"
        )
    if not os.access(node, os.R_OK | os.W_OK):
        raise NoPermissionError(no_permission(node))


def no_permission(node: str) -> str:
    return (
        f"no permission to read {node}: add yourself to its group (sudo usermod -aG video $USER) "
        "and log in again"
    )


def _without_login(url: str) -> str:
    parts = urlsplit(url)
    return one_line(parts._replace(netloc=parts.netloc.rpartition("@")[2]).geturl())
