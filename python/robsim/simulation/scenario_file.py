"""Scenarios as TOML text: complete, exact, and safe to read from a stranger."""

from __future__ import annotations

import io
from collections.abc import Iterable
from dataclasses import fields
from typing import TYPE_CHECKING, Any

import numpy as np
from PIL import Image

from robsim._core import (
    DriveAround,
    MarkerLayout,
    Replay,
    RobotModel,
    RobotParameters,
    Spin,
    Unicycle,
)
from robsim.base.checks import check_choice
from robsim.base.files import codec, parse_toml
from robsim.base.seeds import SeedRecord
from robsim.base.text import cut, quoted
from robsim.simulation.options import OPTIONS, background_value
from robsim.simulation.world.disturbances import Dropout, ParameterMismatch, PoseNoise, WheelNoise
from robsim.simulation.world.scene import Floor
from robsim.vision.imaging import images
from robsim.vision.imaging.images import Pixels
from robsim.vision.imaging.noise import GaussianNoise, UniformNoise
from robsim.vision.markers.color_files import COLOR, color_of
from robsim.vision.robots.definition import RobotDefinition
from robsim.vision.robots.files import LAYOUT, MARKERS, ROBOT_KEYS
from robsim.vision.robots.lookup import as_robot, robot_names, shipped_robots

if TYPE_CHECKING:
    from robsim.simulation.scenario import Scenario

MOST_BYTES = 64 * 2**20  # of a file
_FORMAT = 1
_HEADER = "A simulated world and a run of robsim: read it with robsim.Scenario.load."
_CONTINUOUS = "continuous"  # TOML has no None


def _numbers_tuple(name: str, value: Any) -> Any:
    return tuple(value) if isinstance(value, list) else value


def _image(name: str, value: Any) -> Pixels:
    data = codec.base64_bytes(name, value)
    try:
        with Image.open(io.BytesIO(data), formats=("PNG",)) as image:
            if image.width * image.height <= images.MOST_PIXELS and image.mode in ("RGB", "RGBA"):
                return np.array(image)
            got = f"{image.mode} of {image.width} x {image.height} px"
    except Exception as error:  # Pillow's decoders raise many types
        raise ValueError(f"{name} must be a PNG image in base64: {cut(error)}") from error
    raise ValueError(f"{name} must be RGB or RGBA of at most {images.MOST_PIXELS} px, got {got}")


def _png(pixels: Pixels) -> bytes:
    height, width = pixels.shape[:2]
    if height * width > images.MOST_PIXELS:
        raise ValueError(
            f"an image must have at most {images.MOST_PIXELS} px, got {width} x {height}"
        )
    return images.png_bytes(pixels)


_IMAGE = codec.Entry(_image, "PNG in base64", _png, is_needed=True)
_ENTROPY = codec.Entry(_numbers_tuple)

