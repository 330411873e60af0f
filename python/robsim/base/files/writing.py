"""Writing files: whole, through links, to the disk, and never over a user's own file."""

from __future__ import annotations

import csv
import errno
import io
import os
import shutil
import stat
import sys
import tempfile
import weakref
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from os import PathLike, fspath
from pathlib import Path
from secrets import token_hex
from typing import Any, BinaryIO

from robsim.base.files.reading import as_folder
from robsim.base.text import as_cell, is_plain, listed, one_line


def write_whole(file: Path, content: bytes) -> None:
    """Write a file: readers get the complete old or new content, even after a crash.

    Links are followed, and an old file's mode and owner are kept; another hard link keeps the old
    content. A device or pipe is written into. An OSError has the user's name of the file.
    """
    with open_whole(file) as stream:
        stream.write(content)


@contextmanager
def open_whole(file: Path) -> Iterator[BinaryIO]:
    """Open a file as `write_whole` does; it changes when the context ends without an exception."""
    with naming(file):
        if _target_of(file) is None:
            with open(file, "wb") as stream:
                yield stream
            return
        part = PartialFile(file)
        try:
            with open(part.descriptor, "wb", closefd=False) as stream:
                yield stream
            part.commit()
        finally:
            part.discard()


def hidden_path(folder: Path, suffix: str = "") -> Path:
    return folder / f".robsim-part-{token_hex(16)}{suffix}"


class PartialFile:
    """A hidden file, written by its `path` or `descriptor`, that then replaces a file.

    See `write_whole`; the suffix is for writers that depend on it. A killed process leaves the
    file.
    """

    def __init__(self, file: Path, *, suffix: str = "") -> None:
        self._file = file
        with naming(file):
            self._old = _status(file)
            self._target = _target_of(file)
            folder = Path(tempfile.gettempdir()) if self._target is None else self._target.parent
            self.path = hidden_path(folder, suffix)
            opened = [-1]
            # Also for a writer that is forgotten, and at exit.
            self._drop = weakref.finalize(self, _drop, self.path, opened, os.getpid())
            flags = os.O_RDWR | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0)
            opened[0] = os.open(self.path, flags, 0o666 if self._old is None else 0o600)
            self.descriptor = opened[0]

    def commit(self, *, overwrite: bool = True) -> None:
        """Bring the content to the disk and name it; an OSError leaves the old file unchanged."""
        with naming(self._file):
            if self._target is None:
                with open(self.path, "rb") as source, open(self._file, "wb") as target:
                    shutil.copyfileobj(source, target)
                self.discard()
                return
            os.fsync(self.descriptor)
            self._keep_mode()
            if os.name == "nt":  # there, an open file cannot be renamed
                os.close(self.descriptor)
            (os.replace if overwrite else _rename_new)(self.path, self._target)
            self._drop.detach()
            with suppress(OSError):  # the content is on the disk
                os.close(self.descriptor)
            sync_folder(self._target.parent)

    def discard(self) -> None:
        """Remove the hidden file, unless it has been renamed."""
        self._drop()

    def _keep_mode(self) -> None:
        if sys.platform != "win32" and self._old is not None:
            new = os.fstat(self.descriptor)
            if (new.st_uid, new.st_gid) != (self._old.st_uid, self._old.st_gid):
                with suppress(PermissionError):
                    os.fchown(self.descriptor, self._old.st_uid, self._old.st_gid)
            os.fchmod(self.descriptor, stat.S_IMODE(self._old.st_mode))


def _rename_new(path: Path, target: Path) -> None:
    """Rename a file, unless the new name exists."""
    try:
        os.link(path, target)
    except FileExistsError:
        raise
    except OSError:  # a file system without hard links
        if os.path.lexists(target):
            raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST), target) from None
        os.rename(path, target)
    else:
        with suppress(OSError):
            os.unlink(path)


def _drop(path: Path, opened: list[int], process: int) -> None:
    if os.getpid() == process and opened[0] >= 0:  # a forked child has its parent's writers, too
        with suppress(OSError):
            os.unlink(path)
        with suppress(OSError):
            os.close(opened[0])


