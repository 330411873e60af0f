"""Files that ship with the package, and their like."""

import tomllib
from os import PathLike
from pathlib import Path
from typing import Any

#: Folder of the shipped pictures, robot definitions and colours.
ASSETS = Path(__file__).with_name("assets")


def read_toml(path: str | PathLike[str]) -> dict[str, Any]:
    """Read a TOML file, with or without a byte order mark.

    Parameters
    ----------
    path : path
        The file.

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    ValueError
        If it is not TOML; the message names it.
    """
    content = Path(path).read_bytes()
    try:
        return tomllib.loads(content.decode("utf-8-sig"))
    except (ValueError, RecursionError) as error:
        raise ValueError(f"{path} is not a TOML file: {error}") from error