#: The values that are tables, by their kinds.
TABLES: dict[type, codec.Table] = {
    kind: codec.Table(kind, keys)
    for kind, keys in {
        GaussianNoise: {"percent": codec.Entry(codec.number, "%")},
        UniformNoise: {"percent": codec.Entry(codec.number, "%")},
        Dropout: {"probability": codec.Entry(codec.number), "steps": codec.Entry(codec.count)},
        PoseNoise: {"covariance": codec.Entry(codec.numbers, "px^2, px rad, rad^2, a step")},
        WheelNoise: {"sigma": codec.Entry(codec.numbers, "V")},
        ParameterMismatch: {"sigma": codec.Entry(codec.number, "relative")},
        SeedRecord: {"entropy": _ENTROPY, "spawn_key": _ENTROPY},
        RobotParameters: {
            "mass": codec.Entry(codec.number, "kg"),
            "inertia": codec.Entry(codec.number, "kg m^2"),
            "linear_friction": codec.Entry(codec.number, "N s/m"),
            "angular_friction": codec.Entry(codec.number, "N m s/rad"),
            "wheel_radius": codec.Entry(codec.number, "m"),
            "wheel_base": codec.Entry(codec.number, "m"),
            "motor_gain": codec.Entry(codec.numbers, "N m/V"),
            "motor_offset": codec.Entry(codec.numbers, "N m"),
            "dt": codec.Entry(codec.number, "s"),
        },
        Unicycle: {},
        Spin: {"voltage": codec.Entry(codec.number, "V")},
        DriveAround: {
            "low": codec.Entry(codec.number, "V"),
            "high": codec.Entry(codec.number, "V"),
            "hold": codec.Entry(codec.count, "steps"),
        },
        Replay: {
            "u": codec.Entry(codec.base64_pairs, "V, float64 in base64", codec.pairs_base64, True),
        },
        RobotDefinition: ROBOT_KEYS | {"image": _IMAGE, "markers": MARKERS},
    }.items()
} | {
    RobotModel: codec.Table(
        RobotModel.from_theta,
        {
            "theta": codec.Entry(
                codec.numbers, "rows X, Y, P; columns a1, a2, b1, b2, d1", is_needed=True
            ),
            "dt": codec.Entry(codec.number, "s"),
        },
    ),
    Floor: codec.Table(lambda pixels: background_value(pixels), {"pixels": _IMAGE}),
    MarkerLayout: LAYOUT,
}

# --- writing


def to_toml(changes: dict[str, Any]) -> str:
    """Return options, in their normal forms, as TOML; ValueError for more than a file may have."""
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
            document.add(name, codec.item(value, OPTIONS[name].unit))
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
        return codec.super_table({color.name: COLOR.write(color) for color in value})
    if isinstance(value, RobotDefinition) and (shipped := _shipped_name(value)) is not None:
        return shipped
    if (table := TABLES.get(kind := type(value))) is not None:
        has_kind = len(OPTIONS[name].types) > 1 or not table.keys
        return table.write(value, kind.__name__ if has_kind else "")
    return _CONTINUOUS if name == "headings" and value is None else codec.plain(value)


def _shipped_name(robot: RobotDefinition) -> str | None:
    return next((name for name in shipped_robots() if as_robot(name) == robot), None)


# --- reading


def from_toml(cls: type[Scenario], text: str, source: str) -> Scenario:
    """Return the scenario of a text; a ValueError names `source`, ``"scenario file run.toml"``."""
    if not isinstance(text, str):
        raise TypeError(f"text must be a str, got {quoted(text)}")
    with codec.telling(source, text):
        return cls(
            **options_of(parse_toml(text, MOST_BYTES), [field.name for field in fields(cls)])
        )


def options_of(values: dict[str, Any], known: Iterable[str]) -> dict[str, Any]:
    """Return the options of a table, as `Scenario` takes them; raise for what is wrong."""
    if "format" in values:
        codec.check_format(values, _FORMAT)
    known = list(known)
    options = {name: value for name, value in values.items() if name != "format"}
    for name in options:
        codec.check_key(name, known, "a scenario has no option")
    return {name: codec.read_key(name, _read_option, value) for name, value in options.items()}


def _read_option(name: str, value: Any) -> Any:
    """Return the value of an option that TOML has given."""
    if name == "colors":
        return (*codec.by_name(name, value, color_of, " such as [colors.red]").values(),)
    if name == "robot" and not isinstance(value, dict):
        text = codec.of_type(name, value, "a text, or a table [robot]", str)
        return check_choice("robot", text, tuple(robot_names()))
    if name == "headings" and value == _CONTINUOUS:
        return None
    option = OPTIONS[name]
    if option.plain and not (option.types and isinstance(value, dict)):
        return codec.of_type(name, value, *option.plain)
    table = dict(codec.as_table(name, value, f" [{name}]"))
    kinds = {kind.__name__: kind for kind in option.types}
    return TABLES[kinds[codec.kind_of(table, tuple(kinds))]].read(name, table)
