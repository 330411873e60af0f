"""The file of a calibration: what is read, and what is not overwritten."""

from __future__ import annotations

from pathlib import Path

from robsim.base.text import one_line
from robsim.vision.imaging.calibration import Calibration
from robsim.vision.imaging.calibration_file import load_calibration


def refuse_device(file: Path) -> None:
    """Raise a ValueError if a path is of something that is no file; a pipe would never end."""
    if file.exists() and not file.is_file():
        raise ValueError(f"{one_line(file)} is not a file")


def replaced(file: Path, calibration: Calibration, *, is_known: bool) -> Calibration | None:
    """Return what a file has that is to be written; None if there is none.

    Parameters
    ----------
    file : Path
        The file.
    calibration : Calibration
        What is to be written.
    is_known : bool
        Whether the panel has read or written it.

    Raises
    ------
    ValueError
        If it is not to be overwritten.
    """
    refuse_device(file)
    if not file.exists():
        return None
    name = one_line(file)
    try:
        there = load_calibration(file)
    except ValueError as error:
        raise ValueError(f"{name} is no calibration: save under another name") from error
    if there.intrinsics is not None and calibration.intrinsics is None:
        raise ValueError(
            f"{name} has a lens, which this floor was not calibrated with: load it, or save under "
            "another name"
        )
    if not is_known:
        raise ValueError(
            f"{name} is there already, and was not read here: load it, save under another name, or "
            "remove it first"
        )
    return there
