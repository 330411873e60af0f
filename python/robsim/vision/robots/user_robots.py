"""Adding, rotating and removing the user's robots, for `robsim robots`."""

from __future__ import annotations

import math
import os
import re
import shutil
import sys
import unicodedata
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import fields
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

from numpy.typing import ArrayLike

from robsim._core import ColorClass
from robsim.base.checks import LONGEST_NAME, check_bool, check_float, check_text, is_plain
from robsim.base.files import naming, read_text, sync_folder, write_whole
from robsim.base.files.writing import hidden_path
from robsim.base.text import listed, one_line, quoted
from robsim.vision.imaging.images import Pixels, load_image
from robsim.vision.robots.definition import (
    RobotDefinition,
    by_color,
    check_color_names,
    from_colors,
    roles_by_color,
)
from robsim.vision.robots.files import TOML, read_robot, save_robot
from robsim.vision.robots.finding import check_markers_by_color, reduced, robot_from_image
from robsim.vision.robots.lookup import (
    default_robot,
    find_folder,
    name_key,
    reset_default_robot,
    robot_names,
    same_name,
    shipped_robots,
    user_robots,
    user_robots_folder,
)
from robsim.vision.robots.marker_check import check_colors

if TYPE_CHECKING:
    from tomlkit import TOMLDocument

# Device names, which Windows does not allow for folders.
_RESERVED = re.compile(r"(?i)con|prn|aux|nul|com\d|lpt\d")


def add_robot(
    name: str,
    source: RobotDefinition | str | PathLike[str],
    *,
    size: float | None = None,
    alignment: float | None = None,
    centre: ArrayLike | None = None,
    outline: ArrayLike | None = None,
    markers: Mapping[str, ArrayLike] | None = None,
    colors: str | PathLike[str] | Iterable[ColorClass] | None = None,
    marker_colors: Sequence[str] | None = None,
    overwrite: bool = False,
    ignore_colors: bool = False,
) -> RobotDefinition:
    """Add a robot to your user folder.

    Parameters
    ----------
    name : str
        Its name: 1 to 40 letters of any language, digits, - and _; case does not matter.
    source : RobotDefinition, str or path
        A definition, the name of a robot, a folder with a ``robot.toml``, or an image file. Missing
        arguments below come from this source; for an image, `robot_from_image` derives them.
    size : float, optional
        Width of the image on the work area (px). Default for an image: 120.
    alignment : float, optional
        Clockwise rotation of the image (degrees) that makes the robot face right. Default for an
        image: 0.
    centre : array (2,), optional
        The robot's centre (image px). Default for an image: the centroid of the outline.
    outline : array (N, 2), optional
        Polygon around the robot (image px). Default for an image: the outline of the opaque pixels.
    markers : dict of str to array (N, 2), optional
        Polygons around the markers (image px) by their colours: ``{"red": polygon}``. Default for
        an image: the largest blobs of the colours. The roles of the markers follow from their
        positions on a robot that faces right.
    colors : path or iterable of ColorClass, optional
        Colour file, or classes, to find and check the markers. Default: the colours shipped with
        robsim.
    marker_colors : sequence of 2 str, optional
        The colours of the markers: for an image, in any order; for a robot, in the order of its
        roles, right and left, or front and back. Default for an image: red and blue.
    overwrite : bool
        Replace your robot of this name, if any.
    ignore_colors : bool
        Add the robot even if its markers are not detected with these colours.

    Returns
    -------
    RobotDefinition
        The robot as stored. Images of more than 1000 px a side are scaled down.

    Raises
    ------
    ValueError
        If the name or the robot is not valid; the message gives the reason. Nothing is stored then.

    Warns
    -----
    UserWarning
        If the image has no transparency and no `outline` is given.

    Examples
    --------
    >>> robot = robsim.vision.add_robot("mine", robsim.load_robot("lab"))
    >>> robsim.load_robot("mine").name
    'mine'
    >>> robsim.vision.remove_robot("mine")
    """
    check_new_name(name, check_bool("overwrite", overwrite))
    check_bool("ignore_colors", ignore_colors)
    name = unicodedata.normalize("NFC", name)  # an umlaut may be one character or two
    given: dict[str, Any] = {"size": size, "alignment": alignment, "centre": centre}
    given |= {"outline": outline}
    given = {key: value for key, value in given.items() if value is not None}
    template = source if isinstance(source, RobotDefinition) else _read_source(source)
    if isinstance(template, RobotDefinition):
        robot = reduced(_changed(template, markers, marker_colors, name=name, **given))
    else:
        robot = robot_from_image(
            name, template, colors=colors, markers=markers, marker_colors=marker_colors, **given
        )
    problems = [] if ignore_colors else check_colors(robot, colors).sentences
    if problems:
        raise ValueError(
            f"{'; '.join(problems)}. To add the robot anyway, use ignore_colors=True, or --anyway "
            "in the shell; the colour file can be changed later"
        )
    return _store(robot, overwrite)


