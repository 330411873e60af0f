"""A camera that OpenCV reads in a process of its own."""

from __future__ import annotations

import json
import socket
import subprocess
import sys
import time
from typing import Any

import numpy as np

from robsim.lab.cameras import errors as _errors
from robsim.lab.cameras._devices.opencv import OpenCvCamera
from robsim.lab.cameras._devices.worker import FAULT, HEAD
from robsim.lab.cameras.errors import CaptureError, FrameTimeoutError

_START = 10.0  # s, for the process and its OpenCV
_CODE = (
    "import json, sys; descriptor, path, options = json.loads(sys.argv[1]); sys.path[:] = path; "
    "from robsim.lab.cameras._devices.worker import main; main(descriptor, options)"
)
_KINDS = {
    kind.fault: kind
    for kind in vars(_errors).values()
    if isinstance(kind, type) and issubclass(kind, CaptureError)
}


def is_possible() -> bool:
    return sys.platform != "win32" and bool(sys.executable)


class OpenCvHere:
    """The same in this process, where there can be no other; its images are BGR."""

    def __init__(self, camera: OpenCvCamera) -> None:
        self._camera = camera

    def open(self) -> None:
        """Open it."""
        self._camera.check()
        self._camera.open()

    def close(self) -> None:
        self._camera.close()

    def read(self) -> tuple[Any, None, float, int, int]:
        """Return the next image, as the grabber wants it."""
        image, is_bgr, arrived = self._camera.read()
        if image is not None and not is_bgr:
            image = np.ascontiguousarray(image[:, :, ::-1])
        return image, None, arrived, 0, 0


class OpenCvProcess:
    """The camera in Python of what OpenCV opens, read in a process of its own.

    In this one, each frame would need the interpreter: while a callback keeps it, frames would wait
    in OpenCV, and come late, with the time of when they were read. The process ends with `close`
    and with its reader, and OpenCV can neither hang nor crash it. It does not open the camera here.
    """

    def __init__(self, camera: OpenCvCamera) -> None:
        self._camera = camera
        self.name = camera.name
        self._process: subprocess.Popen[bytes] | None = None
        self._frames: socket.socket | None = None

    def open(self) -> int:
        """Start the process; return the descriptor of the socket that its frames come from."""
        self.close()
        self._camera.check()
        self._frames, theirs = socket.socketpair()
        with theirs:
            told = json.dumps([theirs.fileno(), sys.path, self._camera.options])
            self._process = subprocess.Popen(
                [sys.executable, "-c", _CODE, told],
                pass_fds=[theirs.fileno()],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                start_new_session=True,  # Ctrl-C is for its reader
            )
        self._wait_until_open(self._frames, time.monotonic() + _START + self._camera.open_timeout)
        return self._frames.fileno()

    def _wait_until_open(self, frames: socket.socket, end: float) -> None:
        kind, _, _, length, _ = HEAD.unpack(self._receive(frames, HEAD.size, end))
        if kind == FAULT:
            fault, _, message = self._receive(frames, length, end).decode().partition("\n")
            raise _KINDS.get(fault, CaptureError)(message)

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
                raise CaptureError(f"{self.name}: the process that reads it has ended at its start")
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

    def read(self) -> Any:
        """Return nothing: the frames come from the socket."""
        return None
