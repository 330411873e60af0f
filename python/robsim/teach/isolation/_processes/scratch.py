"""Writable folders of workers, hidden from other users."""

from __future__ import annotations

import sys

assert sys.platform != "win32"

import fcntl
import functools
import os
import secrets
import tempfile
from contextlib import suppress

_PREFIX = "robsim-grading-"
_FOLDER = os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW | os.O_CLOEXEC


class Base:
    """The folder of a grader's scratch folders: others may pass through, not list it.

    Each user of the folder holds a lock, which ends with the process. A folder without a lock is
    a leftover of a killed grader; the next grader that makes its own removes it.
    """

    _lock: int | None = None

    def __init__(self) -> None:
        _remove_leftovers()
        while True:
            self.path = tempfile.mkdtemp(prefix=_PREFIX)
            try:
                self._lock = held(self.path)
            except FileNotFoundError:  # removed as a leftover, before the lock
                continue
            os.chmod(self.path, 0o711)
            return

    def let_go(self) -> None:
        if self._lock is not None:
            os.close(self._lock)
        self._lock = None

    def remove(self) -> None:
        remove(self.path)
        self.let_go()


def held(base: str) -> int:
    """Return a descriptor that keeps a folder from removal; FileNotFoundError if it is too late."""
    lock = os.open(base, _FOLDER)
    fcntl.flock(lock, fcntl.LOCK_SH)
    if not os.path.lexists(base):
        os.close(lock)
        raise FileNotFoundError(base)
    return lock


@functools.cache
def _remove_leftovers() -> None:
    """Remove the leftovers of ended graders of the same user; once in a process."""
    remove_leftovers(tempfile.gettempdir())


def remove_leftovers(folder: str) -> None:
    """Remove this user's bases in a folder that have no lock."""
    with suppress(OSError):
        for name in os.listdir(folder):
            if name.startswith(_PREFIX):
                with suppress(OSError):  # another user's, or locked
                    _remove_if_left(os.path.join(folder, name))


def _remove_if_left(base: str) -> None:
    lock = os.open(base, _FOLDER)
    try:
        if os.fstat(lock).st_uid == os.geteuid():
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            remove(base)
    finally:
        os.close(lock)


def make_scratch(base: str, user: int | None) -> str:
    """Make an empty folder for one worker, with a name that no other can guess."""
    scratch = os.path.join(base, secrets.token_hex(16))
    os.mkdir(scratch, 0o700)
    if user is not None:
        os.chown(scratch, user, user)
    return scratch


def remove(folder: str) -> None:
    """Remove a folder with all its content, also at any depth and without the owner's rights."""
    with suppress(OSError):
        _empty(_entered(folder))
    with suppress(OSError):
        os.rmdir(folder)


def _empty(here: int) -> None:
    """Empty an open folder, and close it, without long paths or recursion."""
    above: list[tuple[tuple[int, int], list[str]]] = []  # each folder, and its remaining folders
    inside = _folders_left(here)
    try:
        while inside or above:
            if inside:
                inner = _entered(inside[-1], here)
                above.append((_identity(here), inside))
            else:
                inner = os.open("..", _FOLDER, dir_fd=here)
            os.close(here)
            here = inner
            if inside:
                inside = _folders_left(here)
                continue
            identity, inside = above.pop()
            if _identity(here) != identity:  # moved meanwhile: not ours to remove
                return
            os.rmdir(inside.pop(), dir_fd=here)
    finally:
        os.close(here)


def _entered(name: str, above: int | None = None) -> int:
    try:
        return os.open(name, _FOLDER, dir_fd=above)
    except PermissionError:  # never for root, whose chmod must not follow a link
        os.chmod(name, 0o700, dir_fd=above)
        return os.open(name, _FOLDER, dir_fd=above)


def _identity(folder: int) -> tuple[int, int]:
    status = os.fstat(folder)
    return status.st_dev, status.st_ino


def _folders_left(here: int) -> list[str]:
    """Remove all but the folders from a folder; return the folders."""
    with os.scandir(here) as entries:
        inside = list(entries)
    folders = [entry.name for entry in inside if entry.is_dir(follow_symlinks=False)]
    for name in {entry.name for entry in inside} - set(folders):
        with suppress(FileNotFoundError):
            os.unlink(name, dir_fd=here)
    return folders
