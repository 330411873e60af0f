"""What a panel is made of: a thread that talks to browsers, and the lines to them."""

from __future__ import annotations

import math
import threading
import time
from abc import abstractmethod
from collections import deque
from collections.abc import Callable, Mapping
from typing import Any, ClassVar

from robsim.base.text import said_by
from robsim.gui._link import Buffers, LastWords, Link, Messages, Refused, checked_message
from robsim.gui._worker import Beside, Worker

_MOST_WAITING = 500  # messages of a line; whoever sends more is not listened to, others are
_MOST_BYTES_WAITING = 1 << 22  # of a line's buffers; what comes beyond that is thrown away
_MOST_IN_A_ROW = 50  # jobs, before it looks for what is due
_LATER = 3600.0  # s: by then all is due
_MOST_LAST = 50  # messages at the end
_BEAT = 2.0  # s without a message, after which a view gets a sign of life
RETRY = 1.0  # s until what failed in `look` is tried again


class View(Worker):
    """State in Python, shown by browsers that only know messages (see PROTOCOL.md).

    All happens in one thread: there are no locks, and hosts and runs never wait.
    """

    _thread_name = "robsim view"

    #: Which view of the module in the browser shows it.
    kind: ClassVar[str]
    #: What it takes of a browser.
    messages: ClassVar[Messages]

    def __init__(self) -> None:
        super().__init__()
        self.links: list[Link] = []
        self._besides: list[Beside] = []
        self._next_look = math.inf  # when there is something to do without a job
        self._in_a_row = 0
        self._last: LastWords | None = None

    # For hosts: any thread.

    def connect(self, link: Link) -> None:
        """Add a line; it is told something once a view on it says hello."""
        if not self.post(lambda: self.links.append(link)) and self._last is not None:
            link.end(self._last)

    def disconnect(self, link: Link) -> None:
        self.post(lambda: self._disconnect(link))

    def receive(self, link: Link, message: Any, buffers: Buffers = ()) -> None:
        """Take a message of a browser, and its buffers, of which `message` says nothing."""
        is_urgent = self.is_urgent(message)
        with self._wake:
            if link.n_waiting < _MOST_WAITING * (2 if is_urgent else 1):
                if link.bytes_waiting + sum(map(len, buffers)) > _MOST_BYTES_WAITING:
                    buffers = ()
                received = _Received(self, link, message, buffers)
                if self.post(received, first=is_urgent):
                    received.count(1)
                else:
                    link.late(message)

    def settle(self) -> None:
        """Wait until all is done that was received by now; in the thread itself it does not."""
        done = threading.Event()
        if not self.is_here and self.post(done.set):
            done.wait()

    def is_urgent(self, message: Any) -> bool:
        """Return whether a message, which may be anything, comes before all that waits."""
        return False

    def close(self, timeout: float = 5.0) -> bool:
        has_ended = super().close(timeout)
        for beside in self._besides:
            beside.wait(timeout)
        return has_ended

    def beside(self, name: str) -> Beside:
        """Return what computes in a thread of this name; `close` waits for it."""
        self._besides.append(Beside(self, name))
        return self._besides[-1]

    # In the thread.

    def _finish(self) -> None:
        """Tell all the last state, and keep it for those who come later."""
        self._last = last = LastWords()
        if not self.links:
            return
        last.width = max(link.width for link in self.links)
        self.links.append(last)
        self.guarded(self.farewell, last)
        self.guarded(self.tell, last)
        now, said = time.monotonic(), -1
        while said < len(last.messages) < _MOST_LAST:
            said, now = len(last.messages), now + _LATER
            self.guarded(self.look, now)
        self.send({"type": "closed"})
        self.links.remove(last)
        for link in self.links:
            link.end(last)

    def farewell(self, last: Link) -> None:
        """Prepare the last messages, which this line gets; not all views need to."""

    def send(self, head: Mapping[str, Any], *buffers: bytes) -> None:
        for link in self.links:
            if link.is_watched:
                link.send(head, buffers)

    def note(self, text: str, level: str = "error") -> None:
        """Tell all who watch something; from any thread."""
        self.post(lambda: self.send({"type": "note", "level": level, "text": text}))

    @property
    def is_watched(self) -> bool:
        return any(link.is_watched for link in self.links)

    def handlers(self) -> Mapping[str, Callable[[Link, dict[str, Any]], None]]:
        """Return what is done with each type of message."""
        own = {"hello": self._hello, "bye": self._bye}
        return {**own, "grant": self._grant, "size": self._size}

    @abstractmethod
    def tell(self, link: Link) -> None:
        """Tell everything to a view that is new, or was taken to have gone."""

    def look(self, now: float) -> float:
        """Do what is due; return when to look again."""
        return math.inf

    @abstractmethod
    def parted(self) -> None:
        """Do what is to be done when the last view has gone."""

    @abstractmethod
    def snapshot(self) -> bytes:
        """Return a still picture of the view (PNG); any thread may ask."""

    def handle(self, link: Link, message: Any, buffers: Buffers = ()) -> None:
        """Do what a message asks for; its buffers are its field `buffers`, where it has one."""
        try:
            checked = checked_message(message, self.messages, buffers)
            handler = self.handlers().get(checked["type"])
            if handler is None:
                raise Refused(f"{self.kind} takes no message {checked['type']!r}")
            handler(link, checked)
        except Refused as error:
            link.refuse(str(error))

    def forget(self, kind: str) -> None:
        """Forget the messages of a type that wait."""
        with self._wake:
            jobs, self._jobs = self._jobs, deque()
            for job in jobs:
                if isinstance(job, _Received) and job.is_of(kind):
                    job.count(-1)
                else:
                    self._jobs.append(job)

    def report(self, error: BaseException) -> bool:
        """Tell of a mistake of ours, the browsers too."""
        is_new = super().report(error)
        if is_new:
            self.note(f"A mistake in the panel itself: {said_by(error)}")
        return is_new

    def _due(self) -> float:
        return self._next_look

    def _do_due(self) -> None:
        self._in_a_row = _MOST_IN_A_ROW

    def _rest(self) -> None:
        self._in_a_row += 1
        if self._jobs and self._in_a_row < _MOST_IN_A_ROW:
            return
        self._in_a_row = 0
        for link in [link for link in self.links if link.is_gone]:
            self.guarded(self._disconnect, link)
        now = time.monotonic()
        due = self.guarded(self.look, now)
        self._next_look = min(now + RETRY if due is None else due, self._beat(now))

    def _beat(self, now: float) -> float:
        """Give silent lines a sign of life; return the time of the next one."""
        watched = [link for link in self.links if link.is_watched]
        for link in watched:
            if now - link.said >= _BEAT:
                link.send({"type": "alive"})
        return min((link.said for link in watched), default=math.inf) + _BEAT

    def _hello(self, link: Link, message: dict[str, Any]) -> None:
        link.greet(message["id"])
        link.resize(message["width"])
        self.tell(link)

    def _grant(self, link: Link, message: dict[str, Any]) -> None:
        is_back = not link.is_watched  # though it was taken to have gone
        link.grant(message["id"], message["upto"], late=message["late"])
        if is_back:
            link.forget_rows()
            self.tell(link)

    def _size(self, link: Link, message: dict[str, Any]) -> None:
        link.resize(message["width"])
        link.shown = None  # as sharp as it is shown now

    def _bye(self, link: Link, message: dict[str, Any]) -> None:
        was_watched = self.is_watched
        link.part(message["id"])
        if was_watched and not self.is_watched:
            self.parted()

    def _disconnect(self, link: Link) -> None:
        if link not in self.links:
            return
        self.links.remove(link)
        if link.is_watched and not self.is_watched:
            self.parted()


class _Received:
    """A message that waits."""

    def __init__(self, view: View, link: Link, message: Any, buffers: Buffers) -> None:
        self._view, self.link, self._message, self._buffers = view, link, message, buffers

    def __call__(self) -> None:
        with self._view._wake:
            self.count(-1)
        self._view.handle(self.link, self._message, self._buffers)

    def count(self, sign: int) -> None:
        """Count it among what waits on its line, or no more; with the lock of the view held."""
        self.link.n_waiting += sign
        self.link.bytes_waiting += sign * sum(map(len, self._buffers))

    def is_of(self, kind: str) -> bool:
        return isinstance(self._message, dict) and self._message.get("type") == kind
