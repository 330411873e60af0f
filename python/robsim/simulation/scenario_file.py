"""Scenarios as TOML text: complete, exact, and safe to read from a stranger."""

from __future__ import annotations

import base64
import datetime
import io
from collections.abc import Callable, Iterable
from dataclasses import dataclass, fields
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from PIL import Image

from robsim._core import (
    ColorClass,
    DriveAround,
    MarkerLayout,
    Replay,
    RobotModel,
    RobotParameters,
    Spin,
    Unicycle,
)
from robsim.base.checks import check_choice, check_float, check_int
from robsim.base.files import parse_toml
from robsim.base.seeds import SeedRecord
from robsim.base.spelling import check_names
from robsim.base.text import cut, one_line, quoted
from robsim.simulation.options import OPTIONS, background_value
from robsim.simulation.world.disturbances import Dropout, ParameterMismatch, PoseNoise, WheelNoise
from robsim.simulation.world.scene import Floor
from robsim.vision.imaging.images import Pixels, png_bytes
from robsim.vision.imaging.noise import GaussianNoise, UniformNoise
from robsim.vision.robots.definition import BlobMarker, RobotDefinition, markers_of_tables
from robsim.vision.robots.lookup import as_robot, robot_names, shipped_robots
from robsim.vision.robots.marker_roles import given_by_role, taken_roles

if TYPE_CHECKING:
    from tomlkit.items import Item

    from robsim.simulation.scenario import Scenario

MOST_BYTES = 64 * 2**20  # of a file
MOST_PIXELS = 25_000_000  # of an image
_MOST_ROWS = 10_000  # of an array that is not in base64, such as a polygon
_FORMAT = 1
_HEADER = "A simulated world and a run of robsim: read it with robsim.Scenario.load."
_CONTINUOUS = "continuous"  # TOML has no None


@dataclass(frozen=True)
class _Key:
    """A key of a table: how its value is read and written, and its unit."""

    read: Callable[[str, Any], Any]
    unit: str = ""
    write: Callable[[Any], Any] = lambda value: value
    is_needed: bool = False


def _number(unit: str = "") -> _Key:
    return _Key(_float, unit)


def _array(unit: str = "", *, is_needed: bool = False) -> _Key:
    return _Key(_list, unit, is_needed=is_needed)


def _float(name: str, value: Any) -> float:
    return check_float(name, _of_type(name, value, "a number", int, float))


def _count(name: str, value: Any) -> int:
    number = _of_type(name, value, "a whole number", int)
    return check_int(name, number, minimum=0, maximum=2**31 - 1)


_COUNT = _Key(_count)


def _list(name: str, value: Any) -> Any:
    if isinstance(value, list) and len(value) > _MOST_ROWS:
        raise ValueError(f"{name} must have at most {_MOST_ROWS} rows, got {len(value)}")
    return _of_type(name, value, "numbers", list, int, float)


def _text(name: str, value: Any) -> str:
    text: str = _of_type(name, value, "a text", str)
    return text


def _of_type(name: str, value: Any, expected: str, *types: type) -> Any:
    """Return a value of TOML if it has one of these types; in TOML, true is no number."""
    if type(value) in types:
        return value
    raise TypeError(f"{name} must be {expected}, got {_as_toml(value)}")


def _as_toml(value: Any) -> str:
    """Return what a value of TOML is, in its words."""
    if isinstance(value, (datetime.date, datetime.time)):
        return f"the time {value.isoformat()}"
    if isinstance(value, dict):
        return "a table"
    if isinstance(value, bool):
        return str(value).lower()
    return quoted(value)


def _bytes(name: str, value: Any) -> bytes:
    try:
        return base64.b64decode("".join(_text(name, value).split()), validate=True)
    except ValueError as error:
        raise ValueError(f"{name} must be base64: {error}") from error


def _inputs(name: str, value: Any) -> Any:
    data = _bytes(name, value)
    if len(data) % 16:
        raise ValueError(f"{name} must be pairs of float64, 16 bytes a step, got {len(data)} bytes")
    return np.frombuffer(data, "<f8").reshape(-1, 2)


