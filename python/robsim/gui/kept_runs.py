"""The newest runs, saved in the user's folder."""

from __future__ import annotations

from collections.abc import Callable
from datetime import datetime
from pathlib import Path

from robsim.vision.robots.lookup import data_folder

_MOST_RUNS = 10


def keep(suffix: str, write: Callable[[Path], object]) -> Path:
    """Write a file to the newest ones, and remove older ones; OSError if writing fails."""
    folder = data_folder() / "runs"
    folder.mkdir(parents=True, exist_ok=True)
    file = folder / f"{datetime.now():%Y-%m-%d-%H%M%S-%f}{suffix}"
    write(file)
    for old in sorted(folder.iterdir())[:-_MOST_RUNS]:
        old.unlink(missing_ok=True)
    return file
