"""The default robot and the settings file that stores the choice; `load_robot()` reads it."""

from __future__ import annotations

import os
from functools import lru_cache
from pathlib import Path
from secrets import token_hex
from typing import Any

from robsim.base.files import naming, read_text, read_toml, write_whole
from robsim.base.files.reading import MOST_TOML
from robsim.base.text import cut, one_line, quoted
from robsim.base.values import FileVersion

#: The default robot until the user chooses another.
DEFAULT = "lab"

_RESET = f"`robsim robots reset` goes back to {DEFAULT!r}"


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
    """
    file = settings_file()
    try:
        name = _stored_name(FileVersion.of(file))
    except FileNotFoundError:
        return DEFAULT
    except (ValueError, OSError) as error:
        raise ValueError(f"settings file {one_line(file)}: {cut(error)}; {_RESET}") from error
    if not isinstance(name, str):
        raise ValueError(
            f"settings file {one_line(file)}: robot must be the name of a robot, got "
            f"{quoted(name)}; {_RESET}"
        )
    return name


@lru_cache(maxsize=1)
def _stored_name(file: FileVersion) -> Any:
    return read_toml(file.path).get("robot", DEFAULT)


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
        read_toml(file)  # within limits, and more strictly than tomlkit
        settings = tomlkit.parse(read_text(file, MOST_TOML))
    except FileNotFoundError:
        with naming(file.parent):
            file.parent.mkdir(parents=True, exist_ok=True)
    except ValueError as error:
        raise ValueError(f"settings file {one_line(file)}: {cut(error)}; {_RESET}") from error
    except OSError as error:
        raise ValueError(f"settings file {one_line(file)}: {error.strerror}; {_RESET}") from error
    settings["robot"] = name
    write_whole(file, tomlkit.dumps(settings).encode())


def reset_default_robot() -> None:
    """Make ``lab`` the default robot again; a damaged settings file is renamed, not deleted."""
    file = settings_file()
    if not file.exists():
        return
    try:
        store_default_robot(DEFAULT)
    except ValueError:
        file.replace(file.with_name(f"settings-damaged-{token_hex(4)}.toml"))
