"""The traces: new rows of the record for the browsers."""

from __future__ import annotations

import math
from collections.abc import Container
from typing import Any

import numpy as np

from robsim.gui._link import Link, Refused
from robsim.gui.panels.part import Handlers, Part

_GAP = 0.1  # s between two updates
_MOST_GROUPS = 100  # of columns for a line
_MOST_BYTES = 1 << 22  # of a message: a frame waits for the previous messages
_NONE = np.empty((0, 0))


class Rows(Part):
    """Sends the rows of the groups of columns that a view requests."""

    _due = 0.0
    _told: dict[str, Any] | None = None

    def handlers(self) -> Handlers:
        return {"columns": self._columns}

    def setup(self) -> dict[str, Any]:
        self._told = self.panel.record.described()
        return self._told

    def changed(self) -> None:
        # A start may define another model, and a reset read another file.
        if self._told is not None and self.panel.record.described() != self._told:
            self.panel.tell_setup()

    def look(self, now: float) -> float:
        if now < self._due:
            return self._due
        self._due = now + _GAP
        for link in self.panel.links:
            self.send(link)
        is_over = not self.panel.is_running and not any(map(self._lacks, self.panel.links))
        return math.inf if is_over else self._due

    def is_due(self, now: float) -> bool:
        """Return whether rows may travel with a frame: separate messages cost more."""
        return now >= self._due or not self.panel.is_running

    def sent(self, now: float, links: Container[Link]) -> None:
        """Note that a frame brought rows to `links`; views of past steps get separate messages."""
        self._due = now + _GAP
        for link in self.panel.links:
            if link.looking is not None and link not in links:
                self.send(link)

    def send(self, link: Link) -> None:
        """Send the missing rows of a link."""
        entries, blocks = self.new(link)
        if entries and link.is_watched:
            link.send({"type": "rows", "rows": entries}, blocks)

    def new(self, link: Link) -> tuple[list[dict[str, Any]], list[bytes]]:
        """Return rows that a link lacks, as entries and blocks, and count them as sent.

        A long record begins with its first rows; the others follow.
        """
        record, entries, blocks = self.panel.record, [], []
        room = 0 if link.is_behind else _MOST_BYTES
        before, link.n_resets = link.n_resets, record.n_resets
        columns = record.columns()
        for name, sent in link.rows.items():
            rows = columns.get(name, _NONE)
            is_other = link.n_resets != before and sent > 0
            if len(rows) == sent and not is_other:
                continue
            first = 0 if is_other or len(rows) < sent else sent
            end = min(len(rows), first + room // (4 * max(1, rows.shape[1])))
            link.rows[name] = end
            if first == end < len(rows) and not is_other:
                continue
            with np.errstate(over="ignore"):  # of an estimate that runs away: inf
                block = np.ascontiguousarray(rows[first:end], dtype="<f4")
            entries.append({"column": name, "first": first, "width": rows.shape[1]})
            blocks.append(block.tobytes())
            room -= block.nbytes
        return entries, blocks

    def _lacks(self, link: Link) -> bool:
        """Return whether a link lacks rows."""
        columns = self.panel.record.columns()
        return any(len(columns.get(name, _NONE)) != sent for name, sent in link.rows.items())

    def _columns(self, link: Link, message: dict[str, Any]) -> None:
        rows = link.rows | dict.fromkeys(message["names"], 0)
        if len(rows) > _MOST_GROUPS:
            raise Refused(f"at most {_MOST_GROUPS} groups of columns are sent")
        link.rows = rows
        self._due = 0.0
