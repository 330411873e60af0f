"""Scenarios as TOML text: complete, exact, and safe to read from a stranger."""

from __future__ import annotations

import io
from functools import partial
from typing import TYPE_CHECKING, Any

from robsim._core import (
    DriveAround,
    MarkerLayout,
    Replay,
    RobotModel,
    RobotParameters,
    Spin,
    Unicycle,
)
from robsim.base.checks import check_choice, check_float, check_text
from robsim.base.files import codec
from robsim.base.seeds import SeedRecord
from robsim.simulation.option import Option, Switch
from robsim.simulation.options import OPTIONS, background_value
from robsim.simulation.world.disturbances import Dropout, ParameterMismatch, PoseNoise, WheelNoise
from robsim.simulation.world.scene import Floor
from robsim.vision.imaging import images
from robsim.vision.imaging.images import Pixels
from robsim.vision.imaging.noise import GaussianNoise, UniformNoise
from robsim.vision.markers.color_files import COLORS
from robsim.vision.robots.definition import RobotDefinition
from robsim.vision.robots.files import LAYOUT, ROBOT_KEYS
from robsim.vision.robots.lookup import as_robot, robot_names, shipped_robots

if TYPE_CHECKING:
    from robsim.simulation.scenario import Scenario

MOST_BYTES = 64 * 2**20  # of a file
_FORMAT = 1
_CONTINUOUS = "continuous"  # TOML has no None


def _image(name: str, value: Any) -> Pixels:
    return images.decoded(io.BytesIO(codec.base64_bytes(name, value)), name)


def _png(pixels: Pixels) -> bytes:
    height, width = pixels.shape[:2]
    if height * width > images.MOST_PIXELS:
        raise ValueError(
            f"an image must have at most {images.MOST_PIXELS} px, got {width} x {height}"
        )
    return images.png_bytes(pixels)


def _numbers(name: str, value: Any) -> Any:
    return tuple(value) if isinstance(value, list) else value


_IMAGE = codec.Entry("PNG in base64", _image, _png)
_VOLTAGES = codec.Entry("V, float64 in base64", codec.base64_pairs, codec.pairs_base64)

_KEYS: dict[type, dict[str, codec.Row]] = {
    GaussianNoise: {"percent": codec.Entry("%", check_float)},
    UniformNoise: {"percent": codec.Entry("%", check_float)},
    Dropout: {"probability": check_float, "steps": ""},
    PoseNoise: {"covariance": "px^2, px rad, rad^2, a step"},
    WheelNoise: {"sigma": "V"},
    ParameterMismatch: {"sigma": codec.Entry("relative", check_float)},
    SeedRecord: dict.fromkeys(("entropy", "spawn_key"), _numbers),
    RobotParameters: {
        "mass": "kg",
        "inertia": "kg m^2",
        "linear_friction": "N s/m",
        "angular_friction": "N m s/rad",
        "wheel_radius": "m",
        "wheel_base": "m",
        "motor_gain": "N m/V",
        "motor_offset": "N m",
        "dt": "s",
    },
    Unicycle: {},
    Spin: {"voltage": "V"},
    DriveAround: {"low": "V", "high": "V", "hold": "steps"},
    Replay: {"u": _VOLTAGES},
    RobotDefinition: {**ROBOT_KEYS, "image": _IMAGE},
}
#: The values that are tables, by their kinds.
TABLES = {kind: codec.Table(kind, keys) for kind, keys in _KEYS.items()} | {
    RobotModel: codec.Table(
        RobotModel.from_theta, {"theta": "rows X, Y, P; columns a1, a2, b1, b2, d1", "dt": "s"}
    ),
    Floor: codec.Table(lambda pixels: background_value(pixels), {"pixels": _IMAGE}),
    MarkerLayout: LAYOUT,
}


def _read(name: str, value: Any) -> Any:
    """Return the value of an option from TOML."""
    if name == "robot" and not isinstance(value, dict):
        return check_choice(name, value, tuple(robot_names()))
    if name == "headings":
        expected = f'a whole number, or "{_CONTINUOUS}"'
        return None if value == _CONTINUOUS else codec.of_type(name, value, expected, int)
    option = OPTIONS[name]
    if isinstance(option, Switch):
        return codec.flag(name, value)
    if not option.types:
        return value
    if option.plain and not isinstance(value, dict):
        return codec.of_type(name, value, f"a whole number, or a table [{name}]", int)
    table = dict(codec.as_table(name, value, f" [{name}]"))
    kinds = {kind.__name__: kind for kind in option.types}
    return TABLES[kinds[codec.kind_of(table, tuple(kinds))]].read(name, table)


def _written(option: Option, value: Any) -> Any:
    """Return the value of an option for TOML: a table, or a plain value."""
    if isinstance(value, RobotDefinition):
        for shipped in shipped_robots():
            if as_robot(shipped) == value:
                return shipped
    if (table := TABLES.get(kind := type(value))) is None:
        return codec.plain(value)
    has_kind = len(option.types) > 1 or not table.keys
    return table.write(value, kind.__name__ if has_kind else "")


_FILE = codec.Table(
    codec.together,
    {"format": ""}
    | {
        name: codec.Entry(option.unit, _read, partial(_written, option))
        for name, option in OPTIONS.items()
    }
    | {"colors": COLORS},
    "A simulated world and a run of robsim: read it with robsim.Scenario.load.",
)


def data_of(name: str, value: Any) -> Any:
    """Return the value of an option, not None, for a file, in plain types."""
    written = _FILE._entries[name].write(value)
    return written.unwrap() if hasattr(written, "unwrap") else written


def units_of(kind: type) -> dict[str, str]:
    """Return the units of the keys of a value that is a table."""
    return {key: entry.unit for key, entry in TABLES[kind]._entries.items()}


def to_toml(changes: dict[str, Any]) -> str:
    """Return options, in their normal forms, as TOML; ValueError if too large for a file."""
    values = {name: _CONTINUOUS if value is None else value for name, value in changes.items()}
    text = str(_FILE.write({"format": _FORMAT, **values}).as_string())
    if len(text.encode()) > MOST_BYTES:
        raise ValueError(
            f"a scenario must fit into a file of {MOST_BYTES >> 20} MB, got one of "
            f"{len(text) >> 20} MB: its images or recorded inputs are too large"
        )
    return text


def from_toml(cls: type[Scenario], text: str, source: str) -> Scenario:
    """Return the scenario of a text; a ValueError names `source`, ``"scenario file run.toml"``."""
    check_text("text", text)
    return codec.read_table(  # type: ignore[no-any-return]
        text, lambda table: cls(**options_of(table)), source, MOST_BYTES
    )


def options_of(table: dict[str, Any]) -> dict[str, Any]:
    """Return the options of a table, for `Scenario`; raise for a wrong one."""
    codec.check_format({"format": _FORMAT} | table, _FORMAT)
    options: dict[str, Any] = _FILE.read("scenario", table)
    options.pop("format", None)
    return options
