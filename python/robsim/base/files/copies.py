"""Files that are written into a user's folder, and overwrite nothing there."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from contextlib import suppress
from os import PathLike
from pathlib import Path

from robsim.base.files.reading import as_folder
from robsim.base.files.writing import PartialFile, naming
from robsim.base.text import listed, one_line


def copy_files(files: Iterable[Path], folder: str | PathLike[str]) -> list[Path]:
    """Copy files into a folder: all of them, or none if one of them exists there."""
    return write_new_files({file.name: file.read_bytes() for file in files}, folder)


def write_new_files(contents: Mapping[str, bytes], folder: str | PathLike[str]) -> list[Path]:
    """Write files, by their names, into a folder: all, or none if one of them exists there.

    Raises
    ------
    FileExistsError
        If one of them exists.
    NotADirectoryError
        If `folder` is a file.
    OSError
        If one cannot be written.
    """
    folder = as_folder(folder)
    if folder.exists() and not folder.is_dir():
        raise NotADirectoryError(f"{one_line(folder)} is a file, not a folder: give another name")
    files = {folder / name: content for name, content in contents.items()}
    existing = [file.name for file in files if os.path.lexists(file)]
    if existing:
        raise FileExistsError(
            f"{one_line(folder)} has {listed(existing)} already: nothing was written"
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
