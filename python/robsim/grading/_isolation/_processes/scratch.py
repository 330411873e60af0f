"""Folders that workers may write in, and nobody else looks into."""

from __future__ import annotations

import os
import secrets
import shutil
import stat
import tempfile
from contextlib import suppress

_BLOCK = 4096  # bytes


def make_base() -> str:
    """Make the folder of a grader's scratch folders: others may pass through, not list it."""
    base = tempfile.mkdtemp(prefix="robsim-grading-")
    os.chmod(base, 0o711)
    return base


def make_scratch(base: str, user: int | None) -> str:
    """Make an empty folder for one worker, under a name that no other can guess."""
    scratch = os.path.join(base, secrets.token_hex(16))
    os.mkdir(scratch, 0o700)
    if user is not None:
        os.chown(scratch, user, user)
    return scratch


def exceeds(folder: str, most: int) -> bool:
    """Return whether files take more than a number of bytes, each at least a block."""
    total, waiting = 0, [folder]
    while waiting:
        try:
            with os.scandir(waiting.pop()) as entries:
                for entry in entries:
                    status = entry.stat(follow_symlinks=False)
                    total += max(_BLOCK, status.st_blocks * 512)
                    if total > most:
                        return True
                    if stat.S_ISDIR(status.st_mode):
                        waiting.append(entry.path)
        except OSError:  # it is just being removed, or closed by the worker
            continue
    return False


def remove(folder: str) -> None:
    """Remove a folder with all that is in it, also what is closed to its owner."""

    def open_up(path: str) -> None:
        with suppress(OSError):
            if stat.S_ISDIR(os.lstat(path).st_mode):
                os.chmod(path, 0o700)

    open_up(folder)
    for here, folders, _ in os.walk(folder):  # does not follow links
        for name in folders:
            open_up(os.path.join(here, name))
    shutil.rmtree(folder, ignore_errors=True)
