"""The private doors of a panel, and browsers of tests: what is said to it, and what it says."""

import json
import threading
import time
from contextlib import contextmanager

import numpy as np

from robsim.gui._link import Link
from robsim.gui.hosts.page import Page
from robsim.gui.panels.view import PanelView
from robsim.gui.tools.floor.corners import floor_to_pixels, tiled_floor
from waiting import wait_for

__all__ = ["Link", "Page", "PanelView", "pixels_of_floor", "tiled_floor"]

_PATIENCE = 300  # s


def pixels_of_floor(places):
    """Where the camera of the example shows places (N, 2) on the floor (mm)."""
    mapped = np.column_stack([places, np.ones(len(places))]) @ floor_to_pixels().T
    return mapped[:, :2] / mapped[:, 2:]


class FakeBrowser(Link):
    """The only view on its line; it has room for so many frames, and grants no more by itself."""

    def __init__(self, view, width=300, *, name="fake", room=10**9):
        super().__init__()
        self.name = name
        self.view = view
        self._told = []
        self._news = threading.Condition()
        view.connect(self)
        self.say("hello", width=width)
        self.say("grant", upto=room, late=False)

    def transmit(self, head, buffers):
        json.dumps(head, allow_nan=False)  # as the hosts do
        with self._news:
            self._told.append((dict(head), list(buffers)))
            self._news.notify()

    def say(self, kind, *buffers, **fields):
        self.view.receive(self, {"type": kind, "id": self.name, **fields}, buffers)

    def upload(self, content, name="photo.png", *, key="1", part=1 << 19):
        """Send a file, each part when the one before was answered; return the last answer."""
        for at in range(0, len(content), part):
            about = {"key": key, "name": name, "size": len(content), "at": at}
            self.say("upload", content[at : at + part], **about)
            answer, _ = self.take("uploaded", key=key)
            if answer["state"] != "more":
                break
        return self.take("uploaded", key=key)[0] if answer["state"] == "read" else answer

    def press(self, button):
        self.say("press", button=button)

    def take(self, kind, **fields):
        """Wait for a message with these fields; what came before it is forgotten."""
        return self._take(kind, lambda head: {"type": kind, **fields}.items() <= head.items())

    def take_rows(self):
        """Wait for rows, which come on their own or with a frame."""
        return self._take("rows", lambda head: head.get("rows"))

    def _take(self, what, is_wanted):
        end = time.monotonic() + _PATIENCE
        with self._news:
            while True:
                while self._told:
                    head, buffers = self._told.pop(0)
                    if is_wanted(head):
                        return head, buffers
                left = end - time.monotonic()
                assert left > 0, f"no {what} came"
                self._news.wait(left)

    def all_of(self, kind):
        """What came of this type and was not taken yet."""
        with self._news:
            return [head for head, _ in self._told if head["type"] == kind]


class Watcher(FakeBrowser):
    """One that keeps all that it is told, without pictures."""

    def __init__(self, view):
        self.messages = []
        super().__init__(view, 100, name="here", room=0)

    def transmit(self, head, buffers):
        self.messages.append(dict(head))

    def press(self, button):
        super().press(button)
        self.settle()

    def settle(self):
        """Wait until all that was said is done, and answered."""
        done = []
        self.view.post(
            lambda: self.view.driver.call(lambda: self.view.post(lambda: done.append(1)))
        )
        wait_for(lambda: done)

    def of(self, kind):
        return [message for message in list(self.messages) if message["type"] == kind]

    def newest(self, kind):
        return self.of(kind)[-1]

    def notes(self):
        return [message["text"] for message in self.of("note")]


def settled(view):
    """Wait until all is done that was posted to a view by now."""
    done = threading.Event()
    assert view.post(done.set)
    assert done.wait(_PATIENCE)


@contextmanager
def panel_of(shown, *, width=300, **options):
    """Show something in a panel with one browser: the view and the browser."""
    view = PanelView(shown, **options)
    try:
        yield view, FakeBrowser(view, width)
    finally:
        view.close()
