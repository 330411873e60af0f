"""Reading and writing robot definitions: a folder with robot.toml and an image."""

from __future__ import annotations

import io
import os
from functools import lru_cache
from os import PathLike
from pathlib import Path, PureWindowsPath
from typing import Any

import numpy as np
from PIL import Image

from robsim._base.checks import Floats
from robsim._base.files import as_folder, read_toml, write_whole
from robsim._base.values import FileVersion
from robsim.imaging._images import load_image
from robsim.robots._definition import RobotDefinition

#: The definition file of a robot folder, and the image beside it.
TOML = "robot.toml"
IMAGE = "robot.png"

_KEYS = {"name", "image", "size", "alignment", "outline", "red", "blue"}
_OPTIONAL = {"centre", "maximum_blobs"}

_TEXT = """\
# The appearance of a robot from above. Written by robsim; it may be edited by hand.
# `robsim robots show FOLDER` checks and draws it.

name = {name}
image = "{image}"   # beside this file; surroundings transparent
size = {size}   # width of the image on the work area (px)
alignment = {alignment}   # degrees clockwise, after which the robot faces right

# Points are [right, down] in image pixels; the centre of the top left pixel is (0, 0).
# The robot's centre, around which it turns:
centre = {centre}

# Polygons. Around the robot:
outline = {outline}

# Around the red marker; its area and centroid are those that the camera is to measure:
red = {red}

# Around the blue marker:
blue = {blue}

# Number of the largest blobs of each colour among which the markers are searched:
maximum_blobs = {maximum_blobs}
"""


def read_robot(folder: Path) -> RobotDefinition:
    """Read the robot definition of a folder; files that have not changed are read only once.

    Raises
    ------
    ValueError
        If its files do not define a robot; the message names the file.
    """
    file = os.path.join(folder, TOML)
    try:
        definition = FileVersion.of(file)
        image = os.path.join(folder, _image_name(definition))
        return _definition(definition, FileVersion.of(image))
    except (ValueError, TypeError, OSError) as error:
        raise ValueError(f"robot definition {file}: {error}") from error


def save_robot(folder: str | PathLike[str], robot: RobotDefinition) -> None:
    """Write a robot definition: a ``robot.toml`` with comments, and its image ``robot.png``.

    Parameters
    ----------
    folder : path
        The folder; it is created if needed. Files of these names are replaced, others are kept.
    robot : RobotDefinition
        The robot. Points are rounded to 0.01 px of the image.

    Raises
    ------
    TypeError
        If `robot` is not a RobotDefinition, or `folder` not a path.
    OSError
        If a file cannot be written.
    """
    if not isinstance(robot, RobotDefinition):
        raise TypeError(f"robot must be a RobotDefinition, got {robot!r}")
    folder = as_folder(folder)
    folder.mkdir(parents=True, exist_ok=True)
    image = io.BytesIO()
    Image.fromarray(robot.image).save(image, format="PNG")
    write_whole(folder / IMAGE, image.getvalue())
    write_whole(folder / TOML, _as_text(robot).encode())


@lru_cache(maxsize=16)
def _image_name(file: FileVersion) -> str:
    """Return the name of the image of a definition file."""
    values = read_toml(file.path)
    missing = _KEYS - set(values)
    unknown = set(values) - _KEYS - _OPTIONAL
    if missing or unknown:
        problems = [f"{key} is missing" for key in sorted(missing)]
        problems += [f"{key} is not known" for key in sorted(unknown)]
        raise ValueError("; ".join(problems))
    image = values["image"]
    if not isinstance(image, str):
        raise TypeError(f"image must be the name of a file, got {image!r}")
    # PureWindowsPath knows the path separators of all systems.
    if image in ("", ".", "..") or PureWindowsPath(image).name != image:
        raise ValueError(f"image must be the name of a file beside {TOML}, got {image!r}")
    return image


@lru_cache(maxsize=16)
def _definition(file: FileVersion, image: FileVersion) -> RobotDefinition:
    values: dict[str, Any] = read_toml(file.path)
    return RobotDefinition(**{**values, "image": load_image(image.path, mode="RGBA")})


def _as_text(robot: RobotDefinition) -> str:
    import tomlkit

    assert robot.centre is not None
    return _TEXT.format(
        name=tomlkit.string(robot.name).as_string(),
        image=IMAGE,
        size=float(robot.size),
        alignment=float(robot.alignment),
        centre=_point(robot.centre),
        outline=_points(robot.outline),
        red=_points(robot.red),
        blue=_points(robot.blue),
        maximum_blobs=robot.maximum_blobs,
    )


def _point(point: Floats) -> str:
    return "[" + ", ".join(f"{value:.2f}" for value in np.round(point, 2) + 0.0) + "]"


def _points(points: Floats) -> str:
    """Return the points as TOML, four per line."""
    texts = [_point(point) for point in points]
    lines = [", ".join(texts[i : i + 4]) for i in range(0, len(texts), 4)]
    return "[\n" + "".join(f"    {line},\n" for line in lines) + "]"
