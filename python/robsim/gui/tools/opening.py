"""The pictures that a user gives a tool: of whatever kind."""

from __future__ import annotations

from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from robsim._core import Frame, PlaneMap
from robsim.base.files import as_path
from robsim.base.text import one_line, quoted
from robsim.gui.facade import is_shown, panel
from robsim.gui.tools.pictures import (
    CameraPictures,
    OnePicture,
    Pictures,
    RecordedPictures,
    RunPictures,
)
from robsim.lab.cameras.camera import Camera
from robsim.simulation import Experiment, Simulation
from robsim.vision.imaging.images import Pixels, check_pixels, decoded, image_suffixes, load_image
from robsim.vision.imaging.recordings import Recording
from robsim.vision.robots.definition import RobotDefinition

#: What a tool is opened on.
Seen = Camera | Recording | Simulation | Experiment | Frame | Pixels

_FLOOR = 150  # level of what lies below a robot's picture


def pictures_of(what: Any, robot: RobotDefinition) -> Pictures:
    """Return what shows the pictures of something; TypeError or ValueError if it has none."""
    if what is None:
        return OnePicture(picture_of(robot), f"the picture of the robot {robot.name}")
    if isinstance(what, Camera):
        return CameraPictures(what)
    if isinstance(what, Recording):
        return RecordedPictures(what)
    if isinstance(what, (Simulation, Experiment)):
        is_open = is_shown(what)
        found = panel(what)
        return RunPictures(found._view.driver, type(what).__name__, None if is_open else found)
    if isinstance(what, (Frame, np.ndarray)):
        pixels = what.image if isinstance(what, Frame) else check_pixels("what", what, 3)
        return OnePicture(what if isinstance(what, Frame) else pixels, "a picture")
    if isinstance(what, (str, PathLike)):
        path = as_path(what, "what")
        return _picture_file(path) if _is_picture(path) else RecordedPictures(Recording(path))
    raise TypeError(
        "what must be a Camera, a Recording, a Simulation, an Experiment, a Frame, an array or a "
        f"path, got {quoted(what)}"
    )


def _is_picture(path: Path) -> bool:
    return not path.is_dir() and path.suffix.lower() in image_suffixes()


def _picture_file(path: Path) -> Pictures:
    return OnePicture(load_image(path), path.name)


def picture_of(robot: RobotDefinition) -> Frame:
    """Return a robot's picture on a grey floor, with the scale of the work area."""
    shown = over_floor(robot.image).image
    scale = robot.size / shown.shape[1]
    to_area = [(scale, 0, (scale - 1) / 2), (0, scale, (scale - 1) / 2), (0, 0, 1)]
    return Frame(shown, plane_map=PlaneMap(to_area))


def over_floor(image: Pixels) -> Frame:
    """Return a picture (h, w, 3 or 4) on a grey floor."""
    if image.shape[2] == 3 or (image[..., 3] == 255).all():
        return Frame(np.ascontiguousarray(image[..., :3]))
    alpha = image[..., 3:].astype(np.uint16)  # in which 255 x 255 has room
    # alpha / 255 x colour + (1 - alpha / 255) x floor, rounded
    shown = (alpha * image[..., :3] + (255 - alpha) * np.uint16(_FLOOR) + 127) // 255
    return Frame(shown.astype(np.uint8))


def given_picture(picture: Any) -> tuple[Pixels, str]:
    """Return the pixels (h, w, 3 or 4) of a picture, and what people call it.

    Raises
    ------
    OSError
        If its file cannot be read.
    TypeError, ValueError
        If it is neither a Frame, nor an array, nor the path of a picture.
    """
    if isinstance(picture, Frame):
        return picture.image, "a picture"
    if isinstance(picture, (str, PathLike)):
        path = as_path(picture, "picture")
        with path.open("rb") as file:
            return decoded(file, one_line(path)), path.name
    channels = 4 if isinstance(picture, np.ndarray) and picture.shape[2:] == (4,) else 3
    return check_pixels("picture", picture, channels, "a path, a Frame or "), "a picture"
