"""Memory for the grader's frames, which a worker can read, but not write."""

from __future__ import annotations

import mmap
import os
import sys
import tempfile

import numpy as np
from numpy.typing import NDArray

#: Number of frames in the memory: a callback reads one while the grader draws the next; the others
#: are for callbacks that keep some, and are otherwise unused.
SLOTS = 8

_PAGE = 1 << 16  # bytes, a multiple of all systems' pages


def slot_bytes(resolution: tuple[int, int]) -> int:
    """Return the room of a frame (bytes)."""
    width, height = resolution
    return -(-3 * width * height // _PAGE) * _PAGE


def has_frame_memory() -> bool:
    """Return whether this system supports frame memory; otherwise the socket sends pixels."""
    return sys.platform != "win32"


class FrameMemory:
    """Room for some frames (H, W, 3), drawn here; a process with its descriptor can see them.

    The memory has no name: it vanishes when its last process ends. On Linux
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
        """Release the memory when its last image is unused."""
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
