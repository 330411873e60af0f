"""What is told of the whole record as it grows: once a second or less often, and on pause."""

from __future__ import annotations

import math
import time
from abc import abstractmethod
from typing import TYPE_CHECKING, Any

from robsim.gui._link import Link
from robsim.gui._panel.part import Part
from robsim.trace import Trace

if TYPE_CHECKING:
    from robsim.gui._panel.view import PanelView

_GAP = 1.0  # s
_SHARE = 0.1  # of the time of the view's thread at the most, while it runs


class Summary(Part):
    """Sends a message that is computed from the whole record."""

    def __init__(self, panel: PanelView) -> None:
        super().__init__(panel)
        self._newest: dict[str, Any] | None = None
        self._seen: tuple[int, int] | None = None  # resets and steps that it was computed from
        self._due = 0.0
        self._gap = _GAP

    @abstractmethod
    def message(self, trace: Trace) -> dict[str, Any]:
        """Return the message."""

    def greet(self, link: Link) -> None:
        if self._newest is None:
            self._due = 0.0
        else:
            link.send(self._newest)

    def changed(self) -> None:
        self._seen, self._due = None, 0.0

    def look(self, now: float) -> float:
        record, is_running = self.panel.record, self.panel.is_running
        seen = record.n_resets, record.n_steps
        if now < self._due and (is_running or seen == self._seen):
            return self._due
        if seen != self._seen and any(link.is_watched for link in self.panel.links):
            self._seen = seen
            began = time.monotonic()
            self._newest = self.message(record.trace)
            self._gap = max(_GAP, (time.monotonic() - began) / _SHARE)
            self.panel.send(self._newest)
        self._due = now + self._gap if is_running else math.inf
        return self._due