def _changed(
    robot: RobotDefinition,
    markers: Mapping[str, ArrayLike] | None,
    marker_colors: Sequence[str] | None,
    **changes: Any,
) -> RobotDefinition:
    """Return a robot with other markers, colours, fields; the roles follow from the result."""
    known = by_color(robot)
    names = check_color_names("marker_colors", [*known] if marker_colors is None else marker_colors)
    polygons = {
        **dict(zip(names, known.values(), strict=True)),
        **check_markers_by_color(markers, names),
    }
    parts = {field.name: getattr(robot, field.name) for field in fields(robot)} | changes
    del parts["markers"]
    return from_colors(polygons, **parts)


def rotate_robot(name: str, degrees: float) -> RobotDefinition:
    """Rotate the image of one of your robots clockwise, to correct its alignment.

    Parameters
    ----------
    name : str
        Name of the robot.
    degrees : float
        Angle to add to its alignment (degrees).

    Returns
    -------
    RobotDefinition
        The changed robot.

    Raises
    ------
    ValueError
        If you have no robot of this name.

    Examples
    --------
    >>> robot = robsim.vision.add_robot("mine", robsim.load_robot("lab"))
    >>> turned = robsim.vision.rotate_robot("mine", 90)
    >>> robot.alignment, turned.alignment
    (90.0, 180.0)
    >>> robsim.vision.remove_robot("mine")
    """
    import tomlkit

    _user_robot(name)
    degrees = check_float("degrees", degrees)
    with _locked(user_robots_folder()):
        folder = _user_robot(name)
        robot = read_robot(folder)
        alignment = round(math.remainder(robot.alignment + degrees, 360), 6) + 0.0
        # Only this number and the roles change: comments in the file are kept.
        document = tomlkit.parse(read_text(folder / TOML))
        document["alignment"] = alignment
        _set_roles(document, robot, alignment)
        write_whole(folder / TOML, tomlkit.dumps(document).encode())
        return read_robot(folder)


def _set_roles(document: TOMLDocument, robot: RobotDefinition, alignment: float) -> None:
    """Give the markers' tables of a definition file the roles that follow from an alignment."""
    import tomlkit

    roles = roles_by_color(by_color(robot), alignment)
    if all(roles[marker.color] == role for role, marker in robot.markers.items()):
        return
    tables: Any = document["markers"]
    renamed = tomlkit.table(is_super_table=True)
    for old, marker in robot.markers.items():
        renamed.append(roles[marker.color], tables[old])
    document["markers"] = renamed


def remove_robot(name: str) -> None:
    """Remove one of your robots; if it was the default robot, ``lab`` becomes the default.

    Parameters
    ----------
    name : str
        Name of the robot.

    Raises
    ------
    ValueError
        If you have no robot of this name.

    Examples
    --------
    >>> robot = robsim.vision.add_robot("mine", robsim.load_robot("lab"))
    >>> robsim.vision.remove_robot("mine")
    >>> "mine" in robsim.vision.robot_names()
    False
    """
    _user_robot(name)
    with _locked(user_robots_folder()):
        folder = _user_robot(name)
        try:
            is_default = name_key(default_robot()) == name_key(name)
        except ValueError:
            is_default = False
        _discard(folder)
    if is_default:
        reset_default_robot()


