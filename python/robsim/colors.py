"""Colour classes from TOML files."""

from __future__ import annotations

from collections.abc import Iterable
from os import PathLike
from pathlib import Path
from typing import Any

from robsim._core import ColorClass
from robsim.files import read_toml
from robsim.shipped import ASSETS

_CHANNELS = ("y", "u", "v")


def load_colors(path: str | PathLike[str] | None = None) -> tuple[ColorClass, ...]:
    """Read colour classes from a TOML file.

    A table for each colour has the ranges of Y, U and V, ends included; a missing one means any
    value::

        [red]
        u = [0, 120]
        v = [164, 255]

    Parameters
    ----------
    path : path, optional
        The file. Default: the one that ships with robsim, with red and blue.

    Returns
    -------
    tuple of ColorClass
        In the order of the file.

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    ValueError
        If it is not TOML, or not a colour file; the message says where.
    """
    path = ASSETS / "colors.toml" if path is None else Path(path)
    tables = read_toml(path)
    try:
        if not tables:
            raise ValueError("it has no colours, expected tables such as [red]")
        return tuple(_color(name, table) for name, table in tables.items())
    except ValueError as error:
        raise ValueError(f"colour file {path}: {error}") from error


def _color(name: str, table: Any) -> ColorClass:
    if not isinstance(table, dict):
        raise ValueError(f"[{name}] must be a table with y, u and v, got {table!r}")
    unknown = set(table) - set(_CHANNELS)
    if unknown:
        raise ValueError(f"[{name}] must have y, u and v only, got {', '.join(sorted(unknown))}")
    return ColorClass(name, **{channel: _range(name, channel, table[channel]) for channel in table})


def _range(name: str, channel: str, value: Any) -> tuple[int, int]:
    numbers = value if isinstance(value, list) else []
    if len(numbers) != 2 or not all(type(number) is int for number in numbers):
        raise ValueError(f"{channel} of [{name}] must be [lower, upper], two ints, got {value!r}")
    if not all(0 <= number <= 255 for number in numbers):
        raise ValueError(f"{channel} of [{name}] must lie within 0..255, got {value!r}")
    return numbers[0], numbers[1]


def as_colors(
    colors: str | PathLike[str] | Iterable[ColorClass] | None,
) -> tuple[ColorClass, ...]:
    """Return colour classes, from a file if a path came; None = the shipped ones.

    Parameters
    ----------
    colors : path, iterable of ColorClass, or None
        The colours.

    Raises
    ------
    TypeError
        If something else came.
    """
    if colors is None or isinstance(colors, (str, PathLike)):
        return load_colors(colors)
    if not isinstance(colors, Iterable):
        raise TypeError(f"colors must be ColorClass objects or a file, got {colors!r}")
    result = tuple(colors)
    wrong = [color for color in result if not isinstance(color, ColorClass)]
    if wrong:
        raise TypeError(f"colors must be ColorClass objects or a file, got {wrong[0]!r}")
    return result
