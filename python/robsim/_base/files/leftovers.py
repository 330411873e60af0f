"""Hidden files that are being written, and those that a killed process has left behind."""

from __future__ import annotations

import os
import re
import stat
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from secrets import token_hex

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]

_NAME = ".robsim-part-"
_OURS = re.compile(re.escape(_NAME) + r"[0-9a-f]{32}(\.\w{1,8})?")
_OLD = 86_400.0  # s; where files cannot be locked

# Folders without a leftover, and when they were changed last.
_clean: dict[Path, int] = {}


def hidden_path(folder: Path, suffix: str = "") -> Path:
    """Return an unused path in a folder: hidden, short, and recognised by `sweep`."""
    return folder / f"{_NAME}{token_hex(16)}{suffix}"


def is_hidden_path(path: Path) -> bool:
    """Return whether a path is one of `hidden_path`."""
    return _OURS.fullmatch(path.name) is not None


@contextmanager
def locked_folder(folder: Path) -> Iterator[None]:
    """Let one process at a time change what is in a folder; a killed one lets go of it."""
    if sys.platform == "win32" or fcntl is None:
        yield
        return
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        with suppress(OSError):  # a file system without locks
            fcntl.flock(descriptor, fcntl.LOCK_EX)
        yield
    finally:
        os.close(descriptor)


def create_hidden(folder: Path, suffix: str, mode: int) -> tuple[Path, int]:
    """Create a hidden file; return its path and its descriptor, locked until it is closed."""
    while True:
        path = hidden_path(folder, suffix)
        flags = os.O_RDWR | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0)
        descriptor = os.open(path, flags, mode)
        try:
            if _lock(descriptor) and os.path.samestat(os.fstat(descriptor), os.stat(path)):
                return path, descriptor
        except FileNotFoundError:  # swept by another process before it was locked
            pass
        except BaseException:
            drop_hidden(path, descriptor)
            raise
        drop_hidden(path, descriptor)


def drop_hidden(path: Path, descriptor: int) -> None:
    """Remove a hidden file; if that fails, too, the next `sweep` does it."""
    with suppress(OSError):
        os.unlink(path)
    with suppress(OSError):
        os.close(descriptor)


def sweep(folder: Path) -> None:
    """Remove the hidden files that a killed process left in a folder, and nothing else.

    The lock of a living writer tells that a file is in use.
    """
    with suppress(OSError):
        changed = os.stat(folder).st_mtime_ns
        if _clean.get(folder) == changed:
            return
        _clean.pop(folder, None)
        with os.scandir(folder) as entries:
            ours = [Path(entry.path) for entry in entries if _OURS.fullmatch(entry.name)]
        if sum(map(_remove_if_abandoned, ours)) == len(ours):
            note_clean(folder)


def note_clean(folder: Path) -> None:
    """Remember that nothing is to be swept in a folder until somebody else changes it."""
    if len(_clean) > 1000:
        _clean.clear()
    _clean[folder] = os.stat(folder).st_mtime_ns


def is_clean(folder: Path) -> bool:
    """Return whether the last sweep left nothing in a folder."""
    return folder in _clean


def _remove_if_abandoned(path: Path) -> bool:
    """Remove a hidden file without a writer; return whether it is gone."""
    flags = os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0)
    try:
        descriptor = os.open(path, flags)
    except FileNotFoundError:
        return True
    except OSError:
        return False
    try:
        status = os.fstat(descriptor)
        if not stat.S_ISREG(status.st_mode) or _is_held(descriptor, status):
            return False
        os.unlink(path)
    except FileNotFoundError:
        return True
    except OSError:
        return False
    finally:
        os.close(descriptor)
    return True


def _lock(descriptor: int) -> bool:
    """Lock a file; return False if a sweep of another process holds it just now."""
    if sys.platform != "win32" and fcntl is not None:
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            return False
        except OSError:  # a file system without locks
            pass
    return True


def _is_held(descriptor: int, status: os.stat_result) -> bool:
    """Return whether a process is writing a file."""
    if sys.platform != "win32" and fcntl is not None:
        try:
            fcntl.flock(descriptor, fcntl.LOCK_SH | fcntl.LOCK_NB)
        except BlockingIOError:
            return True
        except OSError:
            pass
        else:
            return False
    return time.time() - status.st_mtime < _OLD
