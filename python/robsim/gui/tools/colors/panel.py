"""`ColorPanel`: the users' side of the panel that trains colours."""

from __future__ import annotations

from collections.abc import Iterable
from os import PathLike
from pathlib import Path

from robsim._core import ColorClass
from robsim.base.checks import check_bool
from robsim.gui.tools.colors.training import Region
from robsim.gui.tools.colors.view import ColorsView
from robsim.gui.tools.panel import ToolPanel
from robsim.simulation.options import colors_value


class ColorPanel(ToolPanel):
    """The panel that trains colours; `robsim.gui.color_panel` opens this panel.

    The methods have the same effects as the mouse, and any thread may call them. The end of a
    ``with`` block closes the panel, but not the camera or run that supplies the pictures.

    Examples
    --------
    >>> panel = robsim.gui.color_panel(robsim.Simulation(seed=1))
    >>> panel.value
    ()
    >>> panel.close()
    """

    _maker = "robsim.gui.color_panel"
    _view: ColorsView

    @property
    def value(self) -> tuple[ColorClass, ...]:
        """The current classes, in the order of the file; assign to replace them."""
        return self._look(lambda: self._view.training.value)

    @value.setter
    def value(self, colors: Iterable[ColorClass]) -> None:
        if colors is None:
            raise TypeError("value must be ColorClass objects, got None")
        known = colors_value(colors)
        self._change(lambda: self._view.training.replace(known))

    def train(self, name: str, region: Region, *, more: bool = False) -> ColorClass:
        """Make a class from a region of the displayed picture.

        Parameters
        ----------
        name : str
            Name of the colour.
        region : tuple of int
            (left, top, right, bottom), all included (px).
        more : bool
            Whether to keep the previous regions of the class, too.

        Returns
        -------
        ColorClass
            The class.

        Raises
        ------
        RuntimeError
            If there is no picture yet.
        TypeError, ValueError
            As for `ColorClass.from_region`; the classes stay unchanged.
        """
        check_bool("more", more)
        return self._view.ask(lambda: self._view.train(name, region, more=more))

    def save(self, path: str | PathLike[str] | None = None) -> Path:
        """Write the classes into a colour file; other entries of the file are kept.

        Parameters
        ----------
        path : path, optional
            The file. Default: the panel's file.

        Returns
        -------
        Path
            The file.

        Raises
        ------
        OSError
            If the file cannot be written.
        TypeError, ValueError
            If `path` is not a path to a ``.toml`` file, or there are no classes.
        """
        return self._view.ask(lambda: self._view.save(path))

    def __repr__(self) -> str:
        names = ", ".join(color.name for color in self.value) or "no colours yet"
        return f"<robsim.gui.ColorPanel: {names}>"

    def _made(self) -> tuple[str, tuple[ColorClass, ...]]:
        return "colors", self._view.training.value
