"""The base of a panel: a thread that talks to browsers, and the links to them."""

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

_MOST_WAITING = 500  # messages of a link; further messages of this link are dropped
_MOST_BYTES_WAITING = 1 << 22  # of a link's buffers; the rest is dropped
_MOST_IN_A_ROW = 50  # jobs before the next look at due work.
_LATER = 3600.0  # s until the next look at the latest
_MOST_LAST = 50  # messages at the end
_BEAT = 2.0  # s without a message, after which a view gets a sign of life.
RETRY = 1.0  # s before a retry after a failure in `look`


class View(Worker):
    """State in Python, shown by browsers that only know messages (see PROTOCOL.md).

    Everything runs in one thread: there are no locks, and hosts and runs never wait.
    """

    _thread_name = "robsim view"

    #: The view of the browser's module that shows this class.
    kind: ClassVar[str]
    #: The accepted messages of a browser.
    messages: ClassVar[Messages]

    def __init__(self) -> None:
        super().__init__()
        self.links: list[Link] = []
        self._besides: list[Beside] = []
        self._next_look = math.inf  # time of the next work without a job
        self._in_a_row = 0
        self._last: LastWords | None = None

    # For hosts: any thread.

    def connect(self, link: Link) -> None:
        """Add a link; the first message follows the hello of a view."""
        if not self.post(lambda: self.links.append(link)) and self._last is not None:
            link.end(self._last)

    def disconnect(self, link: Link) -> None:
        self.post(lambda: self._disconnect(link))

    def receive(self, link: Link, message: Any, buffers: Buffers = ()) -> None:
        """Take a message of a browser, and its buffers, which `message` does not contain."""
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
        """Wait for the end of all work received so far; in the thread itself, do not wait."""
        done = threading.Event()
        if not self.is_here and self.post(done.set):
            done.wait()

    def is_urgent(self, message: Any) -> bool:
        """Return whether a message of any form precedes all waiting messages."""
        return False

    def close(self, timeout: float = 5.0) -> bool:
        has_ended = super().close(timeout)
        for beside in self._besides:
            beside.wait(timeout)
        return has_ended

    def beside(self, name: str) -> Beside:
        """Return a helper that computes in a thread of this name; `close` waits for the thread."""
        self._besides.append(Beside(self, name))
        return self._besides[-1]

    # In the thread.

    def _finish(self) -> None:
        """Send the last state to all views, and store it for later ones."""
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
        """Send the last messages to this link, if the view has any."""

    def send(self, head: Mapping[str, Any], *buffers: bytes) -> None:
        for link in self.links:
            if link.is_watched:
                link.send(head, buffers)

    def note(self, text: str, level: str = "error") -> None:
        """Show a text in all connected views; from any thread."""
        self.post(lambda: self.send({"type": "note", "level": level, "text": text}))

    @property
    def is_watched(self) -> bool:
        return any(link.is_watched for link in self.links)

    def handlers(self) -> Mapping[str, Callable[[Link, dict[str, Any]], None]]:
        """Return the handlers by message type."""
        own = {"hello": self._hello, "bye": self._bye}
        return {**own, "grant": self._grant, "size": self._size}

    @abstractmethod
    def tell(self, link: Link) -> None:
        """Send everything to a view that is new, or returns after a timeout."""

    def look(self, now: float) -> float:
        """Do the due work; return the time of the next look."""
        return math.inf

    @abstractmethod
    def parted(self) -> None:
        """React to the disconnection of the last view."""

    @abstractmethod
    def snapshot(self) -> bytes:
        """Return a still picture of the view (PNG); any thread may call this."""

    def handle(self, link: Link, message: Any, buffers: Buffers = ()) -> None:
        """Handle a message; its field `buffers` holds any buffers."""
        try:
            checked = checked_message(message, self.messages, buffers)
            handler = self.handlers().get(checked["type"])
            if handler is None:
                raise Refused(f"{self.kind} accepts no message {checked['type']!r}")
            handler(link, checked)
        except Refused as error:
            link.refuse(str(error))

    def forget(self, kind: str) -> None:
        """Drop the waiting messages of a type."""
        with self._wake:
            jobs, self._jobs = self._jobs, deque()
            for job in jobs:
                if isinstance(job, _Received) and job.is_of(kind):
                    job.count(-1)
                else:
                    self._jobs.append(job)

    def report(self, error: BaseException) -> bool:
        """Report an internal error, also to the browsers."""
        is_new = super().report(error)
        if is_new:
            self.note(f"Internal error of the panel: {said_by(error)}")
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
        """Send a sign of life to silent links; return the time of the next one."""
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
        is_back = not link.is_watched  # after a timeout
        link.grant(message["id"], message["upto"], late=message["late"])
        if is_back:
            link.forget_rows()
            self.tell(link)

    def _size(self, link: Link, message: dict[str, Any]) -> None:
        link.resize(message["width"])
        link.shown = None  # send it again at the new resolution

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
    """A waiting message."""

    def __init__(self, view: View, link: Link, message: Any, buffers: Buffers) -> None:
        self._view, self.link, self._message, self._buffers = view, link, message, buffers

    def __call__(self) -> None:
        with self._view._wake:
            self.count(-1)
        self._view.handle(self.link, self._message, self._buffers)

    def count(self, sign: int) -> None:
        """Add or subtract the message in its link's counts; with the lock of the view held."""
        self.link.n_waiting += sign
        self.link.bytes_waiting += sign * sum(map(len, self._buffers))

    def is_of(self, kind: str) -> bool:
        return isinstance(self._message, dict) and self._message.get("type") == kind