def check_new_name(name: str, overwrite: bool) -> None:
    """Raise TypeError or ValueError for an invalid name of a new robot."""
    if not is_plain(check_text("name", name), "-_"):
        raise ValueError(
            f"name must be 1 to {LONGEST_NAME} letters, digits, - and _, starting with a letter "
            f"or a digit, got {quoted(name)}"
        )
    if _RESERVED.fullmatch(name):
        raise ValueError(f"name must not be a device name of Windows, got {quoted(name)}")
    _check_not_shipped(name)
    existing = same_name(name, user_robots())
    if existing is not None and not overwrite:
        raise ValueError(
            f"you already have a robot {quoted(existing)}: to replace it, use overwrite=True, or "
            "--overwrite in the shell"
        )


def _check_not_shipped(name: str) -> None:
    shipped = same_name(name, shipped_robots())
    if shipped is not None:
        raise ValueError(
            f"the robot {shipped!r} ships with robsim and cannot be changed: "
            f"`robsim robots add my-{shipped} {shipped}` makes a copy for your changes"
        )


def _user_robot(name: str) -> Path:
    """Return the folder of one of the user's robots; raise ValueError for an unknown name."""
    robots = user_robots()
    found = same_name(check_text("name", name), robots)
    if found is None:
        _check_not_shipped(name)
        names = f"known: {listed(robots)}" if robots else "you have no robots yet"
        raise ValueError(f"you have no robot {quoted(name)}; {names}")
    return robots[found]


def _read_source(source: str | PathLike[str]) -> RobotDefinition | Pixels:
    """Return the robot with a name or in a folder, or else the image in a file."""
    if not isinstance(source, (str, PathLike)):
        raise TypeError(
            "source must be a RobotDefinition, a robot's name, a folder or an image file, "
            f"got {quoted(source)}"
        )
    folder = find_folder(source) or Path(source)
    if (folder / TOML).is_file():
        return read_robot(folder)
    if folder.is_dir():
        raise ValueError(
            f"the folder {one_line(folder)} has no {TOML} and thus does not define a robot"
        )
    if not folder.is_file():
        raise ValueError(
            f"source must be a robot's name ({listed(robot_names())}), a folder with a {TOML} "
            f"or an image file, got {quoted(str(source))}"
        )
    return load_image(folder, mode="RGBA")


def _store(robot: RobotDefinition, overwrite: bool) -> RobotDefinition:
    """Store a robot atomically: write a temporary folder, read it back, then give it its name."""
    parent = user_robots_folder()
    with naming(parent):
        parent.mkdir(parents=True, exist_ok=True)
    with _locked(parent):
        check_new_name(robot.name, overwrite)  # another process may have added one
        folder = parent / robot.name
        temporary = hidden_path(parent)
        try:
            with naming(folder):
                save_robot(temporary, robot)
            stored = read_robot(temporary)
            old = same_name(robot.name, user_robots())
            with naming(folder):
                if old is None:
                    temporary.rename(folder)
                else:
                    save_robot(parent / old, robot)
                    (parent / old).rename(folder)  # in capitals or not, as it is called now
                sync_folder(parent)
        finally:
            shutil.rmtree(temporary, ignore_errors=True)
    return stored


@contextmanager
def _locked(parent: Path) -> Iterator[None]:
    """Let one process at a time change the robots; a killed process releases the lock."""
    if sys.platform == "win32":
        yield
        return
    import fcntl

    descriptor = os.open(parent, os.O_RDONLY)
    try:
        with suppress(OSError):  # a file system without locks
            fcntl.flock(descriptor, fcntl.LOCK_EX)
        yield
    finally:
        os.close(descriptor)


def _discard(folder: Path) -> None:
    """Remove a robot's folder: first by a rename, which is atomic, then its files."""
    with naming(folder):
        discarded = folder.rename(hidden_path(folder.parent))
        sync_folder(folder.parent)
    shutil.rmtree(discarded, ignore_errors=True)
