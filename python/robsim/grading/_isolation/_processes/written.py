"""What workers write: counted, against what they may."""

from __future__ import annotations

import os
import stat
import sys
from collections.abc import Iterable

_BLOCK = 1 << 16  # bytes: to remove a folder takes milliseconds on some disks
_DEEPEST = 100  # folders in folders


def exceeds(folder: str, most: int) -> bool:
    """Return whether files take more than a number of bytes, each at least a block, or lie deep.

    What cannot be looked into, because it is closed, may be more than that.
    """
    total, waiting = 0, [(folder, 0)]
    while waiting:
        here, depth = waiting.pop()
        if depth > _DEEPEST:
            return True
        try:
            with os.scandir(here) as entries:
                for entry in entries:
                    status = _status(entry)
                    total += max(_BLOCK, _size_on_disk(status))
                    if total > most:
                        return True
                    if stat.S_ISDIR(status.st_mode):
                        waiting.append((entry.path, depth + 1))
        except (FileNotFoundError, NotADirectoryError):  # it is just being removed
            continue
        except OSError:
            return True
    return False


def _status(entry: os.DirEntry[str]) -> os.stat_result:
    if sys.platform == "win32":  # a folder there knows the size of an open file only later
        return os.lstat(entry.path)
    return entry.stat(follow_symlinks=False)


def _size_on_disk(status: os.stat_result) -> int:
    if sys.platform == "win32":
        return status.st_size
    return status.st_blocks * 512


def room_for(sizes: Iterable[int]) -> int:
    """Return how much `exceeds` counts for files of these sizes (bytes)."""
    return sum(size + _BLOCK for size in sizes)
