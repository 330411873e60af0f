"""The process that reads a Python camera, and sends its frames to the parent process."""

from __future__ import annotations

import importlib
import math
import os
import select
import socket
import struct
import sys
import threading
from typing import Any

from robsim.lab.cameras.errors import CaptureError, FrameTimeoutError

#: The head of a frame, as `PixelStream` reads it: kind, width, height, bytes that follow, earlier
#: images that were passed or torn, times of arrival and exposure (time.monotonic(), s).
HEAD = struct.Struct("=6I2d")
OPENED, BGR, NOTHING, FAULT = range(4)

_BETWEEN_LOOKS = 0.5  # s, at the process that reads the frames


def main(descriptor: int, module: str, name: str, options: dict[str, Any]) -> None:
    """Send frames until the other process closes the socket, or ends."""
    frames = socket.socket(fileno=descriptor)
    threading.Thread(target=_end_with, args=(frames, os.getppid()), daemon=True).start()
    try:
        camera = getattr(importlib.import_module(module), name)(**options)
        camera.open()
        _send(frames, OPENED)
        while True:
            try:
                _send_next(frames, camera.read())
            except FrameTimeoutError as error:
                _send_fault(frames, error.fault, str(error))
    except CaptureError as error:
        _send_fault(frames, error.fault, str(error))
    except Exception as error:
        _send_fault(frames, "failed", f"{type(error).__name__}: {error}")


def _end_with(frames: socket.socket, parent: int) -> None:
    """End this process with its reader, even while the camera hangs."""
    while os.getppid() == parent:
        ready, _, _ = select.select([frames], [], [], _BETWEEN_LOOKS)
        if ready:  # readable only at the end
            break
    os._exit(0)


def _send_next(frames: socket.socket, read: tuple[Any, ...] | None) -> None:
    if read is None:
        return
    image, *rest = read
    if image is None:
        _send(frames, NOTHING, (0, 0), b"", *rest)
    else:
        _send(frames, BGR, image.shape, memoryview(image).cast("B"), *rest)


def _send_fault(frames: socket.socket, fault: str, message: str) -> None:
    _send(frames, FAULT, body=f"{fault}\n{message}".encode())


def _send(
    frames: socket.socket,
    kind: int,
    shape: tuple[int, ...] = (0, 0),
    body: bytes | memoryview = b"",
    exposed: float | None = None,
    arrived: float = 0.0,
    passed: int = 0,
    torn: int = 0,
) -> None:
    when = math.nan if exposed is None else exposed
    try:
        frames.sendall(HEAD.pack(kind, shape[1], shape[0], len(body), passed, torn, arrived, when))
        frames.sendall(body)
    except OSError:
        sys.exit()  # the reader has ended
