"""A callback that does not end: its slot, run time and line, and its forced end."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from robsim.base.source_line import line_of_frame
from robsim.gui._driver import Playback
from robsim.gui.panels.part import Part
from robsim.simulation.time_limit import TimeLimit

if TYPE_CHECKING:
    from robsim.gui.panels.view import PanelView

PATIENCE = 2.0  # s for a call, for a command that waits for it, and for its end
_GAP = 0.5  # s between two looks while it runs


class Stuck(Part):
    """Reports a long call of a callback, and ends the call if something waits for its end.

    A button, a pause, a reset or a saved file may wait. The time limit of calls ends the call.
    Calls with an active debugger are never ended.
    """

    def __init__(self, panel: PanelView) -> None:
        super().__init__(panel)
        self.told: dict[str, Any] | None = None
        self._call: tuple[str, float] | None = None  # of `told`

    def state(self) -> dict[str, Any]:
        return {"stuck": self.told}

    def look(self, now: float) -> float:
        driver = self.panel.driver
        call = None if driver.limit is None else driver.limit.call
        if driver.limit is None or call is None or now - call[1] < PATIENCE:
            if self.told is not None:
                self.told = None
                self.panel.tell_state()
            return now + _GAP if driver.is_busy else math.inf
        self._call, told = call, self._described(driver.limit, call, now)
        if told["how"] == "runs":
            self._end_if_wanted(now)
        if told != self.told:
            self.told = told
            self.panel.tell_state()
        return now + _GAP

    def end(self, why: str = "it was ended by the button of the panel") -> None:
        """End the call under way, if it takes long."""
        limit = self.panel.driver.limit
        if limit is not None and self.told is not None:
            limit.end(f"{why}, after {self.told['seconds']} s", self._call)

    def hopeless(self, *, is_call: bool) -> str | None:
        """Return why a command, which `is_call` or waits for the call, can never end; any thread.

        A debugger may hold a call for any time.
        """
        hows = ("native",) if is_call else ("native", "debugged")
        if (told := self.told) is None or told["how"] not in hows:
            return None
        place = f", {told['file']}:{told['line']}" if told["file"] else ""
        why = (
            "a debugger waits in it" if told["how"] == "debugged" else "compiled code does not end"
        )
        return f"{told['slot']} has not ended for {told['seconds']} s{place}: {why}"

    def _described(self, limit: TimeLimit, call: tuple[str, float], now: float) -> dict[str, Any]:
        line = line_of_frame(limit.frame)
        since = limit.interrupted
        how = "runs" if since is None else "native" if now - since > PATIENCE else "ends"
        return {
            "slot": call[0],
            "seconds": int(now - call[1]),
            "limit": None if math.isinf(limit.seconds) else limit.seconds,
            "file": line.file if line else None,
            "line": line.number if line else None,
            "code": line.text if line else None,
            "how": "debugged" if limit.is_debugged else how,
        }

    def _end_if_wanted(self, now: float) -> None:
        driver = self.panel.driver
        asked = driver.waited_for
        if asked is not None and now - asked >= PATIENCE:
            self.end("Pause or Reset ended it")
        elif not isinstance(driver.runner, Playback) and self._is_mended(driver.runner._folder):
            self.end("its file has changed")
            if driver.state == "running" and not driver.is_stopped:
                driver.start()

    def _is_mended(self, folder: Any) -> bool:
        return self.told is not None and folder is not None and bool(folder.changed)
