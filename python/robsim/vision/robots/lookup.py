"""Finds and loads robots by name: first the shipped ones, then the user's."""

from __future__ import annotations

import os
import unicodedata
from functools import lru_cache
from os import PathLike
from pathlib import Path
from secrets import token_hex
from typing import NamedTuple

from robsim.base.checks import check_text
from robsim.base.files import codec, naming, read_text, write_whole
from robsim.base.shipped import ASSETS
from robsim.base.spelling import suggestion
from robsim.base.text import listed, one_line, quoted
from robsim.base.values import FileVersion
from robsim.vision.robots.definition import RobotDefinition
from robsim.vision.robots.files import TOML, read_robot

#: The default robot until the user chooses another.
DEFAULT = "lab"
_RESET = f"`robsim robots reset` restores {DEFAULT!r}"


def data_folder() -> Path:
    """Return the user's folder: ``$ROBSIM_DATA`` if it is set, else the system's data folder."""
    if folder := os.environ.get("ROBSIM_DATA"):
        return Path(folder).expanduser()
    import platformdirs

    return platformdirs.user_data_path("robsim")


def settings_file() -> Path:
    return data_folder() / "settings.toml"


def default_robot() -> str:
    """Return the name of the default robot, which ``load_robot()`` loads.

    Raises
    ------
    ValueError
        If the settings file is damaged; the message names it.

    Examples
    --------
    >>> robsim.vision.default_robot()
    'lab'
    """
    file = settings_file()
    try:
        return _stored_name(FileVersion.of(file))
    except FileNotFoundError:
        return DEFAULT
    except (ValueError, OSError) as error:
        raise ValueError(f"settings file {one_line(error)}; {_RESET}") from error


@lru_cache(maxsize=1)
def _stored_name(file: FileVersion) -> str:
    name: str = codec.load_table(
        file.path, lambda table: check_text("robot", table.get("robot", DEFAULT))
    )
    return name


def missing_robot_error(name: str) -> ValueError:
    return ValueError(
        f"settings file {one_line(settings_file())}: the default robot, {quoted(name)}, no longer "
        f"exists; {_RESET}"
    )


def store_default_robot(name: str) -> None:
    """Write the default robot to the settings file; its other settings are kept."""
    import tomlkit

    file = settings_file()
    settings = tomlkit.document()
    try:
        codec.load_table(file)  # within limits, and more strictly than tomlkit
        settings = tomlkit.parse(read_text(file))
    except FileNotFoundError:
        with naming(file.parent):
            file.parent.mkdir(parents=True, exist_ok=True)
    except (ValueError, OSError) as error:
        raise ValueError(f"settings file {one_line(error)}; {_RESET}") from error
    settings["robot"] = name
    write_whole(file, tomlkit.dumps(settings).encode())


def reset_default_robot() -> None:
    """Make ``lab`` the default robot again; a damaged settings file is renamed, not deleted.

    Examples
    --------
    >>> robsim.vision.reset_default_robot()
    >>> robsim.vision.default_robot()
    'lab'
    """
    file = settings_file()
    if not file.exists():
        return
    try:
        store_default_robot(DEFAULT)
    except ValueError:
        file.replace(file.with_name(f"settings-damaged-{token_hex(4)}.toml"))


_SHIPPED = ASSETS / "robots"


def shipped_robots() -> dict[str, Path]:
    return _folders(_SHIPPED)


def user_robots_folder() -> Path:
    return data_folder() / "robots"


def user_robots() -> dict[str, Path]:
    return _folders(user_robots_folder())


def _folders(parent: Path) -> dict[str, Path]:
    files = sorted(parent.glob(f"*/{TOML}"))
    return {file.parent.name: file.parent for file in files if file.parent.name[0] != "."}


def name_key(name: str) -> str:
    """Return a key that is equal for names that differ in case, or in the encoding of accents."""
    return unicodedata.normalize("NFC", name).casefold()


def same_name(name: str, names: dict[str, Path]) -> str | None:
    return next((other for other in names if name_key(other) == name_key(name)), None)


def robot_names() -> list[str]:
    """Return the names of all robots: first the shipped ones, then the user's.

    Examples
    --------
    >>> "lab" in robsim.vision.robot_names()
    True
    """
    shipped = shipped_robots()
    return [*shipped, *(name for name in user_robots() if same_name(name, shipped) is None)]


