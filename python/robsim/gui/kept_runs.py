"""Runs in files of the user's folder: the newest ones, and all that were shared."""

from __future__ import annotations

from collections.abc import Callable
from datetime import datetime
from pathlib import Path

from robsim.vision.robots.lookup import data_folder

_MOST_RUNS = 10


def keep(suffix: str, write: Callable[[Path], object]) -> Path:
    """Write a file among the newest ones, and remove older ones; OSError if writing fails."""
    file = save("runs", suffix, write)
    for old in sorted(file.parent.iterdir())[:-_MOST_RUNS]:
        old.unlink(missing_ok=True)
    return file


def save(name: str, suffix: str, write: Callable[[Path], object]) -> Path:
    """Write a file to a folder of the user; OSError if writing fails."""
    folder = data_folder() / name
    folder.mkdir(parents=True, exist_ok=True)
    file = folder / f"{datetime.now():%Y-%m-%d-%H%M%S-%f}{suffix}"
    write(file)
    return file
