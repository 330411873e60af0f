"""Robots by name: those that ship with robsim, then the user's own."""

from __future__ import annotations

from copy import deepcopy
from functools import cache
from os import PathLike
from pathlib import Path

from robsim._base.shipped import ASSETS
from robsim.robots._default_robot import data_folder, default_robot, gone, remember
from robsim.robots._definition import RobotDefinition
from robsim.robots._files import TOML, read_robot


def shipped_robots() -> dict[str, Path]:
    """Return the folders of the robots that ship with robsim, by name."""
    return _folders(ASSETS / "robots")


def own_folder() -> Path:
    """Return the folder of the user's own robots."""
    return data_folder() / "robots"


def own_robots() -> dict[str, Path]:
    """Return the folders of the user's own robots, by name."""
    return _folders(own_folder())


def _folders(parent: Path) -> dict[str, Path]:
    files = sorted(parent.glob(f"*/{TOML}"))
    return {file.parent.name: file.parent for file in files if file.parent.name[0] != "."}


def same_name(name: str, names: dict[str, Path]) -> str | None:
    """Return the name among others that is the same but for the case."""
    return next((other for other in names if other.casefold() == name.casefold()), None)


def robot_names() -> list[str]:
    """Return the names of all robots: those that ship with robsim, then the user's own."""
    shipped = shipped_robots()
    return [*shipped, *(name for name in own_robots() if same_name(name, shipped) is None)]


def load_robot(robot: str | PathLike[str] | None = None) -> RobotDefinition:
    """Read a robot definition.

    Parameters
    ----------
    robot : str or path, optional
        Name of a robot, one that ships with robsim or one of your own, or a folder with a
        ``robot.toml``. Default: the robot in use, see `set_default_robot`.

    Raises
    ------
    ValueError
        If there is no such robot, or its files do not define one; the message says where.
    """
    if robot is None:
        name = default_robot()
        folder = find_folder(name)
        if folder is None:
            raise gone(name)
        return _read(folder)
    folder = find_folder(robot)
    if folder is None and (Path(robot) / TOML).is_file():
        folder = Path(robot)
    if folder is None:
        raise unknown(robot, ", or give a folder with a robot.toml")
    return _read(folder)


def _read(folder: Path) -> RobotDefinition:
    """Return a folder's definition, one of the caller's own; what ships is read but once."""
    shipped = folder.parent == ASSETS / "robots"
    return deepcopy(_shipped_robot(folder)) if shipped else read_robot(folder)


@cache
def _shipped_robot(folder: Path) -> RobotDefinition:
    return read_robot(folder)


def find_folder(robot: str | PathLike[str]) -> Path | None:
    """Return the folder of a robot's name, None if there is none of that name."""
    for robots in (shipped_robots(), own_robots()):
        if (name := same_name(str(robot), robots)) is not None:
            return robots[name]
    return None


def unknown(robot: object, hint: str = "") -> ValueError:
    """Return the error for a name that no robot has."""
    return ValueError(f"no robot {str(robot)!r}: there are {', '.join(robot_names())}{hint}")


def set_default_robot(name: str) -> None:
    """Choose the robot in use: what a simulation shows unless another is asked for.

    The choice is kept until the next one, see `reset_default_robot`.

    Parameters
    ----------
    name : str
        Name of a robot, one that ships with robsim or one of your own.

    Raises
    ------
    ValueError
        If there is no such robot, or its files do not define one.
    """
    folder = find_folder(name)
    if folder is None:
        raise unknown(name, "; `robsim robots add` takes in others")
    read_robot(folder)
    remember(folder.name)


def as_robot(robot: str | PathLike[str] | RobotDefinition | None) -> RobotDefinition:
    """Return the robot definition itself, or that of a name or folder; None = that in use."""
    if isinstance(robot, RobotDefinition):
        return robot
    if robot is None or isinstance(robot, (str, PathLike)):
        return load_robot(robot)
    raise TypeError(f"robot must be a name, a folder or a RobotDefinition, got {robot!r}")
