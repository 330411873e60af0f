"""The camera view: the newest frame for the browsers, as fast as they have room."""

from __future__ import annotations

import math
import time
from typing import TYPE_CHECKING, Any

from robsim._core import Step
from robsim.gui._frames import FrameClock
from robsim.gui._link import SLOW, Link
from robsim.gui.panels.part import Handlers, Part
from robsim.gui.panels.run.pictures import Shot, picture_of

if TYPE_CHECKING:
    from robsim.gui.panels.view import PanelView


class CameraView(Part):
    """Sends the newest step as a picture, with what is drawn over it."""

    _taken: Shot | None = None  # in the thread of the run
    _is_told = False  # the thread of the view that there is one
    _newest: Shot | None = None

    def __init__(self, panel: PanelView) -> None:
        super().__init__(panel)
        self._clock = FrameClock()

    def handlers(self) -> Handlers:
        return {"grant": self._grant, "size": self._size}

    def setup(self) -> dict[str, Any]:
        record = self.panel.record
        return {
            "area": record.area,
            "robot": {"name": record.robot_name, "outline": record.outline.tolist()},
        }

    def take(self, step: Step) -> None:
        is_running, is_watched = self.panel.is_running, self.panel.is_watched
        if is_running and (
            time.monotonic() < self._clock.due if is_watched else self._taken is None
        ):
            return
        # Whoever comes while it runs is not to see the last step that somebody has watched.
        self._taken = self.panel.record.shot(step) if is_watched or not is_running else None
        if not self._is_told:  # a view that is busy is not to find the frames of a hundred steps
            self._is_told = True
            self.panel.post(self._show)

    def greet(self, link: Link) -> None:
        link.shown = None
        if self._shot is None and self.panel.has_room():
            self.panel.driver.prepare()

    @property
    def _shot(self) -> Shot | None:
        """What is to be shown; None if that is of a run before a reset."""
        shot = self._newest
        return shot if shot and shot.n_resets == self.panel.record.n_resets else None

    def look(self, now: float) -> float:
        shot = self._shot
        links = [link for link in self.panel.links if link.looking is None]
        lacking = [link for link in links if link.lacks(shot)]
        if shot is None or not lacking:
            return math.inf
        if ready := [link for link in lacking if link.has_room(now)]:
            self._clock.sent(now)
            self._send(shot, ready, now)
        return math.inf if len(ready) == len(lacking) else now + SLOW

    def encode(self, shot: Shot, width: int) -> bytes:
        return picture_of(shot.frame, width)

    def _show(self) -> None:
        self._is_told = False  # before it is looked at: what is taken after that is told again
        self._newest = self._taken

    def _send(self, shot: Shot, links: list[Link], now: float) -> None:
        pictures: dict[int, bytes] = {}
        head = shot.head(self.panel.record.area)
        brings_rows = self.panel.rows.is_due(now)
        for link in links:
            if link.width not in pictures:
                pictures[link.width] = self.encode(shot, link.width)
            entries, blocks = self.panel.rows.new(link) if brings_rows else ([], [])
            link.shown = shot
            link.send_frame({**head, "rows": entries}, [pictures[link.width], *blocks], now)
        self.panel.past.keep(shot, pictures)
        if brings_rows:
            self.panel.rows.sent(now, links)

    def _grant(self, link: Link, message: dict[str, Any]) -> None:
        is_back = not link.is_watched  # though it was taken to have gone
        link.grant(message["id"], message["upto"], late=message["late"])
        if is_back:
            link.forget_rows()
            self.panel.tell(link)

    def _size(self, link: Link, message: dict[str, Any]) -> None:
        link.resize(message["width"])
        link.shown = None  # as sharp as it is shown now
