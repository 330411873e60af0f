"""Copying files that ship with robsim into a user's folder."""

from __future__ import annotations

import os
from collections.abc import Iterable
from contextlib import suppress
from os import PathLike
from pathlib import Path

from robsim._base.files.reading import as_folder
from robsim._base.files.writing import PartialFile, naming
from robsim._base.text import listed, one_line


def copy_files(files: Iterable[Path], folder: str | PathLike[str]) -> list[Path]:
    """Copy files into a folder: all of them, or none if one of them exists there."""
    folder = as_folder(folder)
    if folder.exists() and not folder.is_dir():
        raise NotADirectoryError(f"{one_line(folder)} is a file, not a folder: give another name")
    copies = {folder / file.name: file for file in files}
    existing = [copy.name for copy in copies if os.path.lexists(copy)]
    if existing:
        raise FileExistsError(
            f"{one_line(folder)} has {listed(existing)} already: nothing was written"
        )
    folder.mkdir(parents=True, exist_ok=True)
    written: list[Path] = []
    try:
        for copy, file in copies.items():
            written.append(copy)
            _copy(file, copy)
    except BaseException as error:
        if isinstance(error, FileExistsError):  # it came in the meantime
            written.pop()
        for copy in written:
            with suppress(OSError):
                copy.unlink()
        raise
    return written


def _copy(file: Path, copy: Path) -> None:
    """Copy a file; raise FileExistsError if there is one of the new name."""
    part = PartialFile(copy)
    try:
        with naming(copy), open(part.descriptor, "wb", closefd=False) as stream:
            stream.write(file.read_bytes())
        part.commit(overwrite=False)
    finally:
        part.discard()
