"""The methods common to all tools: pictures, undo, closing."""

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
    """A panel that works on pictures."""

    _view: ToolView

    def __init__(self, view: ToolView) -> None:
        self._view = view
        super().__init__()

    def load(self, picture: Frame | images.Pixels | str | PathLike[str]) -> None:
        """Show another picture, as if it were dropped on the tool.

        Parameters
        ----------
        picture : path, Frame or array (H, W, 3) or (H, W, 4) of uint8
            The picture; transparent pixels appear grey.

        Raises
        ------
        OSError
            If the file cannot be read.
        RuntimeError
            If the panel is closed.
        TypeError, ValueError
            If the picture is invalid or unusable; the displayed picture then stays.
        """
        self._view.load_picture(picture)

    def go_back(self) -> None:
        """Return to the panel's original pictures after `load`.

        Raises
        ------
        RuntimeError
            If the panel is closed.
        ValueError
            If the panel shows its original pictures.
        """
        self._view.ask(self._view.go_back)

    def freeze(self, on: bool = True) -> None:
        """Freeze the live picture, or continue.

        Parameters
        ----------
        on : bool
            Whether to freeze the picture.

        Raises
        ------
        TypeError, ValueError
            If `on` is not True or False, or the tool has no live picture to freeze.
        """
        check_bool("on", on)
        self._view.ask(lambda: self._view.freeze(on))

    def look(self, k: int) -> None:
        """Show a picture of a recording.

        Parameters
        ----------
        k : int
            Number of the picture, from 0.

        Raises
        ------
        TypeError, ValueError
            If the number is invalid.
        """
        count = self._view.source.count
        if not count:
            raise ValueError("k must be a picture of a recording, but the panel shows no recording")
        k = check_int("k", k, minimum=0, maximum=count - 1)
        self._view.ask(lambda: self._view.look_at(k))

    def undo(self) -> None:
        """Undo the last change, if any."""
        self._view.ask(lambda: self._view.travel(self._view.history.undo))

    def redo(self) -> None:
        """Redo the last undone change, if any."""
        self._view.ask(lambda: self._view.travel(self._view.history.redo))

    def _change(self, change: Callable[[], T]) -> T:
        return self._view.ask(lambda: self._view.change(change))

    def _look(self, function: Callable[[], T]) -> T:
        """Return a function's result about the product, even after closing."""
        try:
            return self._view.ask(function)
        except RuntimeError:
            if not self._view.is_over:
                raise
            return function()

    def _made(self) -> tuple[str, Any]:
        """Return the product for a run: the attribute and its value; in the view's thread."""
        raise NotImplementedError  # no run uses this product

    def _keep(self) -> str:
        """Save the product for later runs; return a summary, in the view's thread."""
        return ""

    @property
    def _is_closed(self) -> bool:
        return self._view.is_over

    def _pause_soon(self) -> None:
        pass  # nothing runs
