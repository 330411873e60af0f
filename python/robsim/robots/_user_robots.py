"""The user's own robots: add, rotate, remove."""

from __future__ import annotations

import math
import re
import shutil
from collections.abc import Iterable
from dataclasses import replace
from os import PathLike
from pathlib import Path
from typing import Any
from uuid import uuid4

from numpy.typing import ArrayLike

from robsim._base.checks import check_float
from robsim._base.files import write_whole
from robsim._core import ColorClass
from robsim.imaging._images import Pixels, load_image
from robsim.robots._default_robot import default_robot, reset_default_robot
from robsim.robots._definition import RobotDefinition
from robsim.robots._files import TOML, read_robot, save_robot
from robsim.robots._finding import reduced, robot_from_image
from robsim.robots._lookup import (
    find_folder,
    own_folder,
    own_robots,
    robot_names,
    same_name,
    shipped_robots,
)
from robsim.robots._marker_check import check_colors

# Names of devices: Windows makes no folders that are called so.
_RESERVED = re.compile(r"(?i)con|prn|aux|nul|com\d|lpt\d")
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,39}")


def add_robot(
    name: str,
    source: RobotDefinition | str | PathLike[str],
    *,
    size: float | None = None,
    alignment: float | None = None,
    centre: ArrayLike | None = None,
    outline: ArrayLike | None = None,
    red: ArrayLike | None = None,
    blue: ArrayLike | None = None,
    colors: str | PathLike[str] | Iterable[ColorClass] | None = None,
    overwrite: bool = False,
    ignore_colors: bool = False,
) -> RobotDefinition:
    """Add a robot to your own ones.

    Parameters
    ----------
    name : str
        Its name: 1 to 40 letters, digits, - and _; upper and lower case are the same.
    source : RobotDefinition, str or path
        A definition, the name of a robot, a folder with a ``robot.toml``, or an image. What is
        not given below is taken from it; from an image as `robot_from_image` does.
    size : float, optional
        Work-area px that the width of the image stands for. Default for an image: 120.
    alignment : float, optional
        Degrees clockwise that turn the image so that the robot faces right. Default for a
        image: 0.
    centre : array (2,), optional
        The robot's centre (image px). Default for an image: the centroid of the outline.
    outline, red, blue : array (N, 2), optional
        Polygons around the robot and its markers (image px). Default for an image: what is
        opaque, and the biggest blobs of the colours.
    colors : path or iterable of ColorClass, optional
        What the markers are found and checked with. Default: the colours that ship with robsim.
    overwrite : bool
        Take the place of an own robot of this name.
    ignore_colors : bool
        Add the robot even if its markers are not seen with these colours.

    Returns
    -------
    RobotDefinition
        The robot as it was stored. Images of more than 1000 px a side are scaled down.

    Raises
    ------
    ValueError
        If the name or the robot is refused; the message says what is wrong. Nothing is stored.
    """
    _check_new(name, overwrite)
    given: dict[str, Any] = {"size": size, "alignment": alignment, "centre": centre}
    given |= {"outline": outline, "red": red, "blue": blue}
    known = source if isinstance(source, RobotDefinition) else _read_source(source)
    if isinstance(known, RobotDefinition):
        changed = {key: value for key, value in given.items() if value is not None}
        definition = reduced(replace(known, name=name, **changed))
    else:
        definition = robot_from_image(name, known, colors=colors, **given)
    problems = [] if ignore_colors else check_colors(definition, colors).sentences
    if problems:
        raise ValueError(
            f"{'; '.join(problems)}. The colour file can be changed later: ignore_colors=True "
            "(--anyway) adds the robot all the same"
        )
    return _store(definition)


def rotate_robot(name: str, degrees: float) -> RobotDefinition:
    """Turn the image of one of your own robots clockwise, so that it faces the right way.

    Parameters
    ----------
    name : str
        Name of the robot.
    degrees : float
        What is added to its alignment.

    Returns
    -------
    RobotDefinition
        The robot as it is now.
    """
    import tomlkit

    folder = _own(name)
    degrees = check_float("degrees", degrees)
    alignment = math.remainder(read_robot(folder).alignment + degrees, 360)
    # Only this number changes: comments that were written by hand stay.
    document = tomlkit.parse((folder / TOML).read_text("utf-8-sig"))
    document["alignment"] = round(alignment, 6) + 0.0
    write_whole(folder / TOML, tomlkit.dumps(document).encode())
    return read_robot(folder)