def _image(name: str, value: Any) -> Pixels:
    data = _bytes(name, value)
    try:
        with Image.open(io.BytesIO(data), formats=("PNG",)) as image:
            if image.width * image.height <= MOST_PIXELS and image.mode in ("RGB", "RGBA"):
                return np.array(image)
            got = f"{image.mode} of {image.width} x {image.height} px"
    except Exception as error:  # Pillow's decoders raise many types
        raise ValueError(f"{name} must be a PNG image in base64: {cut(error)}") from error
    raise ValueError(f"{name} must be RGB or RGBA of at most {MOST_PIXELS} px, got {got}")


def _numbers_tuple(name: str, value: Any) -> Any:
    return tuple(value) if isinstance(value, list) else value


def _png(pixels: Pixels) -> bytes:
    height, width = pixels.shape[:2]
    if height * width > MOST_PIXELS:
        raise ValueError(f"an image must have at most {MOST_PIXELS} px, got {width} x {height}")
    return png_bytes(pixels)


_IMAGE = _Key(_image, "PNG in base64", _png, is_needed=True)

# The values that are tables, and their keys. They are written and made by these names.
_TABLES: dict[type, dict[str, _Key]] = {
    GaussianNoise: {"percent": _number("%")},
    UniformNoise: {"percent": _number("%")},
    Dropout: {"probability": _number(), "steps": _COUNT},
    PoseNoise: {"covariance": _array("px^2, px rad, rad^2, a step")},
    WheelNoise: {"sigma": _array("V")},
    ParameterMismatch: {"sigma": _number("relative")},
    Floor: {"pixels": _IMAGE},
    SeedRecord: {"entropy": _Key(_numbers_tuple), "spawn_key": _Key(_numbers_tuple)},
    MarkerLayout: {
        "distance_tolerance": _number("fraction"),
        "area_tolerance": _number("ratio"),
        "maximum_blobs": _COUNT,
    },
    RobotModel: {
        "theta": _array("rows X, Y, P; columns a1, a2, b1, b2, d1", is_needed=True),
        "dt": _number("s"),
    },
    RobotParameters: {
        "mass": _number("kg"),
        "inertia": _number("kg m^2"),
        "linear_friction": _number("N s/m"),
        "angular_friction": _number("N m s/rad"),
        "wheel_radius": _number("m"),
        "wheel_base": _number("m"),
        "motor_gain": _array("N m/V"),
        "motor_offset": _array("N m"),
        "dt": _number("s"),
    },
    Unicycle: {},
    Spin: {"voltage": _number("V")},
    DriveAround: {"low": _number("V"), "high": _number("V"), "hold": _Key(_COUNT.read, "steps")},
    Replay: {
        "u": _Key(_inputs, "V, float64 in base64", lambda u: np.asarray(u, "<f8").tobytes(), True),
    },
    RobotDefinition: {
        "name": _Key(_text),
        "size": _number("px"),
        "alignment": _number("degrees"),
        "centre": _array("px of the image"),
        "outline": _array(),
        "maximum_blobs": _COUNT,
        "image": _IMAGE,
    },
    BlobMarker: {"color": _Key(_text), "polygon": _array("px of the image")},
}

# The keys of a MarkerLayout in each role's table, such as [markers.right], and the attributes that
# have the values by role.
_BY_ROLE: dict[str, tuple[str, _Key]] = {
    "color": ("colors", _Key(_text)),
    "position": ("positions", _array("px, forward and right of the centre")),
    "area": ("areas", _number("px^2")),
    "polygon": ("polygons", _array("px, its corners")),
}
_MAKERS: dict[type, Callable[..., Any]] = {
    RobotModel: RobotModel.from_theta,
    MarkerLayout: MarkerLayout.from_positions,
    Floor: lambda pixels: background_value(pixels),
}

# --- writing


