"""Files that ship with the package, and their like."""

import os
import tomllib
from collections.abc import Iterable
from os import PathLike
from pathlib import Path
from typing import Any

#: Folder of the shipped pictures, robot definitions and colours.
ASSETS = Path(__file__).with_name("assets")

#: Folder of the shipped notebooks.
NOTEBOOKS = Path(__file__).with_name("notebooks")


def copy_notebooks(folder: str | PathLike[str]) -> list[Path]:
    """Copy the notebooks that ship with robsim into a folder.

    Parameters
    ----------
    folder : path
        The folder; it is made if needed.

    Returns
    -------
    list of Path
        The copies.

    Raises
    ------
    FileExistsError
        If one of them is there already; then nothing is written.
    NotADirectoryError
        If `folder` is a file.
    """
    return copy_files(sorted(NOTEBOOKS.glob("*.ipynb")), folder)


def copy_files(files: Iterable[Path], folder: str | PathLike[str]) -> list[Path]:
    """Copy files into a folder, all of them or, if one is there already, none."""
    folder = as_folder(folder)
    if folder.exists() and not folder.is_dir():
        raise NotADirectoryError(f"{folder} is a file, not a folder: give another name")
    copies = {folder / file.name: file for file in files}
    there = [copy.name for copy in copies if os.path.lexists(copy)]
    if there:
        raise FileExistsError(f"{folder} has {', '.join(there)} already: nothing was written")
    folder.mkdir(parents=True, exist_ok=True)
    for copy, file in copies.items():
        with open(copy, "xb") as output:
            output.write(file.read_bytes())
    return list(copies)


def as_folder(folder: str | PathLike[str]) -> Path:
    """Return a folder's path; a TypeError for what is none."""
    if not isinstance(folder, (str, PathLike)):
        raise TypeError(f"folder must be a path, got {folder!r}")
    return Path(folder)


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
        If it is not TOML; the message names it.
    """
    content = Path(path).read_bytes()
    try:
        return tomllib.loads(content.decode("utf-8-sig"))
    except (ValueError, RecursionError) as error:
        raise ValueError(f"{path} is not a TOML file: {error}") from error
