"""Parts of the panel, and the messages that a browser may send to them."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from contextlib import suppress
from typing import TYPE_CHECKING, Any

from robsim._core import Step
from robsim.base.text import said_by
from robsim.gui._link import (
    COMMON,
    MAGNIFY,
    Link,
    Messages,
    Refused,
    buffers_of_message,
    list_of,
    maybe,
    message,
    number,
    point,
    setting,
    switch,
    text,
    whole,
)
from robsim.gui.tools.uploads import UPLOAD_MESSAGES

if TYPE_CHECKING:
    from robsim.gui.panels.view import PanelView
Handlers = Mapping[str, Callable[[Link, dict[str, Any]], None]]


class Part:
    """A part of the panel: sends messages to the browsers and handles theirs.

    All methods run in the thread of the view, except `take` and `close`.
    """

    def __init__(self, panel: PanelView) -> None:
        self.panel = panel

    def handlers(self) -> Handlers:
        """Return the handlers of messages, by message type."""
        return {}

    def setup(self) -> dict[str, Any]:
        """Return its fields of the message ``setup``."""
        return {}

    def state(self) -> dict[str, Any]:
        """Return its fields of the message ``state``, which is sent after each command."""
        return {}

    def greet(self, link: Link) -> None:
        """Send a new view the data missing from ``setup`` and ``state``."""

    def take(self, step: Step) -> None:
        """Copy the required data of a finished step; in the thread of the run, so be quick."""

    def changed(self) -> None:
        """Note that the state of the run has changed: paused, failed, reset and so on."""

    def look(self, now: float) -> float:
        """Do the due work; return the time of the next look, by the monotonic clock."""
        return math.inf

    def change(
        self,
        link: Link,
        change: Callable[[], list[str]],
        changed: Callable[[], None],
        plain: tuple[type[Exception], ...] = (Refused,),
        **where: Any,
    ) -> None:
        """Change something between two steps, report the outcome, and call `changed`.

        An error is a note with the fields `where`; a `plain` error omits the class name.
        """

        def done(future: Future[list[str]]) -> None:
            if future.cancelled():  # the panel is being closed
                return
            if (error := future.exception()) is not None:
                text = str(error) if isinstance(error, plain) else said_by(error)
                link.send({"type": "note", "level": "error", "text": text, **where})
            changed()
            for remark in () if error else future.result():
                link.send({"type": "note", "level": "info", "text": remark})

        self.panel.check_room()
        future = self.panel.driver.call(change)
        future.add_done_callback(lambda future: self.panel.post(lambda: done(future)))

    def close(self, timeout: float) -> None:
        """Wait for computations and drawings (s) after the end of the view; any thread."""


def data(value: Any) -> Any:
    """Return data in the form of JSON; the owner of the data checks more."""
    with suppress(RecursionError, ValueError):
        if len(json.dumps(value, allow_nan=False)) <= _MOST_DATA:
            return value
    raise Refused(f"data of up to {_MOST_DATA} characters")


_MOST_DATA = 1_000_000  # characters
_MOST_POINTS = 1000
_MOST_NAMES = 100
MESSAGES: Messages = {
    **COMMON,
    "press": {"button": text},
    "set": {"name": text, "value": setting},
    "set_option": {"name": text, "value": data},
    "keep_options": {},
    "load_scenario": {"text": data},
    "save_scenario": {},
    "go_to": {"x": number, "y": number},
    "path": {"points": list_of(point, _MOST_POINTS)},
    "look": {"k": maybe(whole)},
    "magnify": MAGNIFY,
    "columns": {"names": list_of(text, _MOST_NAMES)},
    "inspect": {"k": maybe(whole), "path": list_of(text, _MOST_NAMES)},
    "source": {"slot": text},
    "edit": {"slot": text},
    "make_mine": {"slot": text},
    "check": {"slot": text},
    "animate": {"on": switch},
    "keep": {},
    "reference": {},
    "drop_ghost": {"name": text},
    **UPLOAD_MESSAGES,
    "tool": {"name": maybe(text)},
    "use_tool": {},
    "home": {},
    "share": {},
    "use_here": {},
    "tell_tool": {"name": text, "message": message, "buffers": buffers_of_message},
}
