"""What users hold of the panel that trains colours: `color_panel` opens it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from os import PathLike
from pathlib import Path

from robsim._core import ColorClass
from robsim.base.files import as_path
from robsim.base.text import quoted
from robsim.gui.tools.colors.training import Region
from robsim.gui.tools.colors.view import ColorsView
from robsim.gui.tools.panel import ToolPanel
from robsim.gui.tools.pictures import Seen, pictures_of
from robsim.simulation.options import colors_value
from robsim.vision.robots.definition import RobotDefinition
from robsim.vision.robots.lookup import as_robot


def color_panel(
    what: Seen | str | PathLike[str] | None = None,
    *,
    colors: str | PathLike[str] | Iterable[ColorClass] | None = None,
    robot: str | PathLike[str] | RobotDefinition | None = None,
    file: str | PathLike[str] = "colors.toml",
) -> ColorPanel:
    """Open the panel that trains colours, on pictures: mark a region, adjust its ranges, test them.

    Parameters
    ----------
    what : Camera, Recording, Simulation, Experiment, Frame, array or path, optional
        Whose pictures. A path is that of a picture, of a folder of them, or of a video; of a
        simulation or an experiment it shows what its panel (`robsim.panel`) has. Default: the
        picture of the robot.
    colors : path or iterable of ColorClass, optional
        The classes to begin with. Default: those in `file`, if it is there, or none.
    robot : name, path or RobotDefinition, optional
        The robot that is looked for with them. Default: the default robot.
    file : path
        Where Save writes them, unless another file is named there.

    Returns
    -------
    ColorPanel
        The panel; `ColorPanel.value` has the classes.

    Raises
    ------
    OSError
        If a file cannot be read.
    TypeError, ValueError
        If an argument has the wrong type, or is no such file; the message names it.

    Examples
    --------
    In a notebook, as the last lines of a cell, and when all are trained in the next one:

    >>> tool = robsim.gui.color_panel("photo.png")
    >>> tool

    >>> sim = robsim.Simulation(colors=tool.value, measure=True)

    Without a window:

    >>> with robsim.gui.color_panel("photo.png", file="mine.toml") as tool:
    ...     tool.train("red", (20, 20, 29, 29))
    ...     tool.save()
    ColorClass('red', y=(0, 255), u=(0, 154), v=(156, 255))
    """
    path = as_path(file, "file")
    definition = as_robot(robot)
    if colors is None and not path.exists():
        known: Sequence[ColorClass] = ()
    else:
        known = colors_value(path if colors is None else colors, None)
    return ColorPanel(ColorsView(pictures_of(what, definition), known, definition, path))


class ColorPanel(ToolPanel):
    """The panel that trains colours; `robsim.gui.color_panel` makes it.

    What its mouse does can be done by its methods, from any thread. A context closes it at its end;
    what it looked at stays open.
    """

    _maker = "robsim.gui.color_panel"
    _view: ColorsView

    @property
    def value(self) -> tuple[ColorClass, ...]:
        """The classes as they are now, in the order of the file. They can be set."""
        return self._look(lambda: self._view.training.value)

    @value.setter
    def value(self, colors: Iterable[ColorClass]) -> None:
        if colors is None:
            raise TypeError("value must be ColorClass objects, got None")
        known = colors_value(colors, None)
        self._change(lambda: self._view.training.replace(known))

    def train(self, name: str, region: Region, *, more: bool = False) -> ColorClass:
        """Make a class from a region of the picture that is shown.

        Parameters
        ----------
        name : str
            Name of the colour.
        region : tuple of int
            (left, top, right, bottom), all included (px).
        more : bool
            Whether the regions that the class has are kept, too.

        Returns
        -------
        ColorClass
            The class.

        Raises
        ------
        RuntimeError
            If there is no picture yet.
        TypeError, ValueError
            As from `ColorClass.from_region`; the classes are unchanged then.
        """
        if not isinstance(more, bool):
            raise TypeError(f"more must be True or False, got {quoted(more)}")
        return self._view.ask(lambda: self._view.train(name, region, more=more))

    def save(self, path: str | PathLike[str] | None = None) -> Path:
        """Write the classes into a colour file; what else stands in it is kept.

        Parameters
        ----------
        path : path, optional
            The file. Default: that of the panel.

        Returns
        -------
        Path
            The file.

        Raises
        ------
        OSError
            If it cannot be written.
        TypeError, ValueError
            If `path` is no path, or there are no classes.
        """
        return self._view.ask(lambda: self._view.save(path))

    def __repr__(self) -> str:
        names = ", ".join(color.name for color in self.value) or "no colours yet"
        return f"<robsim.gui.ColorPanel: {names}>"

    def _made(self) -> tuple[str, tuple[ColorClass, ...]]:
        return "colors", self._view.training.value
