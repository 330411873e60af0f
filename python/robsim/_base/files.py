"""Reading TOML and writing files so that nothing is overwritten or left half written."""

import os
import reprlib
import tomllib
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from os import PathLike, fspath
from pathlib import Path
from secrets import token_hex
from typing import Any

from robsim._base.spelling import suggestion


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


def as_folder(folder: str | PathLike[str]) -> Path:
    """Return `folder` as a Path; raise TypeError if it is not path-like."""
    return as_path(folder, "folder")


def as_path(path: str | PathLike[str], name: str = "path") -> Path:
    """Return the argument `name` as a Path; raise TypeError if it is not path-like."""
    if not isinstance(path, (str, PathLike)):
        raise TypeError(f"{name} must be a path, got {reprlib.repr(path)}")
    return Path(path)


def read_toml(path: str | PathLike[str]) -> dict[str, Any]:
    """Read a TOML file, with or without a byte order mark.

    Parameters
    ----------
    path : path
        The file.

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    ValueError
        If it is not TOML; the message names the file.
    """
    content = content_of(Path(path))
    try:
        return tomllib.loads(content.decode("utf-8-sig"))
    except UnicodeDecodeError as error:
        raise ValueError(f"{path} is not a TOML file: it is not UTF-8 text") from error
    except (ValueError, RecursionError) as error:
        raise ValueError(f"{path} is not a TOML file: {error}") from error


def content_of(path: Path, size: int = -1) -> bytes:
    """Return the first `size` bytes of a file, all by default.

    Raises
    ------
    FileNotFoundError
        If there is no such file, with the one in its folder that was probably meant.
    """
    try:
        with path.open("rb") as file:
            return file.read(size)
    except FileNotFoundError as error:
        others = sorted(path.parent.glob(f"*{path.suffix}")) if path.suffix else []
        hint = suggestion(path.name, [other.name for other in others])
        raise FileNotFoundError(error.errno, f"{error.strerror}{hint}", str(path)) from None


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
