"""The start page as a panel: one page with the cards or the panel of a card."""

from __future__ import annotations

import threading
from collections.abc import Callable
from contextlib import ExitStack
from typing import TYPE_CHECKING

from robsim.gui.hosted import HostedPanel
from robsim.gui.start.view import StartView

if TYPE_CHECKING:
    from robsim.gui.facade import Panel


class Start(HostedPanel):
    """The start page; the page changes into the panel of a card, and back."""

    _maker = "robsim gui"
    _view: StartView

    def __init__(self, keep: Callable[[Panel], None] = lambda panel: None) -> None:
        self._keep = keep  # saves the run of a card before opening another
        self._view = StartView(self._open_card, self._resume, self._kept)
        self._panel: Panel | None = None
        self._has_ended = False
        self._held = ExitStack()  # the panel of a card, and its resources
        super().__init__()

    @property
    def panel(self) -> Panel | None:
        """The panel of the last opened card."""
        return self._panel

    @property
    def _is_closed(self) -> bool:
        return self._has_ended

    def _pause_soon(self) -> None:
        if self._panel is not None:
            self._panel._pause_soon()

    def _close(self, timeout: float) -> None:
        self._has_ended = True
        super()._close(timeout)
        self._drop(timeout)

    def _drop(self, timeout: float = 5.0) -> None:
        """Close the panel of a card, and its resources."""
        panel, held, self._panel, self._held = self._panel, self._held, None, ExitStack()
        if panel is not None:
            panel._close(timeout)
        held.close()

    def _open_card(self, card: str) -> None:
        from robsim.gui._driver import SPEED
        from robsim.gui.facade import Panel
        from robsim.gui.start.cards import scene_of

        if self._panel is not None:
            self._keep(self._panel)
        self._drop()
        scene = scene_of(card)
        panel = Panel(scene.what, SPEED if scene.task is None else 1.0, task=scene.task)
        self._panel, self._held = panel, scene.held
        if self._has_ended:  # meanwhile
            self._drop()
            return
        scene.begin(panel._view)
        panel._view.go_home = self._home
        self._resume()
        if scene.task is None:  # motors of a card are simulated
            panel.start()

    def _resume(self) -> None:
        if self._page is not None and self._panel is not None:
            self._page.show(self._panel._view)

    def _home(self) -> None:
        """Pause, and show the cards again; in the thread of the panel's view."""
        if self._panel is not None:
            threading.Thread(target=self._panel._pause_soon, daemon=True).start()
        if self._page is not None:
            self._page.show(self._view)

    def _kept(self) -> str:
        """Return the number of steps of the kept run; empty without a run."""
        return "" if self._panel is None else str(self._panel._view.record.n_steps)