def to_toml(changes: dict[str, Any]) -> str:
    """Return options as the text of a file.

    Parameters
    ----------
    changes : dict
        The options to write, in their normal forms.

    Raises
    ------
    ValueError
        If the text would be larger than what is read.
    """
    import tomlkit

    document = tomlkit.document()
    document.add(tomlkit.comment(_HEADER))
    document.add("format", tomlkit.item(_FORMAT))
    written = {name: _written(name, value) for name, value in changes.items()}
    # Below a table, a plain value would belong to it.
    for name, value in sorted(written.items(), key=lambda item: isinstance(item[1], dict)):
        if isinstance(value, dict):
            document.add(name, value)
        else:
            document.add(name, _commented(value, OPTIONS[name].unit))
    text = document.as_string()
    if len(text.encode()) > MOST_BYTES:
        raise ValueError(
            f"a scenario must fit into a file of {MOST_BYTES >> 20} MB, got one of "
            f"{len(text) >> 20} MB: its images or recorded inputs are too large"
        )
    return text


def _written(name: str, value: Any) -> Any:
    """Return the value of an option as TOML has it: a table, or a plain value."""
    if name == "colors":
        return _colors_table(value)
    if isinstance(value, RobotDefinition) and (shipped := _shipped_name(value)) is not None:
        return shipped
    if type(value) in _TABLES:
        return _table(value, has_kind=len(OPTIONS[name].types) > 1 or not _TABLES[type(value)])
    return _CONTINUOUS if name == "headings" and value is None else _plain(value)


def _shipped_name(robot: RobotDefinition) -> str | None:
    return next((name for name in shipped_robots() if as_robot(name) == robot), None)


def _table(value: Any, has_kind: bool) -> Any:
    import tomlkit

    table = tomlkit.table()
    if has_kind:
        table.add("kind", type(value).__name__)
    for name, key in _TABLES[type(value)].items():
        _add(table, name, key, getattr(value, name))
    if isinstance(value, MarkerLayout):
        _add_markers(table, value)
    if isinstance(value, RobotDefinition):
        table.add("markers", tomlkit.table(is_super_table=True))
        for role, marker in value.markers.items():
            table["markers"].add(role, _table(marker, has_kind=False))
    return table


def _add_markers(tables: Any, layout: MarkerLayout) -> None:
    """Add a table for each role."""
    import tomlkit

    for role in layout.roles:
        table = tomlkit.table()
        for name, (attribute, key) in _BY_ROLE.items():
            values = getattr(layout, attribute)
            _add(table, name, key, values and values[role])
        tables.add(role, table)


def _add(table: Any, name: str, key: _Key, value: Any) -> None:
    plain = _plain(key.write(value))
    if plain is not None and plain == plain:  # NaN = not known
        table.add(name, _commented(plain, key.unit))


def _colors_table(colors: Iterable[ColorClass]) -> Any:
    import tomlkit

    table = tomlkit.table(is_super_table=True)
    for color in colors:
        ranges = tomlkit.table()
        for channel in ("y", "u", "v"):
            ranges.add(channel, list(getattr(color, channel)))
        table.add(tomlkit.key(color.name), ranges)
    return table


def _plain(value: Any) -> Any:
    """Return a value made of what TOML has, its numbers to the last bit."""
    if isinstance(value, (np.ndarray, np.generic)):
        return value.tolist()
    if isinstance(value, (tuple, list)):
        return [_plain(one) for one in value]
    return value


def _commented(value: Any, unit: str) -> Item:
    import tomlkit

    if isinstance(value, bytes):
        lines = base64.encodebytes(value).decode()
        item: Item = tomlkit.string(f"\n{lines}", multiline=True, literal=True)
    else:
        item = tomlkit.item(value)
    return item.comment(unit) if unit else item


# --- reading


def from_toml(cls: type[Scenario], text: str, source: str) -> Scenario:
    """Return the scenario of a text.

    Parameters
    ----------
    cls : type
        `Scenario`.
    text : str
        TOML.
    source : str
        Where the text is from: ``"scenario file run.toml"``.

    Raises
    ------
    TypeError
        If `text` is not a str.
    ValueError
        If the text is no scenario; the message names the source and the option.
    """
    if not isinstance(text, str):
        raise TypeError(f"text must be a str, got {quoted(text)}")
    try:
        if len(text) > MOST_BYTES:
            raise ValueError(f"text must have at most {MOST_BYTES >> 20} MB")
        return cls(**options_of(_parsed(text), [field.name for field in fields(cls)]))
    except (TypeError, ValueError, OverflowError) as error:
        raise ValueError(f"{one_line(source)}: {error}") from error


