"""Writing files so that nothing is overwritten or left half written."""

import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from os import PathLike, fspath
from pathlib import Path
from secrets import token_hex

from robsim._base.files.reading import as_folder


def copy_files(files: Iterable[Path], folder: str | PathLike[str]) -> list[Path]:
    """Copy files into a folder: all of them, or none if one of them exists there."""
    folder = as_folder(folder)
    if folder.exists() and not folder.is_dir():
        raise NotADirectoryError(f"{folder} is a file, not a folder: give another name")
    copies = {folder / file.name: file for file in files}
    existing = [copy.name for copy in copies if os.path.lexists(copy)]
    if existing:
        raise FileExistsError(f"{folder} has {', '.join(existing)} already: nothing was written")
    folder.mkdir(parents=True, exist_ok=True)
    written: list[Path] = []
    try:
        for copy, file in copies.items():
            with naming(copy), open(copy, "xb") as output:
                written.append(copy)
                output.write(file.read_bytes())
    except BaseException:
        for copy in written:
            copy.unlink(missing_ok=True)
        raise
    return written


def write_whole(file: Path, content: bytes) -> None:
    """Write a file atomically: readers get the old or the new content, never a part."""
    temporary = temporary_path(file)
    with naming(file):
        try:
            temporary.write_bytes(content)
            temporary.replace(file)
        finally:
            temporary.unlink(missing_ok=True)


@contextmanager
def naming(file: str | PathLike[str]) -> Iterator[None]:
    """Let an OSError inside the context name a file: that of a full disk names none."""
    try:
        yield
    except OSError as error:
        if error.errno is None:
            raise
        raise OSError(error.errno, error.strerror, fspath(file)) from error


def temporary_path(file: Path) -> Path:
    """Return an unused hidden path beside a file, with the same suffix: renamed to it later."""
    return file.with_name(f".{file.stem}.{token_hex(16)}{file.suffix}")
