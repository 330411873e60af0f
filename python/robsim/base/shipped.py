"""Paths of the data files that ship with robsim: assets and notebooks."""

from os import PathLike
from pathlib import Path

from robsim.base.files import copy_files

#: Folder of the shipped images, robot definitions and colours.
ASSETS = Path(__file__).parents[1] / "assets"

#: Folder of the shipped notebooks.
NOTEBOOKS = Path(__file__).parents[1] / "notebooks"


def copy_notebooks(folder: str | PathLike[str]) -> list[Path]:
    """Copy the notebooks that ship with robsim into a folder.

    Parameters
    ----------
    folder : path
        The folder; it is created if needed.

    Returns
    -------
    list of Path
        The copies.

    Raises
    ------
    FileExistsError
        If one of them exists there; then nothing is written.
    NotADirectoryError
        If `folder` is a file.
    """
    return copy_files(sorted(NOTEBOOKS.glob("*.ipynb")), folder)
