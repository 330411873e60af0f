"""Memory in which the grader draws frames, and which a worker sees, but cannot write."""

from __future__ import annotations

import mmap
import os
import sys
import tempfile

import numpy as np
from numpy.typing import NDArray

#: Frames that there is room for: while one is looked at, the next one is drawn; the others are for
#: callbacks that keep some, and are not touched otherwise.
SLOTS = 8

_PAGE = 1 << 16  # bytes; the pages of all systems go into it


def slot_bytes(resolution: tuple[int, int]) -> int:
    """Return the room of a frame (bytes)."""
    width, height = resolution
    return -(-3 * width * height // _PAGE) * _PAGE


def has_frame_memory() -> bool:
    """Return whether this system has it; where it has not, pixels go through the socket."""
    return sys.platform != "win32"


class FrameMemory:
    """Room for some frames (H, W, 3), drawn here; a process with its descriptor can see them.

    It has no name, so that nothing of it is left when the last process that has it ends. On Linux
    it is sealed: its descriptor allows neither a write nor another size.
    """

    def __init__(self, resolution: tuple[int, int]) -> None:
        width, height = resolution
        size = slot_bytes(resolution)
        self.descriptor, memory = _made(SLOTS * size)
        self.images: list[NDArray[np.uint8]] = [
            np.frombuffer(memory, np.uint8, 3 * width * height, slot * size).reshape(
                height, width, 3
            )
            for slot in range(SLOTS)
        ]

    def close(self) -> None:
        """Give it back, as soon as nobody looks at the images any more."""
        os.close(self.descriptor)
        self.images = []


def _made(size: int) -> tuple[int, mmap.mmap]:
    """Return a descriptor for reading, and the memory."""
    if sys.platform == "linux":
        import fcntl

        descriptor = os.memfd_create("frames", os.MFD_CLOEXEC | os.MFD_ALLOW_SEALING)
        try:
            os.ftruncate(descriptor, size)
            memory = mmap.mmap(descriptor, size)
            seal_future_write = 0x10
            seals = fcntl.F_SEAL_GROW | fcntl.F_SEAL_SHRINK | fcntl.F_SEAL_SEAL | seal_future_write
            fcntl.fcntl(descriptor, fcntl.F_ADD_SEALS, seals)
        except BaseException:
            os.close(descriptor)
            raise
        return descriptor, memory
    with tempfile.NamedTemporaryFile(prefix="robsim-frames-") as file:
        file.truncate(size)
        return os.open(file.name, os.O_RDONLY), mmap.mmap(file.fileno(), size)
