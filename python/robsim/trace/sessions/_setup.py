"""The set-up of a session: what a run was made with, as a TOML file."""

from __future__ import annotations

import datetime
import platform
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

from robsim._core import ColorClass, MarkerLayout, PlaneMap, RobotModel, fitting_roles
from robsim.base.checks import check_float, check_mm_per_px, check_size
from robsim.base.files import codec, parse_toml
from robsim.base.text import quoted
from robsim.vision.imaging.calibration_file import PLANE_MAP
from robsim.vision.markers.color_files import COLOR
from robsim.vision.robots.files import LAYOUT

FORMAT = 2
_READABLE = (1, 2)
_KINDS = (str, bool, int, float, list, dict, datetime.datetime)
_PACKAGES = ("robsim", "numpy", "pillow", "opencv-python-headless", "opencv-python")
_LARGEST_INT = 2**63  # of TOML
_OLD_NAMES = ("red", "blue")  # of the markers in format 1, whatever their colours


def setup_text(setup: Mapping[str, Any], *, kind: str, fps: float | None) -> str:
    """Return the file of a set-up, with format, date and versions.

    TypeError, ValueError: a value cannot be written, or all are too much for `read_setup`.
    """
    import tomlkit

    now = datetime.datetime.now(datetime.UTC)
    table = {
        "format": FORMAT,
        "started": now.replace(microsecond=now.microsecond // 1000 * 1000),
        "pictures": kind,
        "fps": fps,
        **setup,
        "versions": {"python": platform.python_version(), **_versions()},
    }
    written = tomlkit.dumps(_as_toml("setup", table))
    try:
        parse_toml(written)
    except ValueError as error:
        raise ValueError(f"setup cannot be written as a file: {error}") from error
    return written


def _versions() -> dict[str, str]:
    from importlib import metadata  # takes 10 ms

    found = {}
    for package in _PACKAGES:
        try:
            found[package] = metadata.version(package)
        except metadata.PackageNotFoundError:
            continue
    return found


def _as_toml(name: str, value: Any) -> Any:
    """Return a value as TOML has it; what is None is left out of its table."""
    if isinstance(value, Mapping):
        items = {str(key): _as_toml(f"{name}.{key}", item) for key, item in value.items()}
        # Plain values stand before the tables, or they would be a part of the last one.
        tables = {key: item for key, item in items.items() if isinstance(item, dict)}
        plain = {key: item for key, item in items.items() if key not in tables}
        return {key: item for key, item in (plain | tables).items() if item is not None}
    if isinstance(value, PlaneMap) and value.intrinsics is None:
        return value.matrix.tolist()
    if (table := _TABLES.get(type(value))) is not None:
        return table.write(value).unwrap()
    if isinstance(value, (np.ndarray, np.generic)):
        return value.tolist()
    if isinstance(value, (list, tuple)):
        return [_as_toml(name, item) for item in value]
    if isinstance(value, int) and not -_LARGEST_INT <= value < _LARGEST_INT:
        return str(value)
    if isinstance(value, str) and "\n" in value:
        return _lines(value)
    if value is None or isinstance(value, _KINDS):
        return value
    raise TypeError(f"{name} must be numbers, texts, lists and tables, got {quoted(value)}")


def _lines(lines: str) -> Any:
    """Return a text of lines so that it can be read in the file, if TOML can hold it so."""
    import tomlkit

    is_safe = "'''" not in lines and all(c in "\n\t" or c.isprintable() for c in lines)
    if is_safe and not lines.endswith("'"):
        for start in ("", "\n"):  # some versions of tomlkit add a line break, which TOML ignores
            item = tomlkit.string(start + lines, literal=True, multiline=True)
            if parse_toml(f"text = {item.as_string()}") == {"text": lines}:
                return item
    return lines


class Setup(SimpleNamespace):
    """A run's set-up, from its session's ``setup.toml``; ValueError names file and key."""

    def __init__(self, file: Path) -> None:
        super().__init__(**codec.load_table(file, _values))


def _values(table: dict[str, Any]) -> dict[str, Any]:
    codec.check_format(table, *_READABLE)
    given = {key: codec.read_key(key, _KEYS[key], table[key]) for key in _KEYS if key in table}
    return dict.fromkeys(_KEYS) | {"robot": "", "table": table} | given


def _dt(name: str, value: Any) -> float:
    return check_float(name, value, "s", exclusive_minimum=0, maximum=1e6)


def _plane_map(name: str, value: Any) -> PlaneMap:
    if isinstance(value, dict):
        return PLANE_MAP.read(name, value)  # type: ignore[no-any-return]
    return PlaneMap(codec.array(3, 3)(name, value))


def _input(name: str, value: Any) -> tuple[float, float]:
    left, right = codec.array(2)(name, value).tolist()
    return left, right


def _colors(name: str, value: Any) -> list[ColorClass]:
    return codec.listed_tables(name, value, _TABLES[ColorClass].read)


def _markers(name: str, value: Any) -> MarkerLayout:
    table = codec.as_table(name, value)
    if table.keys() >= {*_OLD_NAMES}:
        table = _tables_of_format_1(table)
    return LAYOUT.read(name, table)  # type: ignore[no-any-return]


def _tables_of_format_1(table: dict[str, Any]) -> dict[str, Any]:
    """Return the table of a layout as it is written today: the roles follow from the places."""
    roles = fitting_roles(*(codec.array(2)(old, table[old]) for old in _OLD_NAMES))
    colors = table.get("colors", _OLD_NAMES)
    if not isinstance(colors, (list, tuple)) or len(colors) != len(_OLD_NAMES):
        raise ValueError(f"colors must be two names, got {quoted(colors)}")
    tables = {key: table[key] for key in LAYOUT.keys if key in table}
    for role, old, color in zip(roles, _OLD_NAMES, colors, strict=True):
        marker = {"color": color, "position": table[old]}
        marker |= {key: table.get(f"{old}_{key}") for key in ("area", "polygon")}
        tables[role] = {k: one for k, one in marker.items() if one is not None and one == one}
    return tables


_TABLES: dict[type, codec.Table] = {
    PlaneMap: PLANE_MAP,
    MarkerLayout: LAYOUT,
    RobotModel: codec.Table(
        RobotModel.from_theta,
        {
            "dt": codec.Entry(_dt, is_needed=True),
            "theta": codec.Entry(codec.array(3, 5), is_needed=True),
        },
    ),
    ColorClass: codec.Table(
        ColorClass,
        {"name": codec.Entry(codec.text, is_needed=True)}
        | {channel: replace(key, is_needed=True) for channel, key in COLOR.keys.items()},
    ),
}
_KEYS: dict[str, codec.Read] = {
    "area": check_size,
    "dt": _dt,
    "plane_map": _plane_map,
    "mm_per_px": lambda _, value: check_mm_per_px(value),
    "stop_input": _input,
    "colors": _colors,
    "markers": _markers,
    "model": _TABLES[RobotModel].read,
    "robot": codec.text,
    "started": codec.date,
}
