"""Folders that workers may write in, and files beside them that say whether they are in use."""

from __future__ import annotations

import functools
import os
import shutil
import stat
import sys
import tempfile
from collections.abc import Callable
from contextlib import suppress
from secrets import token_hex
from typing import Any

assert sys.platform == "win32"

_PREFIX = "robsim-grading-"
_HELD = ".held"


class Scratch:
    """The folder of one worker.

    A file beside it is removed by the system when its process ends, however that is: a folder
    without one was left by a grader that was killed, and is removed by the next one.
    """

    def __init__(self) -> None:
        _remove_leftovers()
        self.path = os.path.join(tempfile.gettempdir(), f"{_PREFIX}{token_hex(16)}")
        flags = os.O_CREAT | os.O_EXCL | os.O_RDWR | os.O_TEMPORARY | os.O_NOINHERIT
        self._held: int | None = os.open(self.path + _HELD, flags)
        os.mkdir(self.path)

    def remove(self) -> None:
        """Remove it with all that is in it."""
        remove(self.path)
        if self._held is not None:
            os.close(self._held)
        self._held = None


@functools.cache
def _remove_leftovers() -> None:
    """Remove what graders of the same user have left that are gone; once in a process."""
    remove_leftovers(tempfile.gettempdir())


def remove_leftovers(folder: str) -> None:
    """Remove the folders in a folder that nobody holds."""
    with suppress(OSError):
        for name in os.listdir(folder):
            path = os.path.join(folder, name)
            ours = name.startswith(_PREFIX) and os.path.isdir(path)
            if ours and not os.path.lexists(path + _HELD):
                remove(path)


def remove(folder: str) -> None:
    """Remove a folder with all that is in it, also what is read-only, and no link's target."""
    shutil.rmtree(_long(folder), onerror=_again)


def _long(path: str) -> str:
    """Return a path that may be as long as it likes."""
    return path if path.startswith("\\\\") else f"\\\\?\\{os.path.abspath(path)}"


def _again(remove: Callable[..., Any], path: str, error: object) -> None:
    with suppress(OSError):
        os.chmod(path, stat.S_IWRITE)
        remove(path)
        return
    with suppress(OSError):  # a junction
        os.rmdir(path)