def load_robot(robot: str | PathLike[str] | None = None) -> RobotDefinition:
    """Read a robot definition.

    Parameters
    ----------
    robot : str or path, optional
        Name of a shipped robot or of your own, or a folder with a ``robot.toml``. Default: the
        default robot, see `set_default_robot`.

    Returns
    -------
    RobotDefinition
        The robot.

    Raises
    ------
    TypeError
        If `robot` is neither a name nor a path.
    ValueError
        If the robot is unknown, or its files do not define one; the message names the file.

    Examples
    --------
    >>> robot = robsim.load_robot("lab")
    >>> robot.name, list(robot.markers)
    ('lab', ['right', 'left'])
    """
    if not isinstance(robot, (str, PathLike, type(None))):
        raise TypeError(f"robot must be a name or a folder, got {quoted(robot)}")
    if robot is None:
        name = default_robot()
        folder = find_folder(name)
        if folder is None:
            raise missing_robot_error(name)
        return read_robot(folder)
    folder = find_folder(robot)
    if folder is None and (Path(robot) / TOML).is_file():
        folder = Path(robot)
    if folder is None:
        raise unknown_robot_error(robot, ", or give a folder with a robot.toml")
    return read_robot(folder)


def find_folder(robot: str | PathLike[str]) -> Path | None:
    """Return the folder of the robot with a name, or None."""
    key = name_key(str(robot))
    return _folder_in(_SHIPPED, key) or _folder_in(user_robots_folder(), key)


def _folder_in(parent: Path, key: str) -> Path | None:
    """Return the folder of a robot, by the key of its name: `_folders` without reading all."""
    try:
        names = os.listdir(parent)
    except OSError:
        return None
    same = (other for other in sorted(names) if name_key(other) == key and other[0] != ".")
    found = next((other for other in same if os.path.isfile(f"{parent}/{other}/{TOML}")), None)
    return None if found is None else parent / found


def unknown_robot_error(robot: object, hint: str = "") -> ValueError:
    """Return the error for the name of a robot that does not exist."""
    names = robot_names()
    meant = suggestion(str(robot), names)
    return ValueError(f"no robot {quoted(str(robot))}; known: {listed(names)}{meant or hint}")


def set_default_robot(name: str) -> None:
    """Choose the default robot: the robot of simulations that name no robot.

    The choice is stored for this user, until it is changed or `reset_default_robot` is called.

    Parameters
    ----------
    name : str
        Name of a shipped robot or of your own.

    Raises
    ------
    ValueError
        If the robot is unknown, or its files do not define one.

    Examples
    --------
    >>> robsim.vision.set_default_robot("robot2")
    >>> robsim.vision.default_robot()
    'robot2'
    >>> robsim.vision.reset_default_robot()
    """
    folder = find_folder(check_text("name", name))
    if folder is None:
        raise unknown_robot_error(name, "; `robsim robots add` adds others")
    read_robot(folder)
    store_default_robot(folder.name)


def as_robot(robot: str | PathLike[str] | RobotDefinition | None) -> RobotDefinition:
    """Return a robot definition, loaded if `robot` is a name, a folder or None (the default)."""
    if isinstance(robot, RobotDefinition):
        return robot
    if robot is None or isinstance(robot, (str, PathLike)):
        return load_robot(robot)
    raise TypeError(f"robot must be a name, a folder or a RobotDefinition, got {quoted(robot)}")


class StoredRobot(NamedTuple):
    """A folder with a robot, whether it is shipped, and whether its name leads to it."""

    name: str
    folder: Path
    is_shipped: bool
    is_found: bool  # no other one of this name takes precedence
    is_default: bool


def stored_robots(default: str | None) -> list[StoredRobot]:
    """Return the shipped robots, then the user's; `default` is the one in use."""
    chosen = None if default is None else find_folder(default)
    return [
        StoredRobot(name, folder, is_shipped, folder == find_folder(name), folder == chosen)
        for is_shipped, robots in ((True, shipped_robots()), (False, user_robots()))
        for name, folder in robots.items()
    ]
