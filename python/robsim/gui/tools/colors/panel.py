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
        known = colors_value(colors)
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
        check_bool("more", more)
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
            If `path` is no path to a ``.toml`` file, or there are no classes.
        """
        return self._view.ask(lambda: self._view.save(path))

    def __repr__(self) -> str:
        names = ", ".join(color.name for color in self.value) or "no colours yet"
        return f"<robsim.gui.ColorPanel: {names}>"

    def _made(self) -> tuple[str, tuple[ColorClass, ...]]:
        return "colors", self._view.training.value
