"""Reading and writing robot definitions: a folder with robot.toml and an image."""

from __future__ import annotations

import io
import os
from collections.abc import Mapping
from contextlib import suppress
from functools import lru_cache, partial
from os import PathLike
from pathlib import Path, PureWindowsPath
from typing import Any

import numpy as np
from PIL import Image

from robsim._core import MarkerLayout
from robsim.base.checks import Floats
from robsim.base.files import as_path, codec, naming, write_whole
from robsim.base.text import one_line, quoted
from robsim.base.values import FileVersion
from robsim.vision.imaging.images import load_image
from robsim.vision.robots.definition import DEFAULT_COLORS, BlobMarker, RobotDefinition
from robsim.vision.robots.marker_roles import roles_of, taken_roles

#: The definition file of a robot folder, and the image beside it.
TOML = "robot.toml"
IMAGE = "robot.png"
_WHAT = "robot definition "
_OTHER_IMAGE = "robot-2.png"  # while a definition that uses the first one is replaced

_MARKER = codec.Table(
    BlobMarker,
    {
        "color": codec.Entry(codec.text),
        "polygon": codec.Entry(codec.numbers, "px of the image", is_needed=True),
    },
)
_MARKER_KINDS = ("blob",)


def _markers(name: str, value: Any) -> dict[str, BlobMarker]:
    """Return the markers that a file has in a table for each role, such as ``[markers.right]``."""
    tables = codec.as_table(name, value)
    colors = zip(roles_of(name, tables), DEFAULT_COLORS, strict=True)
    return {
        role: codec.read_key(role, partial(_marker, color), tables[role]) for role, color in colors
    }


def _marker(color: str, role: str, value: Any) -> BlobMarker:
    table = {"color": color} | codec.as_table(role, value)
    codec.kind_of(table, _MARKER_KINDS)
    return _MARKER.read(role, table)  # type: ignore[no-any-return]


def _markers_table(markers: Mapping[str, BlobMarker]) -> Any:
    return codec.super_table({role: _MARKER.write(one) for role, one in markers.items()})


#: The keys of a robot, but for its image.
ROBOT_KEYS = {
    "name": codec.Entry(codec.text, is_needed=True),
    "size": codec.Entry(codec.number, "px", is_needed=True),
    "alignment": codec.Entry(codec.number, "degrees", is_needed=True),
    "centre": codec.Entry(codec.numbers, "px of the image"),
    "outline": codec.Entry(codec.numbers, is_needed=True),
    "maximum_blobs": codec.Entry(codec.count),
}
MARKERS = codec.Entry(_markers, "", _markers_table, is_needed=True)


class _LayoutTable(codec.Table):
    """The table of a marker layout, with a table for each role, such as ``[markers.right]``.

    The layout has the color of each role in ``colors``, its position in ``positions``, and so on.
    """

    _ROLE = codec.Table(
        dict,
        {
            "color": codec.Entry(codec.text),
            "position": codec.Entry(
                codec.numbers, "px, forward and right of the centre", is_needed=True
            ),
            "area": codec.Entry(codec.number, "px^2"),
            "polygon": codec.Entry(codec.numbers, "px, its corners"),
        },
    )

    def values(self, name: str, value: Any) -> dict[str, Any]:
        table = dict(codec.as_table(name, value))
        tables = taken_roles(table)
        values = super().values(name, table)
        for role in roles_of(name, tables):
            for key, one in codec.read_key(role, self._ROLE.read, tables[role]).items():
                values.setdefault(f"{key}s", {})[role] = one
        return values

    def write(self, value: Any, kind: str = "") -> Any:
        table = super().write(value, kind)
        given = {key: getattr(value, f"{key}s") for key in self._ROLE.keys}
        for role in value.roles:
            table.add(role, self._ROLE.write({key: by and by[role] for key, by in given.items()}))
        return table


#: Where the markers are on the work area, as files have it.
LAYOUT = _LayoutTable(
    MarkerLayout.from_positions,
    {
        "distance_tolerance": codec.Entry(codec.number, "fraction"),
        "area_tolerance": codec.Entry(codec.number, "ratio"),
        "maximum_blobs": codec.Entry(codec.count),
    },
)

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

_MARKER_TEXT = """
[markers.{role}]
color = {color}
polygon = {polygon}
"""


def read_robot(folder: Path) -> RobotDefinition:
    """Read a folder's robot definition, unchanged files only once; ValueError names the file."""
    file = os.path.join(folder, TOML)
    try:
        try:
            return _read(folder, file)
        except FileNotFoundError:  # it was replaced just now
            return _read(folder, file)
    except OSError as error:
        raise ValueError(f"{_WHAT}{one_line(file)}: {error}") from error


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
    except (ValueError, OSError):  # no definition that could be kept
        return IMAGE, None
    with suppress(OSError):
        if (folder / old).read_bytes() == content:
            return old, old
    return (_OTHER_IMAGE if old == IMAGE else IMAGE), old


@lru_cache(maxsize=16)
def _image_name(file: FileVersion) -> str:
    """Return the name of the image of a definition file."""
    return str(codec.load_table(file.path, lambda table: _ROBOT.read(TOML, table)["image"], _WHAT))


def _image_file(name: str, value: Any) -> str:
    # PureWindowsPath knows the path separators of all systems.
    file = codec.text(name, value)
    if file in ("", ".", "..") or PureWindowsPath(file).name != file:
        raise ValueError(f"{name} must be the name of a file beside {TOML}, got {quoted(file)}")
    return file


_ROBOT = codec.Table(
    dict, ROBOT_KEYS | {"image": codec.Entry(_image_file, is_needed=True), "markers": MARKERS}
)


@lru_cache(maxsize=16)
def _definition(file: FileVersion, image: FileVersion) -> RobotDefinition:
    def robot_of(table: dict[str, Any]) -> RobotDefinition:
        values = _ROBOT.read(TOML, table)
        return RobotDefinition(**values | {"image": load_image(image.path, mode="RGBA")})

    return codec.load_table(file.path, robot_of, _WHAT)  # type: ignore[no-any-return]


def _as_text(robot: RobotDefinition, image: str) -> str:
    import tomlkit

    assert robot.centre is not None
    filled = _TEXT.format(
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
        filled += _MARKER_TEXT.format(role=role, color=color, polygon=_points(marker.polygon))
    return filled


def _point(point: Floats) -> str:
    return "[" + ", ".join(f"{value:.2f}" for value in np.round(point, 2) + 0.0) + "]"


def _points(points: Floats) -> str:
    """Return the points as TOML, four per line."""
    texts = [_point(point) for point in points]
    lines = [", ".join(texts[i : i + 4]) for i in range(0, len(texts), 4)]
    return "[\n" + "".join(f"    {line},\n" for line in lines) + "]"
