"""Reading and writing robot definitions: a folder with robot.toml and an image."""

from __future__ import annotations

import io
import os
from contextlib import suppress
from functools import lru_cache
from os import PathLike
from pathlib import Path, PureWindowsPath
from typing import Any

import numpy as np
from PIL import Image

from robsim.base.checks import Floats
from robsim.base.files import as_path, naming, read_toml, write_whole
from robsim.base.text import cut, one_line, quoted
from robsim.base.values import FileVersion
from robsim.vision.imaging.images import load_image
from robsim.vision.robots.definition import RobotDefinition, markers_of_tables

#: The definition file of a robot folder, and the image beside it.
TOML = "robot.toml"
IMAGE = "robot.png"
_OTHER_IMAGE = "robot-2.png"  # while a definition that uses the first one is replaced

_KEYS = {"name", "image", "size", "alignment", "outline", "markers"}
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

# Number of the largest blobs of each colour among which the markers are searched:
maximum_blobs = {maximum_blobs}

# The two markers by where they sit on the robot: right and left, or front and back. A colour is a
# class of a colour file; area and centroid of a polygon are those that the camera is to measure.
"""

_MARKER = """
[markers.{role}]
color = {color}
polygon = {polygon}
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
        try:
            return _read(folder, file)
        except FileNotFoundError:  # it was replaced just now
            return _read(folder, file)
    except (ValueError, TypeError, OSError) as error:
        raise ValueError(f"robot definition {one_line(file)}: {error}") from error


def _read(folder: Path, file: str) -> RobotDefinition:
    definition = FileVersion.of(file)
    image = os.path.join(folder, _image_name(definition))
    return _definition(definition, FileVersion.of(image))


def save_robot(folder: str | PathLike[str], robot: RobotDefinition) -> None:
    """Write a robot definition: a ``robot.toml`` with comments, and its image ``robot.png``.

    Where there is such a definition, it is replaced at once: whatever happens, the folder has the
    old or the new one. The image is called ``robot-2.png`` if the old one is ``robot.png``.

    Parameters
    ----------
    folder : path
        The folder; it is created if needed. Other files in it are kept.
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
        raise TypeError(f"robot must be a RobotDefinition, got {quoted(robot)}")
    folder = as_path(folder, "folder")
    with naming(folder):
        folder.mkdir(parents=True, exist_ok=True)
    content = io.BytesIO()
    Image.fromarray(robot.image).save(content, format="PNG", compress_level=1)
    image, old = _image_names(folder, content.getvalue())
    if image != old:
        write_whole(folder / image, content.getvalue())
    write_whole(folder / TOML, _as_text(robot, image).encode())
    if old in (IMAGE, _OTHER_IMAGE) and old != image:
        with suppress(OSError):
            (folder / old).unlink()


def _image_names(folder: Path, content: bytes) -> tuple[str, str | None]:
    """Return the name for the new image of a folder, and that of the old one, if there is one."""
    try:
        old = _image_name(FileVersion.of(folder / TOML))
    except (ValueError, TypeError, OSError):  # no definition that could be kept
        return IMAGE, None
    with suppress(OSError):
        if (folder / old).read_bytes() == content:
            return old, old
    return (_OTHER_IMAGE if old == IMAGE else IMAGE), old


@lru_cache(maxsize=16)
def _image_name(file: FileVersion) -> str:
    """Return the name of the image of a definition file."""
    values = read_toml(file.path)
    missing = _KEYS - set(values)
    unknown = set(values) - _KEYS - _OPTIONAL
    if missing or unknown:
        problems = [f"{key} is missing" for key in sorted(missing)]
        problems += [f"{cut(key)} is not known" for key in sorted(unknown)[:3]]
        raise ValueError("; ".join(problems))
    image = values["image"]
    if not isinstance(image, str):
        raise TypeError(f"image must be the name of a file, got {quoted(image)}")
    # PureWindowsPath knows the path separators of all systems.
    if image in ("", ".", "..") or PureWindowsPath(image).name != image:
        raise ValueError(f"image must be the name of a file beside {TOML}, got {quoted(image)}")
    return image


@lru_cache(maxsize=16)
def _definition(file: FileVersion, image: FileVersion) -> RobotDefinition:
    values: dict[str, Any] = read_toml(file.path)
    values["markers"] = markers_of_tables(values["markers"])
    return RobotDefinition(**{**values, "image": load_image(image.path, mode="RGBA")})


def _as_text(robot: RobotDefinition, image: str) -> str:
    import tomlkit

    assert robot.centre is not None
    text = _TEXT.format(
        name=tomlkit.string(robot.name).as_string(),
        image=image,
        size=float(robot.size),
        alignment=float(robot.alignment),
        centre=_point(robot.centre),
        outline=_points(robot.outline),
        maximum_blobs=robot.maximum_blobs,
    )
    for role, marker in robot.markers.items():
        color = tomlkit.string(marker.color).as_string()
        text += _MARKER.format(role=role, color=color, polygon=_points(marker.polygon))
    return text


def _point(point: Floats) -> str:
    return "[" + ", ".join(f"{value:.2f}" for value in np.round(point, 2) + 0.0) + "]"


def _points(points: Floats) -> str:
    """Return the points as TOML, four per line."""
    texts = [_point(point) for point in points]
    lines = [", ".join(texts[i : i + 4]) for i in range(0, len(texts), 4)]
    return "[\n" + "".join(f"    {line},\n" for line in lines) + "]"
