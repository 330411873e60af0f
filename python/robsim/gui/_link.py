"""A line from Python to one browser page, or one widget."""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

Buffers = Sequence[bytes]

_FORGET = 10.0  # s after which a view that says nothing, while others do, is gone
_MOST_VIEWS = 20
_WIDEST = 1 << 14  # px of a picture
_MOST_REFUSALS = 10  # that are answered in a second
SLOW = 0.3  # s between frames that are sent though nobody grants room


class Link(ABC):
    """A line to one browser page, or to one widget, which may be shown more than once.

    The views on it grant room for frames in advance: what a slow one has no room for is left out
    for it, and nothing else waits. Only the thread of a `View` uses it.
    """

    is_in_notebook: ClassVar[bool] = False
    keeps_still: ClassVar[bool] = False  # whether it has a place for a picture that stays

    def __init__(self) -> None:
        self.sent = 0  # frames
        self.rows: dict[str, int] = {}  # group of columns -> the next row to be sent
        self.n_resets = 0  # of the record, when the last ones were sent
        self.width = 600  # of the picture on the screen (px)
        self.shown: object = None  # what was sent as the newest frame
        self.looking: int | None = None  # the past step that it shows; None = the newest
        self._grants: dict[str, int] = {}  # view -> the last frame that it has room for
        self._heard: dict[str, float] = {}
        self._last_frame = 0.0
        self._n_late = 0  # grants in a row of a view that waits for frames that were sent
        self._arrived = 0  # frames that had been sent when it last waited for none, or got one
        self._upto: int | None = None  # the newest grant, which is greater when a frame has come
        self._refused: deque[float] = deque(maxlen=_MOST_REFUSALS)  # when
        self.n_waiting = 0  # messages of its views; with the lock of the `View` held
        self.bytes_waiting = 0  # of their buffers, as that
        self.is_gone = False  # nothing can be sent any more

    @abstractmethod
    def transmit(self, head: Mapping[str, Any], buffers: Buffers) -> None:
        """Bring a message to the other end, without waiting; the host says how.

        An OSError or a RuntimeError says that there is no other end any more.
        """

    def send(self, head: Mapping[str, Any], buffers: Buffers = ()) -> None:
        """Send a message; if nobody is there any more, it is lost."""
        if self.is_gone:
            return
        try:
            self.transmit(head, buffers)
        except (OSError, RuntimeError):
            self.is_gone = True

    def refuse(self, why: str) -> None:
        """Say why a message was refused, unless that is said all the time."""
        now = time.monotonic()
        if len(self._refused) < _MOST_REFUSALS or now - self._refused[0] > 1.0:
            self._refused.append(now)
            self.send({"type": "note", "level": "error", "text": why})

    def keep(self, picture: bytes) -> None:
        """Keep a picture (PNG) for when Python is gone, in place of an earlier one."""
        raise NotImplementedError  # where `keeps_still` is false

    @property
    def is_watched(self) -> bool:
        """Whether a view has said hello and not bye."""
        return bool(self._grants)

    def greet(self, view: str) -> None:
        """Note that a view has appeared: it wants everything, and has room for a frame.

        Of too many views the one that was silent for longest is forgotten.
        """
        if len(self._heard) >= _MOST_VIEWS and view not in self._heard:
            self.part(min(self._heard, key=self._heard.__getitem__))
        self.forget_rows()
        self.grant(view, self.sent + 1)
        self._upto = None

    def forget_rows(self) -> None:
        """Note that a view may lack rows that were sent: they are sent again."""
        self.rows = dict.fromkeys(self.rows, 0)

    def grant(self, view: str, upto: int, *, late: bool = False) -> None:
        """Note that a view has room for frames up to a number; `late`: it waits for one."""
        now = time.monotonic()
        has_got_one = self._upto is not None and upto > self._upto
        if not late or has_got_one:
            self._n_late, self._arrived = 0, self.sent
        elif self.sent > self._arrived:
            self._n_late += 1
        self._upto = upto
        self._grants[view], self._heard[view] = upto, now
        for other in [v for v, heard in self._heard.items() if now - heard > _FORGET]:
            self.part(other)  # such as one whose page was closed without a bye

    def resize(self, width: int) -> None:
        """Note how wide the picture is on the screen (px)."""
        self.width = min(max(1, width), _WIDEST)

    def part(self, view: str) -> None:
        """Note that a view has gone."""
        self._grants.pop(view, None)
        self._heard.pop(view, None)

    @property
    def is_behind(self) -> bool:
        """Whether much is on its way: what is large waits; any thread may ask."""
        return False  # where that is not known

    def lacks(self, newest: object) -> bool:
        return self.is_watched and self.shown is not newest

    def has_room(self, now: float) -> bool:
        """Return whether a frame may be sent.

        Where no answer comes, as from a notebook while a cell runs, frames go on slowly.
        """
        if not self._grants:
            return False
        return min(self._grants.values()) > self.sent or now - self._last_frame > SLOW

    def send_frame(self, head: Mapping[str, Any], buffers: Buffers, now: float) -> None:
        """Send a frame with its number, and with the time, from which a view sees a line fill."""
        self.sent += 1
        self._last_frame = now
        self.send({**head, "n": self.sent, "sent": 1000 * time.time()}, buffers)
