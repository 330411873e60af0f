"""The set-up of a session as TOML: world, robot and software of a run."""

from __future__ import annotations

import datetime
import platform
from collections.abc import Mapping
from functools import partial
from types import SimpleNamespace
from typing import Any

import numpy as np

from robsim._core import ColorClass, MarkerLayout, PlaneMap, RobotModel
from robsim.base.checks import check_float, check_mm_per_px, check_size, check_text
from robsim.base.files import codec, parse_toml
from robsim.base.text import quoted
from robsim.vision.imaging.calibration_file import PLANE_MAP
from robsim.vision.markers.color_files import COLOR
from robsim.vision.robots.files import LAYOUT

FORMAT = 3
_KINDS = (str, bool, int, float, list, dict, datetime.datetime)
_PACKAGES = ("robsim", "numpy", "pillow", "av", "mcap", "opencv-python-headless", "opencv-python")
_LARGEST_INT = 2**63  # of TOML


def setup_text(setup: Mapping[str, Any], *, kind: str) -> str:
    """Return the text of a set-up, with format, date and versions.

    TypeError, ValueError: a value cannot be written, or the text is too long for `read_setup`.
    """
    import tomlkit

    now = datetime.datetime.now(datetime.UTC)
    table = {
        "format": FORMAT,
        "started": now.replace(microsecond=now.microsecond // 1000 * 1000),
        "pictures": kind,
        **setup,
        "versions": {"python": platform.python_version(), **_versions()},
    }
    written = tomlkit.dumps(_as_toml("setup", table))
    try:
        parse_toml(written)
    except ValueError as error:
        raise ValueError(f"setup cannot be written: {error}") from error
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
    """Return a value for TOML; None values are omitted from its table."""
    if isinstance(value, Mapping):
        items = {str(key): _as_toml(f"{name}.{key}", item) for key, item in value.items()}
        # Plain values stand before the tables, or they would be a part of the last one.
        order = sorted(items, key=lambda key: isinstance(items[key], dict))
        return {key: items[key] for key in order if items[key] is not None}
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
    if value is None or isinstance(value, _KINDS):
        return value
    raise TypeError(f"{name} must be numbers, texts, lists and tables, got {quoted(value)}")


class Setup(SimpleNamespace):
    """A run's set-up, from its text in a session; ValueError names source and key."""

    def __init__(self, text: str, source: object, expected: int) -> None:
        super().__init__(**codec.read_table(text, partial(_values, expected), source))


def _values(expected: int, table: dict[str, Any]) -> dict[str, Any]:
    codec.check_format(table, expected)
    given = dict(table)
    if isinstance(matrix := given.get("plane_map"), list):
        given["plane_map"] = {"matrix": matrix}
    read: dict[str, Any] = _SETUP.read("setup", given)
    return dict.fromkeys(_SETUP.keys) | {"robot": "", "table": table} | read


def _input(name: str, value: Any) -> tuple[float, float]:
    if not isinstance(value, list) or len(value) != 2:
        raise ValueError(f"{name} must be two voltages, got {codec.in_words(value)}")
    left, right = (check_float(name, one, "V") for one in value)
    return left, right


_TABLES: dict[type, codec.Table] = {
    PlaneMap: PLANE_MAP,
    MarkerLayout: LAYOUT,
    RobotModel: codec.Table(RobotModel.from_theta, {"dt": "s", "theta": ""}, needed=("dt",)),
    ColorClass: codec.Table(ColorClass, {"name": check_text, **COLOR.keys}, needed=(*COLOR.keys,)),
}
_SETUP = codec.Table(
    codec.together,
    {
        "area": check_size,
        "dt": partial(check_float, exclusive_minimum=0, maximum=1e6),
        "plane_map": PLANE_MAP,
        "mm_per_px": lambda _, value: check_mm_per_px(value),
        "stop_input": _input,
        "colors": codec.listed(_TABLES[ColorClass]),
        "markers": LAYOUT,
        "model": _TABLES[RobotModel],
        "robot": check_text,
        "started": codec.date,
    },
    ignores_others=True,
)
