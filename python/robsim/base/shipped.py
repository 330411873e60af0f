"""The folders that ship with robsim, and copies of its notebooks."""

from __future__ import annotations

from os import PathLike
from pathlib import Path

from robsim.base.files import copy_files

#: Folder of the shipped images, robot definitions and colours.
ASSETS = Path(__file__).parents[1] / "assets"
#: Folder of the shipped notebooks.
NOTEBOOKS = Path(__file__).parents[1] / "notebooks"


def copy_notebooks(folder: str | PathLike[str]) -> list[Path]:
    """Copy the notebooks of robsim and their picture into a folder; return the copies' paths.

    The folder is created if needed.

    It writes nothing if one exists there (FileExistsError), or if `folder` is a file
    (NotADirectoryError).
    """
    return copy_files(sorted(NOTEBOOKS.glob("*.*")), folder)
