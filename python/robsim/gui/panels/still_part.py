"""The still picture of a panel, for saved notebooks and snapshots."""

from __future__ import annotations

import math
import threading
import time
from contextlib import suppress

from robsim._core import Step
from robsim.gui.panels.part import Part
from robsim.gui.panels.run.camera import Shot

_GAP = 15.0  # s between two pictures while it runs
_REST = 0.5  # s after a step, so that repeated steps do not wait for pictures


class Still(Part):
    """Draws the panel, and sends the picture after each pause to links that keep one.

    During a run it also draws at intervals. Drawing takes about a second in a separate
    thread: the panel remains responsive.
    """

    _shot: Shot | None = None  # of the last step while nothing runs
    _due = math.inf
    _next = -math.inf  # when the next picture during a run is due
    _thread: threading.Thread | None = None

    def take(self, step: Step) -> None:
        is_running = self.panel.is_running
        if is_running and time.monotonic() < self._next:
            return
        if any(link.keeps_still for link in self.panel.links):
            self._next = time.monotonic() + _GAP
            self._shot = self.panel.record.shot(step)
            self.panel.post(self._later)

    def look(self, now: float) -> float:
        if now >= self._due:
            is_drawing = self._thread is not None and self._thread.is_alive()
            self._due = now + _REST if is_drawing else math.inf
            if not is_drawing:
                self._keep()
        return self._due

    def picture(self) -> bytes:
        """Draw the panel in its current state (PNG); any thread may call this."""
        driver = self.panel.driver
        if not (self.panel.record.n_steps or driver.is_here):
            driver.prepare()
        return self._drawn(driver.ask(self._newest))

    def close(self, timeout: float) -> None:
        if self._thread is not None:
            self._thread.join(timeout)

    def _newest(self) -> Shot | None:
        with suppress(Exception):  # the run reports a failed start
            return self.panel.record.shot(self.panel.runner.last_step)
        return None

    def _later(self) -> None:
        self._due = time.monotonic() + _REST

    def _keep(self) -> None:
        links = [link for link in self.panel.links if link.keeps_still]
        if not links or (shot := self._shot) is None:
            return

        def draw() -> None:
            picture = self._drawn(shot)
            for link in links:
                link.keep(picture)

        self._thread = threading.Thread(target=draw, name="robsim still", daemon=True)
        self._thread.start()

    def _drawn(self, shot: Shot | None) -> bytes:
        from robsim.gui.panels.still_picture import still_picture  # matplotlib takes its time

        panel = self.panel
        return still_picture(panel.record, shot, panel.driver.state, panel.goals)
