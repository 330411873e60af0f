"""The entry points of the tools: `color_panel`, `robot_panel`, `floor_panel`, and pictures."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from robsim._core import ColorClass, Frame
from robsim.base.files import as_path
from robsim.base.text import quoted
from robsim.gui.facade import is_shown, panel
from robsim.gui.tools.colors.panel import ColorPanel
from robsim.gui.tools.colors.view import ColorsView
from robsim.gui.tools.floor.corners import TITLE, tiled_floor
from robsim.gui.tools.floor.panel import FloorPanel
from robsim.gui.tools.floor.points import FloorDraft
from robsim.gui.tools.floor.view import FloorView
from robsim.gui.tools.pictures import (
    CameraPictures,
    OnePicture,
    Pictures,
    RecordedPictures,
    RunPictures,
    picture_of,
)
from robsim.gui.tools.robots.panel import RobotPanel
from robsim.gui.tools.robots.view import RobotsView
from robsim.lab.cameras.camera import Camera
from robsim.simulation import Experiment, Simulation
from robsim.simulation.options import colors_value
from robsim.vision.imaging import images
from robsim.vision.imaging.calibration import Calibration
from robsim.vision.imaging.calibration_file import load_calibration
from robsim.vision.imaging.recordings import Recording
from robsim.vision.robots.definition import RobotDefinition
from robsim.vision.robots.lookup import as_robot

_FILE, _EXAMPLE_FILE = "camera.toml", "example.toml"
_DRAFT = FloorDraft(area=(1200, 1200), mm_per_px=2.0)

#: The sources of a tool's pictures.
Seen = Camera | Recording | Simulation | Experiment | Frame | images.Pixels


def color_panel(
    what: Seen | str | PathLike[str] | None = None,
    *,
    colors: str | PathLike[str] | Iterable[ColorClass] | None = None,
    robot: str | PathLike[str] | RobotDefinition | None = None,
    file: str | PathLike[str] = "colors.toml",
) -> ColorPanel:
    """Open the panel that trains colours on pictures: mark a region, adjust and test its ranges.

    Parameters
    ----------
    what : Camera, Recording, Simulation, Experiment, Frame, array or path, optional
        Source of the pictures. A path names a picture, a folder of pictures or a video. For a
        simulation or an experiment, the tool shows the pictures of its panel
        (`robsim.panel`). Default: the picture of the robot.
    colors : path or iterable of ColorClass, optional
        Initial classes. Default: the classes in `file`, if it exists, otherwise none.
    robot : name, path or RobotDefinition, optional
        The robot to find with these classes. Default: the default robot.
    file : path
        Default file of Save.

    Returns
    -------
    ColorPanel
        The panel; `ColorPanel.value` has the classes.

    Raises
    ------
    OSError
        If a file cannot be read.
    TypeError, ValueError
        If an argument has the wrong type, or a file is unsuitable; the message names it.

    Examples
    --------
    In a notebook, ``tool`` as the last line of a cell shows the panel. Without a window:

    >>> step = robsim.Simulation(seed=1, robot="lab").step()
    >>> x, y = (int(value) for value in step.blobs["red"][0].centroid)
    >>> region = (x - 4, y - 4, x + 4, y + 4)
    >>> with robsim.gui.color_panel(step.frame, file="mine.toml") as tool:
    ...     color = tool.train("red", region)
    ...     path = tool.save()
    >>> [color.name for color in robsim.load_colors("mine.toml")]
    ['red']
    """
    path = as_path(file, "file")
    definition = as_robot(robot)
    if colors is None and not path.exists():
        known: Sequence[ColorClass] = ()
    else:
        known = colors_value(path if colors is None else colors)
    return ColorPanel(ColorsView(pictures_of(what, definition), known, definition, path))


def floor_panel(
    what: Seen | str | PathLike[str] | None = None,
    *,
    calibration: Calibration | str | PathLike[str] | None = None,
    file: str | PathLike[str] | None = None,
) -> FloorPanel:
    """Open the panel that calibrates a camera's view of the floor.

    Place points on the picture with the mouse under a magnifying glass, and enter their positions
    on the floor. Or let the panel find printed sheets. The panel shows the quality of the fit
    immediately.

    Parameters
    ----------
    what : Camera, Recording, Simulation, Experiment, Frame, array or path, optional
        Source of the pictures. A path names a picture, a folder of pictures or a video. Default: an
        example picture of a tiled floor.
    calibration : Calibration or path, optional
        Known lens, and optionally floor. Default: the calibration in `file`, if it exists.
    file : path, optional
        Default file of Save. Default: the file of `calibration`, or ``camera.toml``, or
        ``example.toml`` for the example.

    Returns
    -------
    FloorPanel
        The panel; `FloorPanel.value` has the calibration.

    Raises
    ------
    OSError
        If a file cannot be read.
    TypeError, ValueError
        If an argument has the wrong type, or a file is unsuitable; the message names it.

    Examples
    --------
    In a notebook, ``tool`` as the last line of a cell shows the panel. A camera takes its value:
    ``robsim.Camera(0, calibration=tool.value)``. Without a window:

    >>> with robsim.gui.floor_panel() as tool:
    ...     tool.put([(100, 100), (500, 100), (500, 400), (100, 400)],
    ...              [(0, 0), (800, 0), (800, 600), (0, 600)])
    ...     round(tool.value.mm_per_px, 2)
    2.0
    """
    given = None if file is None else as_path(file, "file")
    if what is None and calibration is None and given is None:
        given = Path(_EXAMPLE_FILE)  # the user's file stays unchanged
    known, path, is_read = _known(calibration, given)
    example = OnePicture(tiled_floor(), TITLE) if what is None else None
    source = example or pictures_of(what, as_robot(None))
    return FloorPanel(FloorView(source, known, _draft_of(known), path, is_read=is_read))


def _known(calibration: Any, file: Path | None) -> tuple[Calibration | None, Path, bool]:
    """Return the known calibration, the file to write, and whether the file has been read."""
    if isinstance(calibration, Calibration):
        return calibration, file or Path(_FILE), False
    if calibration is None:
        path = file or Path(_FILE)
        is_there = path.exists()
        return (load_calibration(path) if is_there else None), path, is_there
    if not isinstance(calibration, (str, PathLike)):
        raise TypeError(f"calibration must be a Calibration or a path, got {quoted(calibration)}")
    path = as_path(calibration, "calibration")
    known = load_calibration(path)
    return known, file or path, file is None or file.resolve() == path.resolve()


def _draft_of(known: Calibration | None) -> FloorDraft:
    if known is None or known.area is None or known.mm_per_px is None:
        return _DRAFT
    return FloorDraft(known.area, known.mm_per_px, known.marker_height)


def robot_panel(
    what: Seen | str | PathLike[str] | None = None,
    *,
    robot: str | PathLike[str] | RobotDefinition | None = None,
    colors: str | PathLike[str] | Iterable[ColorClass] | None = None,
) -> RobotPanel:
    """Open the panel that defines a robot: capture its picture, draw outline and markers, save it.

    Parameters
    ----------
    what : Camera, Recording, Simulation, Experiment, Frame, array or path, optional
        Source of the picture. A path names a picture, a folder of pictures or a video. By default
        there is no source, and the drawing starts from an existing robot.
    robot : name, path or RobotDefinition, optional
        The robot to draw on. Default: the default robot.
    colors : path or iterable of ColorClass, optional
        Colours for guessing the markers. Default: the shipped ones.

    Returns
    -------
    RobotPanel
        The panel; `RobotPanel.value` has the robot.

    Raises
    ------
    OSError
        If a file cannot be read.
    TypeError, ValueError
        If an argument has the wrong type, or a file is unsuitable; the message names it.

    Examples
    --------
    In a notebook, ``tool`` as the last line of a cell shows the panel. Without a window:

    >>> with robsim.gui.robot_panel() as tool:
    ...     sim = robsim.Simulation(robot=tool.value, measure=True, seed=1)
    >>> sim.run(3).seen
    array([ True,  True,  True])
    """
    definition = as_robot(robot)
    known = colors_value(colors)
    source = None if what is None else pictures_of(what, definition)
    return RobotPanel(RobotsView(source, definition, known))


def pictures_of(what: Any, robot: RobotDefinition) -> Pictures:
    """Return the source of the pictures of `what`; TypeError or ValueError if it is unsuitable."""
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
        is_frame = isinstance(what, Frame)
        return OnePicture(what if is_frame else images.check_pixels("what", what, 3), "a picture")
    if isinstance(what, (str, PathLike)):
        path = as_path(what, "what")
        if path.is_dir() or path.suffix.lower() not in images.image_suffixes():
            return RecordedPictures(Recording(path))
        return OnePicture(images.load_image(path), path.name)
    raise TypeError(
        "`what` must be a Camera, a Recording, a Simulation, an Experiment, a Frame, an array or a "
        f"path, got {quoted(what)}"
    )
