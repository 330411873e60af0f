"""Reading and writing robot definitions: a folder with robot.toml and an image."""

from __future__ import annotations

import os
from contextlib import suppress
from functools import lru_cache, partial
from os import PathLike
from pathlib import Path, PureWindowsPath
from typing import Any

import numpy as np

from robsim._core import MarkerLayout
from robsim.base.checks import check_choice, check_float, check_kind, check_text
from robsim.base.files import as_path, codec, naming, write_whole
from robsim.base.text import one_line, quoted
from robsim.base.values import FileVersion
from robsim.vision.imaging.images import load_image, png_bytes
from robsim.vision.robots.definition import DEFAULT_COLORS, BlobMarker, RobotDefinition
from robsim.vision.robots.marker_roles import ROLES, roles_of
from robsim.vision.robots.polygon_checks import finite_array

#: The definition file of a robot folder, and the image next to the file.
TOML = "robot.toml"
IMAGE = "robot.png"
_WHAT = "robot definition "
_OTHER_IMAGE = "robot-2.png"  # while a definition that uses the first one is replaced

_POINTS = codec.Entry("", write=codec.rows)
_MARKER = codec.Table(
    lambda polygon, kind="blob", **color: {"polygon": polygon, **color},
    {
        "kind": partial(check_choice, choices=("blob",)),
        "color": "",
        "polygon": codec.Entry(
            "px of the image; the camera is to measure its area", write=codec.rows
        ),
    },
)


def _markers(**markers: dict[str, Any]) -> dict[str, BlobMarker]:
    made = {}
    for role, color in zip(roles_of("markers", markers), DEFAULT_COLORS, strict=True):
        with codec.within(role):
            made[role] = BlobMarker(**{"color": color} | markers[role])
    return made


_ROLES = tuple(role for roles in ROLES for role in roles)
#: The keys of a robot, but for its image.
ROBOT_KEYS: dict[str, codec.Row] = {
    "name": "",
    "size": codec.Entry("width of the image on the work area (px)", check_float),
    "alignment": codec.Entry("degrees clockwise, after which the robot faces right", check_float),
    "centre": "around which it turns (px of the image)",
    "outline": _POINTS,
    "maximum_blobs": "the largest of each colour, among which the markers are searched",
    "markers": codec.Table(_markers, dict.fromkeys(_ROLES, _MARKER)),
}
_ROLE = codec.Table(
    codec.together,
    {
        "color": check_text,
        "position": codec.Entry(
            "px, forward and right of the centre", partial(finite_array, shape=(2,))
        ),
        "area": codec.Entry("px^2", check_float),
        "polygon": codec.Entry("px, its corners", partial(finite_array, shape=(-1, 2))),
    },
    needed=("position",),
)


def _layout(**values: Any) -> MarkerLayout:
    """Return a layout: the color of each role is in ``colors``, its position in ``positions``."""
    markers = {role: values.pop(role) for role in _ROLES if role in values}
    for role in roles_of("markers", markers):
        for key, one in markers[role].items():
            values.setdefault(f"{key}s", {})[role] = one
    return MarkerLayout.from_positions(**values)


def _parts_of(layout: MarkerLayout) -> tuple[Any, ...]:
    by_role = {key: getattr(layout, f"{key}s") or {} for key in _ROLE.keys}
    roles = {role: {key: of.get(role) for key, of in by_role.items()} for role in layout.roles}
    return layout, roles


#: Where the markers are on the work area, as files have it.
LAYOUT = codec.Table(
    _layout,
    {
        "distance_tolerance": "fraction",
        "area_tolerance": "ratio",
        "maximum_blobs": "",
        **dict.fromkeys(_ROLES, _ROLE),
    },
    parts=_parts_of,
)


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

    An existing definition is replaced in a single operation: even after a crash, the folder has
    either the old or the new definition. The image gets the name ``robot-2.png`` if the old image
    is ``robot.png``.

    Parameters
    ----------
    folder : path
        The folder; created if needed. Other files in it are kept.
    robot : RobotDefinition
        The robot. Points are rounded to 0.01 px of the image.

    Raises
    ------
    TypeError
        If `robot` is not a RobotDefinition, or `folder` is not a path.
    OSError
        If a file cannot be written.

    Examples
    --------
    >>> robsim.vision.save_robot("mine", robsim.load_robot("lab"))
    >>> robsim.load_robot("mine").size
    120.0
    """
    check_kind("robot", robot, RobotDefinition)
    folder = as_path(folder, "folder")
    with naming(folder):
        folder.mkdir(parents=True, exist_ok=True)
    content = png_bytes(robot.image)
    image, old = _image_names(folder, content)
    if image != old:
        write_whole(folder / image, content)
    write_whole(folder / TOML, _FILE.write((robot, image)).as_string().encode())
    if old in (IMAGE, _OTHER_IMAGE) and old != image:
        with suppress(OSError):
            (folder / old).unlink()


def _image_names(folder: Path, content: bytes) -> tuple[str, str | None]:
    """Return the name for the new image of a folder, and the old image's name, if any."""
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
    return str(codec.load_table(file.path, lambda table: _FILE.read(TOML, table)["image"], _WHAT))


def _image_file(name: str, value: Any) -> str:
    # PureWindowsPath knows the path separators of all systems.
    file = check_text(name, value)
    if file in ("", ".", "..") or PureWindowsPath(file).name != file:
        raise ValueError(f"{name} must be the name of a file next to {TOML}, got {quoted(file)}")
    return file


def _saved_parts(saved: tuple[RobotDefinition, str]) -> tuple[Any, ...]:
    robot, image = saved
    markers = {
        role: {"color": one.color, "polygon": _near(one.polygon)}
        for role, one in robot.markers.items()
    }
    points = {"centre": _near(robot.centre), "outline": _near(robot.outline)}
    return {"image": image, "markers": markers, **points}, robot


def _near(points: Any) -> Any:
    return np.round(points, 2) + 0.0  # no -0.0


_FILE = codec.Table(
    codec.together,
    {
        "name": "",
        "image": codec.Entry("beside this file; surroundings transparent", _image_file),
        **ROBOT_KEYS,
    },
    """\
The appearance of a robot from above. Written by robsim; it may be edited by hand.
`robsim robots show FOLDER` checks and draws it.
Points are [right, down] in image pixels; the centre of the top left pixel is (0, 0).
The two markers are by where they sit on the robot: right and left, or front and back. A colour is a
class of a colour file; area and centroid of a polygon are those that the camera is to measure.""",
    needed=("name", "image", "size", "alignment", "outline", "markers"),
    parts=_saved_parts,
)


@lru_cache(maxsize=16)
def _definition(file: FileVersion, image: FileVersion) -> RobotDefinition:
    def robot_of(table: dict[str, Any]) -> RobotDefinition:
        values = _FILE.read(TOML, table)
        return RobotDefinition(**values | {"image": load_image(image.path, mode="RGBA")})

    return codec.load_table(file.path, robot_of, _WHAT)  # type: ignore[no-any-return]
