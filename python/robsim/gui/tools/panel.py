"""What users hold of every tool: its pictures, and how it ends."""

from __future__ import annotations

from collections.abc import Callable
from os import PathLike
from typing import Any, TypeVar

from robsim._core import Frame
from robsim.base.checks import check_bool, check_int
from robsim.gui.hosted import HostedPanel
from robsim.gui.tools.tool import ToolView
from robsim.vision.imaging import images

T = TypeVar("T")


class ToolPanel(HostedPanel):
    """A panel in which something is made on pictures."""

    _view: ToolView

    def __init__(self, view: ToolView) -> None:
        self._view = view
        super().__init__()

    def load(self, picture: Frame | images.Pixels | str | PathLike[str]) -> None:
        """Show a picture in place of those that are shown, as if it were dropped on the tool.

        Parameters
        ----------
        picture : path, Frame or array (H, W, 3) or (H, W, 4) of uint8
            The picture; what is transparent in it is shown grey.

        Raises
        ------
        OSError
            If the file cannot be read.
        RuntimeError
            If the panel is closed.
        TypeError, ValueError
            If it is no picture, or cannot be used; what is shown stays then.
        """
        self._view.load_picture(picture)

    def go_back(self) -> None:
        """Show again what the panel was opened on, as it was before a picture was loaded.

        Raises
        ------
        RuntimeError
            If the panel is closed.
        ValueError
            If that is what is shown.
        """
        self._view.ask(self._view.go_back)

    def freeze(self, on: bool = True) -> None:
        """Let the live picture stay as it is, or go on.

        Parameters
        ----------
        on : bool
            Whether it stays.

        Raises
        ------
        TypeError, ValueError
            If `on` is not True or False, or there is nothing to be kept.
        """
        check_bool("on", on)
        self._view.ask(lambda: self._view.freeze(on))

    def look(self, k: int) -> None:
        """Show a picture of a recording.

        Parameters
        ----------
        k : int
            Its number, from 0.

        Raises
        ------
        TypeError, ValueError
            If there is none.
        """
        count = self._view.source.count
        if not count:
            raise ValueError("k must be of a recording, which is not what is shown")
        k = check_int("k", k, minimum=0, maximum=count - 1)
        self._view.ask(lambda: self._view.look_at(k))

    def undo(self) -> None:
        """Undo the last change; nothing if there is none."""
        self._view.ask(lambda: self._view.travel(self._view.history.undo))

    def redo(self) -> None:
        """Do again what was undone last; nothing if there is nothing."""
        self._view.ask(lambda: self._view.travel(self._view.history.redo))

    def _change(self, change: Callable[[], T]) -> T:
        return self._view.ask(lambda: self._view.change(change))

    def _look(self, function: Callable[[], T]) -> T:
        """Return what a function returns of what was made, once it is closed, too."""
        try:
            return self._view.ask(function)
        except RuntimeError:
            if not self._view.is_over:
                raise
            return function()

    def _made(self) -> tuple[str, Any]:
        """Return what a run is to have of it: the attribute and its value; in the view's thread."""
        raise NotImplementedError  # where no run can have it

    def _keep(self) -> str:
        """Keep it for later runs; return what was done, in the view's thread."""
        return ""

    @property
    def _is_closed(self) -> bool:
        return self._view.is_over

    def _pause_soon(self) -> None:
        pass  # nothing runs
