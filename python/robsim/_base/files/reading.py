"""Reading files: paths, content, TOML."""

import reprlib
import tomllib
from os import PathLike
from pathlib import Path
from typing import Any

from robsim._base.spelling import suggestion


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
