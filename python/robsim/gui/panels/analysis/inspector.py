"""The inspector: a step as a tree."""

from __future__ import annotations

from typing import Any

from robsim._core import Frame, Step
from robsim.gui._link import Link
from robsim.gui.panels.analysis.tree import child_of, nodes_of
from robsim.gui.panels.part import Handlers, Part


class Inspector(Part):
    """Tells what a step holds, level by level."""

    _newest: tuple[int, Step] | None = None  # resets before it, and the step
    _past: Step | None = None  # the last one that somebody asked for

    def handlers(self) -> Handlers:
        return {"inspect": self._inspect}

    def take(self, step: Step) -> None:
        self._newest = self.panel.record.n_resets, step

    def changed(self) -> None:
        self._past = None  # after a reset it is another one

    def _inspect(self, link: Link, message: dict[str, Any]) -> None:
        newest, path, n_steps = self._newest_step(), message["path"], self.panel.record.n_steps
        k = n_steps - 1 if message["k"] is None else message["k"]
        if newest is not None and (message["k"] is None or k == newest.k):
            _tell(link, newest, path)
        elif not 0 <= k < n_steps:
            _tell(link, None, path)
        elif self._past is not None and self._past.k == k:
            _tell(link, self._past, path)
        else:
            self.panel.check_room()
            self.panel.past.ask(k, lambda frame, _: self._tell_past(link, k, path, frame))

    def _newest_step(self) -> Step | None:
        """Return the newest step; None if it is of a run before a reset, after which none came."""
        n_resets, step = self._newest or (-1, None)
        return step if n_resets == self.panel.record.n_resets else None

    def _tell_past(self, link: Link, k: int, path: list[str], frame: Frame | None) -> None:
        if k < self.panel.record.n_steps:
            self._past = self.panel.record.step(k, frame)
            _tell(link, self._past, path)


def _tell(link: Link, step: Step | None, path: list[str]) -> None:
    """Send a level of the tree of a step; nothing in it if there is no such level."""
    value: Any = step
    try:
        for name in path:
            value = child_of(value, name)
        nodes = nodes_of(value)
    except KeyError:
        nodes = []
    k = None if step is None else step.k
    link.send({"type": "tree", "k": k, "path": path, "nodes": nodes})
