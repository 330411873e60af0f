"""What is told of the whole record as it grows: once a second or less often, and on pause."""

from __future__ import annotations

import math
import time
from abc import abstractmethod
from typing import TYPE_CHECKING, Any

from robsim.gui._beside import Beside
from robsim.gui._link import Link
from robsim.gui.panels.part import Part
from robsim.trace import Trace

if TYPE_CHECKING:
    from robsim.gui.panels.view import PanelView

_GAP = 1.0  # s
_SHARE = 0.1  # of the time at the most, while it runs


class Summary(Part):
    """Sends a message that is computed from the whole record, beside the thread of the view."""

    def __init__(self, panel: PanelView) -> None:
        super().__init__(panel)
        self._newest: dict[str, Any] | None = None
        self._seen: tuple[int, int] | None = None  # resets and steps that it was computed from
        self._since = -math.inf  # when it was last looked for what is new
        self._gap = _GAP
        self._beside = Beside(panel, f"robsim {type(self).__name__.lower()}")

    @abstractmethod
    def message(self, trace: Trace) -> dict[str, Any]:
        """Return the message; in a thread of its own."""

    def greet(self, link: Link) -> None:
        if self._newest is None:
            self._since = -math.inf
        else:
            link.send(self._newest)

    def changed(self) -> None:
        self._seen, self._since = None, -math.inf

    def close(self, timeout: float) -> None:
        self._beside.wait(timeout)

    def look(self, now: float) -> float:
        if self._beside.is_busy:
            return math.inf  # until it is done
        record, is_running = self.panel.record, self.panel.is_running
        seen = record.n_resets, record.n_steps
        due = self._since + self._gap if is_running else math.inf
        if now < due and (is_running or seen == self._seen):
            return due
        if seen != self._seen and any(link.is_watched for link in self.panel.links):
            self._seen = seen
            self._begin(seen[0], record.trace)
        self._since = now
        return now + self._gap if is_running else math.inf

    def _begin(self, n_resets: int, trace: Trace) -> None:
        def timed() -> tuple[dict[str, Any], float]:
            began = time.monotonic()
            return self.message(trace), time.monotonic() - began

        def take(result: tuple[dict[str, Any], float] | None) -> None:
            if result is not None and n_resets == self.panel.record.n_resets:
                self._newest, took = result
                self._gap = max(_GAP, took / _SHARE)
                self.panel.send(self._newest)

        self._beside.begin(timed, take)
