"""The files of workers: their size, compared with the limit."""

from __future__ import annotations

import os
import stat
import sys

from robsim.teach.isolation.limits import BLOCK

assert sys.platform == "linux"

_DEEPEST = 100  # folders in folders


def exceeds(folder: str, most: int) -> bool:
    """Return whether files need more than a number of bytes, each at least a block, or are deep.

    A closed folder counts as too much.
    """
    total, waiting = 0, [(folder, 0)]
    while waiting:
        here, depth = waiting.pop()
        if depth > _DEEPEST:
            return True
        try:
            with os.scandir(here) as entries:
                for entry in entries:
                    status = entry.stat(follow_symlinks=False)
                    total += max(BLOCK, 512 * status.st_blocks)
                    if total > most:
                        return True
                    if stat.S_ISDIR(status.st_mode):
                        waiting.append((entry.path, depth + 1))
        except (FileNotFoundError, NotADirectoryError):  # it is just being removed
            continue
        except OSError:
            return True
    return False