def remove_robot(name: str) -> None:
    """Remove one of your own robots; if it was in use, the robot ``lab`` is from now on.

    Parameters
    ----------
    name : str
        Name of the robot.
    """
    folder = _own(name)
    try:
        is_chosen = default_robot().casefold() == name.casefold()
    except ValueError:
        is_chosen = False
    _discard(folder)
    if is_chosen:
        reset_default_robot()


def _check_new(name: str, overwrite: bool) -> None:
    """Refuse a name that can't be that of a new robot."""
    if not isinstance(name, str):
        raise TypeError(f"name must be text, got {name!r}")
    if not _NAME.fullmatch(name):
        raise ValueError(
            "name must be 1 to 40 letters (a to z), digits, - and _, the first a letter or a "
            f"digit, got {name!r}"
        )
    if _RESERVED.fullmatch(name):
        raise ValueError(f"name must not be one that Windows keeps for a device, got {name!r}")
    _check_not_shipped(name)
    own = same_name(name, own_robots())
    if own is not None and not overwrite:
        raise ValueError(
            f"you have a robot {own!r} already: overwrite=True (--overwrite) replaces it"
        )


def _check_not_shipped(name: str) -> None:
    shipped = same_name(name, shipped_robots())
    if shipped is not None:
        raise ValueError(
            f"the robot {shipped!r} ships with robsim and stays as it is: "
            f"`robsim robots add my-{shipped} {shipped}` makes a copy of your own to change"
        )


def _own(name: str) -> Path:
    """Return the folder of one of the user's own robots."""
    own = own_robots()
    found = same_name(str(name), own)
    if found is None:
        _check_not_shipped(str(name))
        names = f"there are {', '.join(own)}" if own else "there is none yet"
        raise ValueError(f"you have no robot {str(name)!r} of your own: {names}")
    return own[found]


def _read_source(source: str | PathLike[str]) -> RobotDefinition | Pixels:
    """Return the robot of a name or a folder, or else the image of a file."""
    if not isinstance(source, (str, PathLike)):
        raise TypeError(
            "source must be a RobotDefinition, a robot's name, a folder or an image's file, "
            f"got {source!r}"
        )
    folder = find_folder(source) or Path(source)
    if (folder / TOML).is_file():
        return read_robot(folder)
    if folder.is_dir():
        raise ValueError(f"the folder {folder} has no {TOML}, so it is no robot")
    if not folder.is_file():
        raise ValueError(
            f"source must be a robot's name ({', '.join(robot_names())}), a folder with a {TOML} "
            f"or an image's file, got {str(source)!r}"
        )
    return load_image(folder, mode="RGBA")


def _store(definition: RobotDefinition) -> RobotDefinition:
    """Put a robot into its folder: written aside, read back, then moved, so all or nothing."""
    folder = own_folder() / definition.name
    aside = _beside(folder)
    try:
        save_robot(aside, definition)
        stored = read_robot(aside)
        _put_in_place(aside, folder, own_robots())
    finally:
        shutil.rmtree(aside, ignore_errors=True)
    return stored


def _put_in_place(aside: Path, folder: Path, own: dict[str, Path]) -> None:
    """Rename a new folder; an old one of the same name goes then, or stays if that fails."""
    name = same_name(folder.name, own)
    if name is None:
        aside.rename(folder)
        return
    old = own[name].rename(_beside(folder))
    try:
        aside.rename(folder)
    except BaseException:
        old.rename(own[name])
        raise
    shutil.rmtree(old, ignore_errors=True)


def _discard(folder: Path) -> None:
    """Remove a robot's folder: it is gone at once, its files in time."""
    gone = folder.rename(_beside(folder))
    shutil.rmtree(gone, ignore_errors=True)


def _beside(folder: Path) -> Path:
    """Return the name of a new folder beside another, that no robot can have."""
    return folder.with_name(f".{folder.name}.{uuid4().hex}")
