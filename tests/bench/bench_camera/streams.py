"""Reads RTSP from a real server, over a line that stalls and breaks: how old are the pictures?"""

from __future__ import annotations

import contextlib
import select
import socket
import subprocess
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from robsim.lab import Camera
from robsim.vision.imaging.images import Pixels

CODINGS = ("h264", "mjpeg")
PYTHON = "/usr/bin/python3"
PACKAGES = (
    "python3-gi gir1.2-gst-rtsp-server-1.0 gstreamer1.0-plugins-base gstreamer1.0-plugins-good "
    "gstreamer1.0-plugins-ugly"
)
CELLS = 32  # of a picture, a bit of its time (ms) each
STALL = 1.5  # s
PATIENCE = 60  # s, for a server and a camera to start

_SERVER = Path(__file__).with_name("rtsp_server.py")


class Line:
    """A line to a local port, which can stand still or break."""

    def __init__(self, port: int) -> None:
        self._port = port
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.port: int = self._listener.getsockname()[1]
        self.still_until = 0.0  # monotonic, s
        self.n_breaks = 0
        threading.Thread(target=self._accept, daemon=True).start()

    def _accept(self) -> None:
        with contextlib.suppress(OSError):
            while True:
                ends = (
                    self._listener.accept()[0],
                    socket.create_connection(("127.0.0.1", self._port)),
                )
                threading.Thread(target=self._carry, args=ends, daemon=True).start()

    def _carry(self, near: socket.socket, far: socket.socket) -> None:
        n_breaks = self.n_breaks
        with near, far, contextlib.suppress(OSError):
            while self.n_breaks == n_breaks:
                for one in select.select([near, far], [], [], 0.1)[0]:
                    time.sleep(max(0.0, self.still_until - time.monotonic()))
                    if not (data := one.recv(1 << 16)):
                        return
                    (far if one is near else near).sendall(data)

    def close(self) -> None:
        """Break it for good."""
        self.n_breaks += 1
        self._listener.close()


def time_of(image: Pixels) -> int:
    """Return the time that a picture shows (ms, 32 bits)."""
    height, width, _ = image.shape
    places = (np.arange(CELLS) + 0.5) * width / CELLS
    bits = image[height // 2, places.astype(int)].mean(axis=-1) > 128
    return sum(1 << k for k in range(CELLS) if bits[k])


def read_stream(coding: str, *, seconds: float = 9.0) -> dict[str, Any]:
    """Read a stream whose line stalls after a third of the time, and breaks after two.

    Returns
    -------
    dict
        As `Stream` has it.

    Raises
    ------
    OSError
        If there is no such server.
    """
    ages, hidden = [], []
    with _served(coding) as port, contextlib.closing(Line(port)) as line:
        url = f"rtsp://127.0.0.1:{line.port}/camera"
        with Camera(url, reopen=True, open_timeout=PATIENCE) as camera:
            start = time.monotonic()
            has_stalled = has_broken = False
            while (lasted := time.monotonic() - start) < seconds:
                if not has_stalled and lasted > seconds / 3:
                    line.still_until, has_stalled = time.monotonic() + STALL, True
                if not has_broken and lasted > 2 * seconds / 3:
                    line.n_breaks, has_broken = line.n_breaks + 1, True
                frame = camera.read(PATIENCE)
                now = time.monotonic()
                shown = time_of(frame.image)
                ages.append((int(1000 * now) - shown) % 2**32)
                hidden.append(1000 * ((frame.epoch or 0) + frame.t) % 2**32 - shown)
            dropped = camera.counts.dropped
    return {
        "coding": coding,
        "frames": len(ages),
        "dropped": dropped,
        "age": float(np.median(ages)),
        "oldest": float(max(ages)),
        "untold": max(hidden) - min(hidden),
    }


@contextlib.contextmanager
def _served(coding: str) -> Iterator[int]:
    with socket.create_server(("127.0.0.1", 0)) as free:
        port: int = free.getsockname()[1]
    with subprocess.Popen(
        [PYTHON, str(_SERVER), str(port), coding],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as server:
        assert server.stdout
        assert server.stderr
        if server.stdout.readline() != "ready\n":
            said = server.stderr.read().strip().rpartition("\n")[2]
            raise OSError(f"no server of RTSP ({said}): sudo apt-get install {PACKAGES}")
        try:
            yield port
        finally:
            server.kill()
