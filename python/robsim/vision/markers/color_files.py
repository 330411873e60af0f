"""Reading and writing colour classes as TOML files, for `Simulation`, the robots and the CLI."""

from __future__ import annotations

from collections.abc import Iterable
from functools import lru_cache
from os import PathLike
from pathlib import Path
from typing import Any

from robsim._core import ColorClass
from robsim.base.checks import check_text
from robsim.base.files import as_path, codec, parse_toml, read_text, write_whole
from robsim.base.shipped import ASSETS
from robsim.base.text import listed, quoted
from robsim.base.values import FileVersion

#: The colour file that ships with robsim.
SHIPPED_COLORS = ASSETS / "colors.toml"
_MOST_COLORS = 1000  # of a file
_HEADER = """\
# Colour classes: ranges of Y (brightness), U and V, both limits included. U = V = 128 is grey;
# a larger U is bluer, a larger V is redder. `robsim colors list FILE` shows them.

"""


def _range(name: str, value: Any) -> list[int]:
    if not isinstance(value, list) or not all(type(one) is int for one in value):
        raise TypeError(f"{name} must be [lower, upper], two whole numbers, got {quoted(value)}")
    return value


#: A colour class without its name.
COLOR = codec.Table(codec.together, dict.fromkeys("yuv", _range))


def _color(name: str, value: Any) -> ColorClass:
    return ColorClass(name, **COLOR.read(name, value))


_BY_NAME = codec.named(codec.Entry("", _color, COLOR.write), " such as [colors.red]")
#: Colour classes in tables by their names.
COLORS = codec.Entry(
    "",
    lambda name, value: (*_BY_NAME.read(name, value).values(),),
    lambda colors: _BY_NAME.write({color.name: color for color in colors}),
)


def load_colors(path: str | PathLike[str] | None = None) -> tuple[ColorClass, ...]:
    """Read colour classes from a TOML file.

    Each colour is a table with ranges of Y, U and V, both limits included; a missing range means
    0..255::

        [red]
        u = [0, 120]
        v = [164, 255]

    Parameters
    ----------
    path : path, optional
        The file. Default: the file shipped with robsim, with red and blue.

    Returns
    -------
    tuple of ColorClass
        In the order of the file.

    Raises
    ------
    FileNotFoundError
        If the file does not exist.
    ValueError
        If the file is not TOML, or not a colour file; the message names the file and the table.

    Examples
    --------
    >>> [color.name for color in robsim.load_colors()]
    ['red', 'blue']
    """
    return _shipped_colors(FileVersion.of(SHIPPED_COLORS)) if path is None else _read(as_path(path))


@lru_cache(maxsize=1)
def _shipped_colors(file: FileVersion) -> tuple[ColorClass, ...]:
    return _read(Path(file.path))


def _read(path: Path) -> tuple[ColorClass, ...]:
    return codec.load_table(path, _colors_of, "colour file ")  # type: ignore[no-any-return]


def colors_of_text(text: str) -> tuple[ColorClass, ...]:
    return _colors_of(parse_toml(text))


def _colors_of(tables: dict[str, Any]) -> tuple[ColorClass, ...]:
    if not tables:
        raise ValueError("it has no colours; expected tables such as [red]")
    _check_count(len(tables))
    return COLORS.read("", tables)  # type: ignore[no-any-return]


def _check_count(count: int) -> None:
    if count > _MOST_COLORS:
        raise ValueError(f"a colour file must have at most {_MOST_COLORS} colours, got {count}")


def colors_to_toml(colors: ColorClass | Iterable[ColorClass]) -> str:
    """Return colour classes as text in the format of a colour file.

    Parameters
    ----------
    colors : ColorClass or iterable of ColorClass
        The colours.

    Returns
    -------
    str
        A TOML table for each colour.

    Examples
    --------
    >>> print(robsim.vision.colors_to_toml(robsim.load_colors()[0]))
    [red]
    y = [0, 255]
    u = [0, 150]
    v = [154, 255]
    """
    return str(COLORS.write(_classes(colors)).as_string())


def save_colors(
    path: str | PathLike[str],
    colors: ColorClass | Iterable[ColorClass],
    *,
    remove: Iterable[str] = (),
) -> None:
    """Write colour classes to a colour file.

    An existing file keeps its comments and its other colours; colours with the same name get the
    new ranges.

    Parameters
    ----------
    path : path
        The file; created, with its folder, if needed.
    colors : ColorClass or iterable of ColorClass
        The colours.
    remove : iterable of str
        Names of other colours to remove from an existing file.

    Raises
    ------
    TypeError
        If an argument has the wrong type.
    ValueError
        If the existing file is not a colour file (it is left unchanged), if `colors` is empty, or
        if two colours have the same name.

    Examples
    --------
    >>> robsim.vision.save_colors("mine.toml", robsim.load_colors()[0])
    >>> [color.name for color in robsim.load_colors("mine.toml")]
    ['red']
    """
    path, classes, without = as_path(path), _classes(colors), _names("remove", remove)
    if not classes:
        raise ValueError("colors must have at least one ColorClass, got none")
    if path.exists():
        old = load_colors(path)
        _check_count(len({color.name for color in (*old, *classes)}))
        without -= {color.name for color in classes}
        text = _updated(read_text(path), classes, without)
    else:
        _check_count(len(classes))
        text = _HEADER + colors_to_toml(classes)
    path.parent.mkdir(parents=True, exist_ok=True)
    write_whole(path, text.encode())


def _names(argument: str, names: Any) -> set[str]:
    if isinstance(names, (str, bytes, dict)) or not isinstance(names, Iterable):
        raise TypeError(f"{argument} must be an iterable of names, got {quoted(names)}")
    return {check_text(argument, name) for name in names}


def _updated(text: str, colors: Iterable[ColorClass], without: set[str]) -> str:
    """Return the text of a colour file with the ranges of these colours replaced or added."""
    import tomlkit

    document = tomlkit.parse(text)
    for name in without & set(document):
        del document[name]
    added = []
    for color in colors:
        if color.name not in document:
            added.append(color)
            continue
        table: Any = document[color.name]
        for channel in COLOR.keys:
            value = list(getattr(color, channel))
            if table.get(channel, [0, 255]) != value:
                table[channel] = value
    kept = document.as_string()
    return f"{kept.rstrip()}\n\n{colors_to_toml(added)}" if added else kept


def _classes(colors: ColorClass | Iterable[ColorClass]) -> tuple[ColorClass, ...]:
    """Return colour classes as a tuple; raise ValueError if two have the same name."""
    if isinstance(colors, ColorClass):
        return (colors,)
    if colors is None or isinstance(colors, (str, PathLike)):
        raise TypeError(f"colors must be ColorClass objects, got {quoted(colors)}")
    classes = as_colors(colors)
    if len({color.name for color in classes}) < len(classes):
        names = listed(color.name for color in classes)
        raise ValueError(f"colors must have different names, got {names}")
    return classes


def as_colors(colors: str | PathLike[str] | Iterable[ColorClass] | None) -> tuple[ColorClass, ...]:
    """Return colour classes as a tuple, from a file for a path; None = the shipped ones."""
    if colors is None or isinstance(colors, (str, PathLike)):
        return load_colors(colors)
    if not isinstance(colors, Iterable):
        raise TypeError(f"colors must be ColorClass objects or a file, got {quoted(colors)}")
    result = tuple(colors)
    wrong = [color for color in result if not isinstance(color, ColorClass)]
    if wrong:
        raise TypeError(f"colors must be ColorClass objects or a file, got {quoted(wrong[0])}")
    return result