def _status(file: Path) -> os.stat_result | None:
    """Return the status of a writable file, None if there is no file."""
    try:
        status = os.stat(file)
    except FileNotFoundError:
        return None
    if stat.S_ISDIR(status.st_mode):
        raise IsADirectoryError(errno.EISDIR, "this is a folder, not a file", file)
    if not os.access(file, os.W_OK):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), file)
    return status


def _target_of(file: Path) -> Path | None:
    """Return the file that a path leads to; None for a device, a pipe or a file without a name."""
    target, status = Path(os.path.realpath(file)), _status(file)
    if status is None:
        return target
    try:
        is_same = os.path.samestat(status, os.stat(target))
    except FileNotFoundError:
        return None
    return target if is_same and stat.S_ISREG(status.st_mode) else None


def sync_folder(folder: Path) -> None:
    """Bring the names in a folder to the disk."""
    try:
        descriptor = os.open(folder, os.O_RDONLY | getattr(os, "O_DIRECTORY", 0))
    except PermissionError:  # it may be written to, but not read; or Windows
        return
    try:
        os.fsync(descriptor)
    except OSError as error:
        if error.errno not in (errno.EINVAL, errno.ENOTSUP):
            raise
    finally:
        os.close(descriptor)


@contextmanager
def naming(file: str | PathLike[str]) -> Iterator[None]:
    """Add a file's name to an OSError inside the context; a full disk reports no name."""
    try:
        yield
    except OSError as error:
        if error.errno is None:
            raise
        raise OSError(error.errno, error.strerror, fspath(file)) from error


def copy_files(files: Iterable[Path], folder: str | PathLike[str]) -> list[Path]:
    """Copy files into a folder: all of them, or no file if one exists there."""
    return write_new_files({file.name: file.read_bytes() for file in files}, folder)


def write_new_files(contents: Mapping[str, bytes], folder: str | PathLike[str]) -> list[Path]:
    """Write files, by their names, into a folder: all, or no file if one exists there.

    FileExistsError: a file exists. NotADirectoryError: `folder` is a file.
    """
    folder = as_folder(folder)
    if folder.exists() and not folder.is_dir():
        raise NotADirectoryError(f"{one_line(folder)} is a file, not a folder: use another name")
    files = {folder / name: content for name, content in contents.items()}
    existing = [file.name for file in files if os.path.lexists(file)]
    if existing:
        raise FileExistsError(
            f"{one_line(folder)} already has {listed(existing)}: robsim wrote nothing"
        )
    folder.mkdir(parents=True, exist_ok=True)
    written: list[Path] = []
    try:
        for file, content in files.items():
            written.append(file)
            _write_new(file, content)
    except BaseException as error:
        if isinstance(error, FileExistsError):  # it came in the meantime
            written.pop()
        for file in written:
            with suppress(OSError):
                file.unlink()
        raise
    return written


def _write_new(file: Path, content: bytes) -> None:
    """Write a file; raise FileExistsError if there is one of this name."""
    part = PartialFile(file)
    try:
        with naming(file), open(part.descriptor, "wb", closefd=False) as stream:
            stream.write(content)
        part.commit(overwrite=False)
    finally:
        part.discard()


def write_csv(path: Path, columns: Mapping[str, Iterable[Any]]) -> None:
    """Write columns by name; None and NaN stay empty, and an OSError leaves an old file unchanged.

    A text that a spreadsheet would interpret as a formula is prefixed with an apostrophe.
    """
    with open_whole(path) as stream:
        file = io.TextIOWrapper(stream, encoding="utf-8", newline="")
        writer = csv.writer(file)
        head = writer if all(map(is_plain, columns)) else csv.writer(file, quoting=csv.QUOTE_ALL)
        head.writerow(map(as_cell, columns))
        for row in zip(*columns.values(), strict=True):
            writer.writerow(map(_cell, row))
        file.flush()
        file.detach()


def _cell(value: Any) -> Any:
    if isinstance(value, str):
        return as_cell(value)
    return "" if value is None or value != value else value
