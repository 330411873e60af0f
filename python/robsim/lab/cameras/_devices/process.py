"""A camera in Python, in a separate process."""

from __future__ import annotations

import json
import os
import socket
import subprocess
import sys
import time
from collections.abc import Mapping
from contextlib import suppress
from typing import Any

from robsim.lab.cameras._devices.worker import FAULT, HEAD
from robsim.lab.cameras.errors import CaptureError, FrameTimeoutError, error_of

_START = 10.0  # s, for the process and its OpenCV
_ROOM = 1 << 20  # bytes, a frame of 640 x 480: both ends would wait for each other in its pieces
_CODE = """
import json, sys
sys.path[:], *arguments = json.loads(sys.argv[1])
from robsim.lab.cameras._devices.worker import main
main(*arguments)
"""


def is_possible() -> bool:
    return sys.platform != "win32" and bool(sys.executable)


class CameraHere:
    """The same in this process, where there can be no other."""

    def __init__(self, camera: Any) -> None:
        self._camera = camera

    def open(self) -> None:
        """Open a new one of the same kind."""
        self._camera = type(self._camera)(**self._camera.options)
        self._camera.open()

    def close(self) -> None:
        self._camera.close()

    def read(self) -> Any:
        """Return the next image, as the grabber wants it."""
        return self._camera.read()


class CameraProcess:
    """A Python camera that a separate process reads.

    In this process, each frame would need the interpreter: while a callback keeps the interpreter,
    frames would arrive late, with the time of reading. The process ends with `close` and with its
    reader, and OpenCV can neither hang nor crash the reader. The camera is not opened here.

    Parameters
    ----------
    camera : object
        Like `CameraHere`, with `name`, `open_timeout` and `options`, the arguments of another.
    environment : dict of str to str
        Additional variables of the process.
    """

    def __init__(self, camera: Any, environment: Mapping[str, str]) -> None:
        self._camera = camera
        self._environment = environment
        self.name = camera.name
        self._process: subprocess.Popen[bytes] | None = None
        self._frames: socket.socket | None = None
        self._is_interrupted = False

    def open(self) -> int:
        """Start the process; return the descriptor of the socket for its frames."""
        self.close()
        self._frames, theirs = socket.socketpair()
        theirs.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, _ROOM)
        kind = type(self._camera)
        with theirs:
            told = [sys.path, theirs.fileno(), kind.__module__, kind.__name__, self._camera.options]
            self._process = subprocess.Popen(
                [sys.executable, "-c", _CODE, json.dumps(told)],
                env={**os.environ, **self._environment},
                pass_fds=[theirs.fileno()],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                start_new_session=True,  # Ctrl-C is for its reader
            )
        if self._is_interrupted:
            raise CaptureError(f"{self.name} is closed")
        self._wait_until_open(self._frames, time.monotonic() + _START + self._camera.open_timeout)
        return self._frames.fileno()

    def _wait_until_open(self, frames: socket.socket, end: float) -> None:
        kind, _, _, length, *_ = HEAD.unpack(self._receive(frames, HEAD.size, end))
        if kind == FAULT:
            fault, _, message = self._receive(frames, length, end).decode().partition("\n")
            raise error_of(fault, message)

    def _receive(self, frames: socket.socket, size: int, end: float) -> bytes:
        data = b""
        while len(data) < size:
            frames.settimeout(max(end - time.monotonic(), 1e-3))
            try:
                received = frames.recv(size - len(data))
            except TimeoutError:
                raise FrameTimeoutError(
                    f"{self.name} was not opened within {_START + self._camera.open_timeout:g} s"
                ) from None
            if not received:
                raise CaptureError(f"{self.name}: the process of the camera ended during its start")
            data += received
        return data

    def close(self) -> None:
        """End the process."""
        if self._process is not None:
            self._process.kill()
            self._process.wait()
        if self._frames is not None:
            self._frames.close()
        self._process = self._frames = None

    def interrupt(self) -> None:
        """End the wait for the camera, from another thread; it cannot be opened again."""
        self._is_interrupted = True
        if (frames := self._frames) is not None:
            with suppress(OSError):
                frames.shutdown(socket.SHUT_RDWR)

    def read(self) -> Any:
        """Return nothing: the frames arrive at the socket."""
        return None
