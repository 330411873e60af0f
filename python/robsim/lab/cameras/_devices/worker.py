"""The process that reads a camera by OpenCV, and sends its frames to the one that opened it."""

from __future__ import annotations

import os
import select
import socket
import struct
import sys
import threading
import time
from typing import Any

from robsim.lab.cameras._devices.opencv import OpenCvCamera
from robsim.lab.cameras.errors import CaptureError, FrameTimeoutError

#: What stands before the pixels: kind, width, height, length of what follows, when it arrived
#: (time.monotonic(), s). As `PixelStream` reads it.
HEAD = struct.Struct("=IIIId")
OPENED, RGB, BGR, TORN, FAULT = range(5)

_BETWEEN_LOOKS = 0.5  # s, at the process that reads the frames


def main(descriptor: int, options: dict[str, Any]) -> None:
    """Send frames until the other process closes the socket, or ends."""
    frames = socket.socket(fileno=descriptor)
    threading.Thread(target=_end_with, args=(frames, os.getppid()), daemon=True).start()
    try:
        camera = OpenCvCamera(**options)
        camera.open()
        _send(frames, OPENED)
        while True:
            try:
                _send_next(frames, camera)
            except FrameTimeoutError as error:
                _send_fault(frames, error.fault, str(error))
    except CaptureError as error:
        _send_fault(frames, error.fault, str(error))
    except Exception as error:
        _send_fault(frames, "failed", f"{type(error).__name__}: {error}")


def _end_with(frames: socket.socket, parent: int) -> None:
    """End this process with the one that reads, even while OpenCV waits for ever."""
    while os.getppid() == parent:
        ready, _, _ = select.select([frames], [], [], _BETWEEN_LOOKS)
        if ready:  # nothing is ever sent here but the end
            break
    os._exit(0)


def _send_next(frames: socket.socket, camera: OpenCvCamera) -> None:
    image, is_bgr, arrived = camera.read()
    if image is None:
        _send(frames, TORN, arrived=arrived)
    else:
        _send(frames, BGR if is_bgr else RGB, image.shape, memoryview(image).cast("B"), arrived)


def _send_fault(frames: socket.socket, fault: str, message: str) -> None:
    _send(frames, FAULT, body=f"{fault}\n{message}".encode())


def _send(
    frames: socket.socket,
    kind: int,
    shape: tuple[int, ...] = (0, 0),
    body: bytes | memoryview = b"",
    arrived: float | None = None,
) -> None:
    now = time.monotonic() if arrived is None else arrived
    try:
        frames.sendall(HEAD.pack(kind, shape[1], shape[0], len(body), now))
        frames.sendall(body)
    except OSError:
        sys.exit()  # nobody reads any more
