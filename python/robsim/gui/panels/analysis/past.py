"""Past steps: their frames, and the reason why no robot was found."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from concurrent.futures import CancelledError
from typing import TYPE_CHECKING, Any

from robsim._core import Frame
from robsim.gui._driver import Playback, State
from robsim.gui._link import SLOW, Link
from robsim.gui.panels.part import Handlers, Part
from robsim.gui.panels.run.camera import Shot, past_shot, picture_of

if TYPE_CHECKING:
    from robsim.gui.panels.view import PanelView

_GAP = 1 / 30  # s between two answers
_MOST_KEPT = 64 << 20  # bytes of pictures

Then = Callable[[Frame | None, str | None], None]


class Past(Part):
    """Shows the frame of a past step to views that look at it; new frames of these views wait.

    Frames of a simulation are drawn again, frames of files read again. For a camera, the sent
    pictures are kept up to a limit of memory.
    """

    def __init__(self, panel: PanelView) -> None:
        super().__init__(panel)
        self._kept = KeptPictures(_MOST_KEPT)
        self._wanted: dict[Link, int] = {}  # the newest request of each
        self._is_asking = False
        self._due = 0.0
        self._state: State = "paused"
        self._n_resets = panel.record.n_resets  # when the pictures were shown

    def handlers(self) -> Handlers:
        return {"look": self._look}

    def keep(self, shot: Shot, pictures: Mapping[int, bytes]) -> None:
        """Keep the largest picture of a shown step, if its frame is unavailable later."""
        if shot.frame is None or not self.panel.record.has_frames_once:
            return
        if shot.n_resets == self._n_resets:
            self._kept.add(shot.head(self.panel.record.area), pictures[max(pictures)])

    def changed(self) -> None:
        state, before = self.panel.driver.state, self._state
        self._state = state
        is_played = isinstance(self.panel.runner, Playback)
        begins = is_played and state == "running" and before != "running"
        n_resets = self.panel.record.n_resets
        if n_resets != self._n_resets:
            self._n_resets, begins = n_resets, True
            self._kept = KeptPictures(_MOST_KEPT)
        for link in self.panel.links:
            if begins and link.looking is not None:
                self._release(link)

    def look(self, now: float) -> float:
        self._wanted = {link: k for link, k in self._wanted.items() if link in self.panel.links}
        if not self._wanted or self._is_asking:
            return math.inf
        if now < self._due:
            return self._due
        ready = [link for link in self._wanted if link.has_room(now)]
        if not ready:
            return now + SLOW
        self._due = now + _GAP
        self._show(ready[0], self._wanted.pop(ready[0]))
        return self._due

    def greet(self, link: Link) -> None:
        self._release(link)

    def ask(self, k: int, then: Then) -> None:
        """Get the frame of a step; call `then` with the frame or with the reason against it."""
        record = self.panel.record
        if record.reads_in_run:
            asked = self.panel.driver.call(lambda: record.frame(k))
            asked.add_done_callback(
                lambda done: self.panel.post(lambda: then(*_result(done.result)))
            )
        else:
            then(*_result(lambda: record.frame(k)))

    def _look(self, link: Link, message: dict[str, Any]) -> None:
        k, n_steps = message["k"], self.panel.record.n_steps
        self._wanted.pop(link, None)
        if k is None:
            self._release(link)
        elif k >= n_steps:
            last = f"the last step is {n_steps - 1}" if n_steps else "nothing has run yet"
            link.send({"type": "past", "k": k, "reason": f"there is no step {k}: {last}"})
        else:
            link.looking = self._wanted[link] = k
            if isinstance(self.panel.runner, Playback):  # it continues from there
                self.panel.driver.call(lambda: self.panel.runner.seek(k))

    def _release(self, link: Link) -> None:
        self._wanted.pop(link, None)
        link.looking = link.shown = None

    def _show(self, link: Link, k: int) -> None:
        def answer(frame: Frame | None, reason: str | None) -> None:
            self._is_asking = False
            if link.looking is not None and k < self.panel.record.n_steps:
                self._answer(link, k, frame, reason)

        self._is_asking = True
        self.ask(k, answer)

    def _answer(self, link: Link, k: int, frame: Frame | None, reason: str | None) -> None:
        kept = self._kept.get(k) if frame is None else None
        link.frame = frame
        if kept is not None:
            head, picture = kept
        else:
            shot = past_shot(self.panel.record, k, frame)
            head, picture = shot.head(self.panel.record.area), picture_of(frame, link.width)
        link.send_frame({**head, "past": True, "rows": []}, [picture], time.monotonic())
        if not picture:
            link.send({"type": "past", "k": k, "reason": reason or "this step has no frame"})


def _result(frame: Callable[[], Frame | None]) -> tuple[Frame | None, str | None]:
    try:
        return frame(), None
    except CancelledError:
        return None, "the panel is closed"
    except Exception as error:
        return None, str(error) or type(error).__name__


class KeptPictures:
    """The newest pictures, up to a limit of memory."""

    def __init__(self, room: int) -> None:
        self._room = room
        self._used = 0
        self._pictures: dict[int, tuple[dict[str, Any], bytes]] = {}  # the oldest one first

    def __len__(self) -> int:
        return len(self._pictures)

    def get(self, k: int) -> tuple[dict[str, Any], bytes] | None:
        """Return head and picture of a step; None if they are missing or removed."""
        return self._pictures.get(k)

    def add(self, head: dict[str, Any], picture: bytes) -> None:
        """Add head and picture of a step; remove the oldest to make room."""
        self._drop(head["k"])
        self._pictures[head["k"]] = head, picture
        self._used += len(picture)
        while self._used > self._room:
            self._drop(next(iter(self._pictures)))

    def _drop(self, k: int) -> None:
        _, picture = self._pictures.pop(k, ({}, b""))
        self._used -= len(picture)
