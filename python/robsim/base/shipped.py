"""What ships with robsim, and warnings that point at the user's line."""

from __future__ import annotations

import sys
import warnings
from os import PathLike
from pathlib import Path

from robsim.base.files import copy_files

#: Folder of the shipped images, robot definitions and colours.
ASSETS = Path(__file__).parents[1] / "assets"
#: Folder of the shipped notebooks.
NOTEBOOKS = Path(__file__).parents[1] / "notebooks"


def copy_notebooks(folder: str | PathLike[str]) -> list[Path]:
    """Copy the notebooks of robsim into a folder, created if needed; return the copies' paths.

    It writes nothing if one exists there (FileExistsError), or if `folder` is a file
    (NotADirectoryError).
    """
    return copy_files(sorted(NOTEBOOKS.glob("*.ipynb")), folder)


def warn_user(warning: str | Warning) -> None:
    """Warn, in the name of the line that called robsim."""
    level, caller = 1, sys._getframe()
    while caller.f_back and _is_of_robsim(caller.f_globals.get("__name__", "")):
        level, caller = level + 1, caller.f_back
    warnings.warn(warning, stacklevel=level)


def _is_of_robsim(module: str) -> bool:
    return module == "robsim" or module.startswith("robsim.")