def _parsed(text: str) -> dict[str, Any]:
    try:
        return parse_toml(text, MOST_BYTES)
    except ValueError as error:
        raise ValueError(f"this is not TOML: {error}") from error


def options_of(values: dict[str, Any], known: Iterable[str]) -> dict[str, Any]:
    """Return the options of a table, as `Scenario` takes them; raise for what is wrong."""
    if values.pop("format", _FORMAT) != _FORMAT:
        raise ValueError(f"format must be {_FORMAT}: another one is of a newer robsim")
    check_names("a scenario has no option", values, known, ValueError)
    return {name: _read_option(name, value) for name, value in values.items()}


def _read_option(name: str, value: Any) -> Any:
    """Return the value of an option that TOML has given."""
    if name == "colors":
        return _in_table(name, lambda: _colors_of(value))
    if name == "robot" and not isinstance(value, dict):
        text = _of_type(name, value, "a text, or a table [robot]", str)
        return check_choice("robot", text, tuple(robot_names()))
    if name == "headings" and value == _CONTINUOUS:
        return None
    option = OPTIONS[name]
    if option.plain and not (option.types and isinstance(value, dict)):
        return _of_type(name, value, *option.plain)
    _of_type(name, value, f"a table [{name}]", dict)
    return _in_table(name, lambda: _value_of(dict(value), option.types))


def _in_table(name: str, read: Callable[[], Any]) -> Any:
    try:
        return read()
    except (TypeError, ValueError, OverflowError) as error:
        raise ValueError(f"[{cut(name)}] {error}") from error


def _value_of(table: dict[str, Any], kinds: tuple[type, ...]) -> Any:
    by_name = {kind.__name__: kind for kind in kinds}
    default = kinds[0].__name__ if len(kinds) == 1 else None
    if "kind" not in table and default is None:
        raise ValueError(f"kind is missing, one of {', '.join(map(repr, by_name))}")
    text = _of_type("kind", table.pop("kind", default), "a text", str)
    kind = by_name[check_choice("kind", text, tuple(by_name))]
    keys = _TABLES[kind]
    tables = taken_roles(table) if kind is MarkerLayout else table.pop("markers", {})
    check_names("there is no key", table, keys, ValueError)
    missing = [name for name, key in keys.items() if key.is_needed and name not in table]
    if missing:
        raise ValueError(f"{missing[0]} is missing")
    arguments = {name: keys[name].read(name, value) for name, value in table.items()}
    if kind is MarkerLayout:
        arguments |= _layout_of(tables)
    if kind is RobotDefinition:
        arguments["markers"] = markers_of_tables(tables)
    return _MAKERS.get(kind, kind)(**arguments)


def _layout_of(tables: Any) -> dict[str, dict[str, Any]]:
    """Return the attributes of a layout, by role, from the tables of both markers."""
    given = given_by_role("markers", tables, {name: name for name in _BY_ROLE})
    if "position" not in given:
        raise ValueError("position is missing")
    read: dict[str, dict[str, Any]] = {}
    for name, values in given.items():
        attribute, key = _BY_ROLE[name]
        read[attribute] = {role: key.read(f"{role}.{name}", one) for role, one in values.items()}
    return read


def _colors_of(tables: Any) -> tuple[ColorClass, ...]:
    if not isinstance(tables, dict):
        raise TypeError(f"colors must be tables such as [colors.red], got {_as_toml(tables)}")
    return tuple(_in_table(name, partial(_color_of, name, table)) for name, table in tables.items())


def _color_of(name: str, table: Any) -> ColorClass:
    if not isinstance(table, dict):
        raise TypeError(f"a colour must be a table with y, u and v, got {_as_toml(table)}")
    check_names("there is no key", table, ("y", "u", "v"), ValueError)
    return ColorClass(name, **{channel: _range(channel, table[channel]) for channel in table})


def _range(name: str, value: Any) -> tuple[int, int]:
    if not isinstance(value, list) or len(value) != 2:
        raise ValueError(f"{name} must be [lower, upper], two whole numbers, got {_as_toml(value)}")
    for one in value:
        _of_type(name, one, "[lower, upper], two whole numbers", int)
    lower, upper = (check_int(name, one, minimum=0, maximum=255) for one in value)
    return lower, upper
