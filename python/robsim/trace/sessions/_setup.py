"""The set-up of a session: what a run was made with, as a TOML file."""

from __future__ import annotations

import datetime
import math
import platform
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from robsim._core import ColorClass, Intrinsics, MarkerLayout, PlaneMap, RobotModel, fitting_roles
from robsim.base.checks import as_float_array, check_float, check_mm_per_px, check_size
from robsim.base.files import parse_toml, read_toml
from robsim.base.text import one_line, quoted
from robsim.vision.robots.marker_roles import given_by_role, taken_roles

FORMAT = 2
_READABLE = (1, 2)
_KINDS = (str, bool, int, float, list, dict, datetime.datetime)
_PACKAGES = ("robsim", "numpy", "pillow", "opencv-python-headless", "opencv-python")
_LARGEST_INT = 2**63  # of TOML
_LAYOUT_KEYS = ("distance_tolerance", "area_tolerance", "maximum_blobs")
# The keys of a marker's table, and what of the layout they are.
_MARKER_KEYS = {
    "color": "colors",
    "position": "positions",
    "area": "areas",
    "polygon": "polygons",
}
_OLD_NAMES = ("red", "blue")  # of the markers in format 1, whatever their colours


def setup_text(setup: Mapping[str, Any], *, kind: str, fps: float | None) -> str:
    """Return the file of a set-up, with format, date and versions.

    Raises
    ------
    TypeError, ValueError
        If a value cannot be written, or all together are too much for `read_setup`.
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
    text = tomlkit.dumps(_as_toml("setup", table))
    try:
        parse_toml(text)
    except ValueError as error:
        raise ValueError(f"setup cannot be written as a file: {error}") from error
    return text


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
    if isinstance(value, PlaneMap):
        return _plane_map_as_toml(value)
    if isinstance(value, RobotModel):
        return {"dt": value.dt, "theta": value.theta.tolist()}
    if isinstance(value, ColorClass):
        return {"name": value.name, **{c: list(getattr(value, c)) for c in "yuv"}}
    if isinstance(value, MarkerLayout):
        return _as_toml(name, _layout_as_tables(value))
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


def _layout_as_tables(markers: MarkerLayout) -> dict[str, Any]:
    """Return a layout as a table for each role; what is not known is left out."""
    given = {key: getattr(markers, of) for key, of in _MARKER_KEYS.items()}
    tables: dict[str, Any] = {key: getattr(markers, key) for key in _LAYOUT_KEYS}
    for role in markers.roles:
        values = {key: by_role[role] for key, by_role in given.items() if by_role is not None}
        tables[role] = {key: value for key, value in values.items() if not _is_nan(value)}
    return tables


def _is_nan(value: Any) -> bool:
    return isinstance(value, float) and math.isnan(value)


def _plane_map_as_toml(plane_map: PlaneMap) -> Any:
    """Return a homography as its rows; with a lens, as a table of both."""
    lens = plane_map.intrinsics
    matrix = plane_map.matrix.tolist()
    if lens is None:
        return matrix
    camera = {"matrix": lens.matrix.tolist(), "distortion": lens.distortion.tolist()}
    return {"matrix": matrix, "intrinsics": camera}


def _lines(text: str) -> Any:
    """Return a text of lines so that it can be read in the file, if TOML can hold it so."""
    import tomlkit

    is_safe = "'''" not in text and all(c in "\n\t" or c.isprintable() for c in text)
    if is_safe and not text.endswith("'"):
        for start in ("", "\n"):  # some versions of tomlkit add a line break, which TOML ignores
            item = tomlkit.string(start + text, literal=True, multiline=True)
            if parse_toml(f"text = {item.as_string()}") == {"text": text}:
                return item
    return text


class Setup:
    """What a run was made with, read from its file.

    Parameters
    ----------
    file : Path
        The file ``setup.toml`` of a session.

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    ValueError
        If it is damaged; the message names file and key.
    """

    def __init__(self, file: Path) -> None:
        self.table = read_toml(file)
        try:
            if self.table.get("format") not in _READABLE:
                raise ValueError(
                    f"format must be 1 or {FORMAT}, got {quoted(self.table.get('format'))}"
                )
            self.area = self._read("area", _size)
            self.dt = self._read("dt", _dt)
            self.plane_map = self._read("plane_map", _plane_map)
            self.mm_per_px = self._read("mm_per_px", lambda _, value: check_mm_per_px(value))
            self.stop_input = self._read("stop_input", _input)
            self.colors = self._read("colors", _colors)
            self.markers = self._read("markers", _markers)
            self.model = self._read("model", _model)
            self.robot = self._read("robot", _text) or ""
            self.started = self._read("started", _date)
        except (TypeError, ValueError) as error:
            raise ValueError(f"{one_line(file)}: {error}") from error

    def _read(self, key: str, read: Any) -> Any:
        value = self.table.get(key)
        return None if value is None else read(key, value)


def _size(name: str, value: Any) -> tuple[int, int]:
    return check_size(name, value)


def _dt(name: str, value: Any) -> float:
    return check_float(name, value, "s", exclusive_minimum=0, maximum=1e6)


def _numbers(name: str, value: Any, shape: tuple[int, ...]) -> Any:
    array = as_float_array(name, value)
    if array.shape != shape or not np.isfinite(array).all():
        size = " x ".join(map(str, shape))
        raise ValueError(f"{name} must be {size} finite numbers, got {quoted(value)}")
    return array


def _plane_map(name: str, value: Any) -> PlaneMap:
    if not isinstance(value, dict):
        return PlaneMap(_numbers(name, value, (3, 3)))
    matrix = _part(name, value, "matrix", (3, 3))
    camera, place = value.get("intrinsics"), f"{name}.intrinsics"
    if not isinstance(camera, dict):
        raise TypeError(f"{place} must be a table, got {quoted(camera)}")
    numbers = _part(place, camera, "matrix", (3, 3)), _part(place, camera, "distortion", (5,))
    try:
        return PlaneMap(matrix, Intrinsics(*numbers))
    except ValueError as error:
        raise ValueError(f"{name}: {error}") from error


def _part(name: str, table: dict[str, Any], key: str, shape: tuple[int, ...]) -> Any:
    return _numbers(f"{name}.{key}", table.get(key), shape)


def _input(name: str, value: Any) -> tuple[float, float]:
    left, right = _numbers(name, value, (2,)).tolist()
    return left, right


def _text(name: str, value: Any) -> str:
    if not isinstance(value, str):
        raise TypeError(f"{name} must be a text, got {quoted(value)}")
    return value


def _date(name: str, value: Any) -> datetime.datetime:
    if not isinstance(value, datetime.datetime) or value.tzinfo is None:
        raise TypeError(f"{name} must be a time with its zone, got {quoted(value)}")
    return value


def _table(name: str, value: Any, *needed: str) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise TypeError(f"{name} must be a table, got {quoted(value)}")
    for key in needed:
        if key not in value:
            raise ValueError(f"{name} must have {key}")
    return value


def _colors(name: str, value: Any) -> list[ColorClass]:
    if not isinstance(value, list) or len(value) > 1000:
        raise TypeError(f"{name} must be a list of tables, got {quoted(value)}")
    colors = []
    for table in value:
        _table(name, table, "name", "y", "u", "v")
        try:
            ranges = {channel: tuple(table[channel]) for channel in "yuv"}
            colors.append(ColorClass(table["name"], **ranges))
        except (TypeError, ValueError) as error:
            raise ValueError(f"{name}: {one_line(error)}") from error
    return colors


def _markers(name: str, value: Any) -> MarkerLayout:
    table = dict(_table(name, value))
    if table.keys() >= {*_OLD_NAMES}:
        table = _tables_of_format_1(name, table)
    options: dict[str, Any] = {key: table[key] for key in _LAYOUT_KEYS if key in table}
    try:
        by_role: dict[str, Any] = given_by_role(name, taken_roles(table), _MARKER_KEYS)
        if "positions" not in by_role:
            raise ValueError("its markers must have positions")
        return MarkerLayout.from_positions(**options, **by_role)
    except (TypeError, ValueError) as error:
        raise ValueError(f"{name}: {one_line(error)}") from error


def _tables_of_format_1(name: str, table: dict[str, Any]) -> dict[str, Any]:
    """Return the table of a layout as it is written today: the roles follow from the places."""
    roles = fitting_roles(*(_numbers(f"{name}.{old}", table[old], (2,)) for old in _OLD_NAMES))
    colors = table.get("colors", _OLD_NAMES)
    if not isinstance(colors, (list, tuple)) or len(colors) != len(_OLD_NAMES):
        raise ValueError(f"{name}.colors must be two names, got {quoted(colors)}")
    tables = {key: table[key] for key in _LAYOUT_KEYS if key in table}
    for role, old, color in zip(roles, _OLD_NAMES, colors, strict=True):
        marker = {"color": color, "position": table[old]}
        marker |= {key: table.get(f"{old}_{key}") for key in ("area", "polygon")}
        known = {key: one for key, one in marker.items() if one is not None and not _is_nan(one)}
        tables[role] = known
    return tables


def _model(name: str, value: Any) -> RobotModel:
    table = _table(name, value, "dt", "theta")
    theta = _numbers(f"{name}.theta", table["theta"], (3, 5))
    return RobotModel.from_theta(theta, dt=_dt(f"{name}.dt", table["dt"]))
