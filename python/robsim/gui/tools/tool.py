"""The base of all tools: a picture, live or frozen, for the browsers."""

from __future__ import annotations

import io
import math
import os
import re
import time
from abc import abstractmethod
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from os import PathLike
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from PIL import Image

from robsim._core import Frame, reduced
from robsim.base.files import as_path
from robsim.base.text import one_line, quoted
from robsim.gui._link import (
    COMMON,
    SLOW,
    FrameClock,
    Link,
    Messages,
    Refused,
    jpeg,
    small_png,
    switch,
    whole,
)
from robsim.gui._view import View
from robsim.gui.tools.history import History
from robsim.gui.tools.pictures import OnePicture, Picture, Pictures, given_picture
from robsim.gui.tools.uploads import UPLOAD_MESSAGES, Uploads
from robsim.vision.imaging import images
from robsim.vision.robots.sketch import over_floor

T = TypeVar("T")

#: The actions of browsers' messages, by type.
Acts = Mapping[str, Callable[[dict[str, Any]], object]]
Handler = Callable[[Link, dict[str, Any]], None]

_STILL_WIDTH = 480  # px, of the still picture in a saved notebook
_REST = 0.5  # s after a change, so that dragging does not wait for pictures

#: The messages that every tool accepts from a browser.
TOOL_MESSAGES: Messages = {
    **COMMON,
    "look": {"k": whole},
    "freeze": {"on": switch},
    **UPLOAD_MESSAGES,
    "back": {},
    "undo": {},
    "redo": {},
}


class ToolView(View):
    """Shows the pictures of a source; live pictures until they are frozen."""

    def __init__(self, source: Pictures) -> None:
        super().__init__()
        self.source = source
        self.picture: Picture | None = None
        self.is_frozen = False
        self._taken: Picture | None = None  # set in any thread
        self._is_told = False
        self._clock = FrameClock()
        self._stills = self.beside("robsim still")
        self._still_due = math.inf
        self._over = ""  # why no more pictures come
        self._own = source  # the original source
        self._left: tuple[Picture | None, bool] = (None, False)  # before the replacement
        self._uploads = Uploads(self.beside("robsim upload"), self._uploaded)

    def begin(self) -> None:
        """Take the pictures of the source from now on."""
        self.source.begin(self._take, self._note_end)

    def handlers(self) -> Mapping[str, Handler]:
        return {
            **super().handlers(),
            "look": self._look_at,
            "freeze": self._in_place(lambda m: self.freeze(m["on"])),
            "upload": self._uploads.take,
            "give_up": self._uploads.give_up,
            "back": self._in_place(lambda _: self.go_back()),
            "undo": self._in_place(lambda _: self.travel(self.history.undo)),
            "redo": self._in_place(lambda _: self.travel(self.history.redo)),
            **{name: self._in_place(act) for name, act in self.acts().items()},
            **{name: self._in_place(self._changing(act)) for name, act in self.changes().items()},
        }

    def close(self, timeout: float = 5.0) -> bool:
        """Close the tool; the source, which the user owns, stays open."""
        self._own.close()
        return super().close(timeout)

    # Methods for a tool to add.

    @property
    @abstractmethod
    def history(self) -> History[Any]:
        """The tool's product, change by change."""

    @abstractmethod
    def acts(self) -> Acts:
        """Return the actions of messages; each sends its own outcome."""

    def changes(self) -> Acts:
        """Return the changes by messages; `change` sends their outcome."""
        return {}

    def head(self, picture: Picture) -> tuple[dict[str, Any], list[bytes]]:
        """Return the header fields sent with a picture, and buffers."""
        return {}, []

    @abstractmethod
    def state(self) -> dict[str, Any]:
        """Return the fields of the message ``state``."""

    def changed_picture(self) -> None:
        """React to another displayed picture."""

    def still(self) -> Callable[[], bytes]:
        """Return a function that draws the current still picture (PNG), in any thread."""
        frame = None if self.picture is None else self.picture.frame

        def draw() -> bytes:
            pixels = np.zeros((1, 1, 3), np.uint8) if frame is None else frame.image
            return small_png(
                Image.fromarray(pixels if frame is None else reduced(frame, _STILL_WIDTH))
            )

        return draw

    def changed_source(self) -> None:
        """React to pictures from another source."""

    def loading(self, pixels: images.Pixels, name: str) -> Callable[[], object]:
        """Return a function for the view's thread that takes a loaded picture (h, w, 3 or 4).

        Any thread may prepare the picture. ValueError, here or there: the picture is unusable.
        """
        picture = OnePicture(over_floor(pixels), name)
        return lambda: self.replace(picture)

    def change(self, change: Callable[[], T]) -> T:
        """Apply a change, send the outcome, and return the result."""
        try:
            return change()
        finally:
            self.tell_state()

    def travel(self, step: Callable[[], None]) -> None:
        """Undo a change, or redo it."""
        self.change(step)

    # The displayed picture.

    @property
    def shown(self) -> Picture:
        """The displayed picture; ValueError before the first picture."""
        if self.picture is None:
            raise ValueError("there is no picture yet")
        return self.picture

    @property
    def is_replaced(self) -> bool:
        return self.source is not self._own

    def load_picture(self, picture: Frame | images.Pixels | str | PathLike[str]) -> None:
        """Load a picture as if from a browser; any thread may call this."""
        self.ask(self.prepared(*given_picture(picture)))

    def _uploaded(self, content: bytes, name: str) -> Callable[[], object]:
        return self.prepared(images.decoded(io.BytesIO(content), name), name)

    def prepared(self, pixels: images.Pixels, name: str) -> Callable[[], object]:
        """Prepare a picture like `loading`; ValueError also for lack of memory."""
        try:
            return self.loading(pixels, name)
        except MemoryError as error:
            raise ValueError(f"{name} cannot be loaded: there is not enough memory") from error

    def replace(self, source: Pictures) -> None:
        """Show another picture until `go_back`."""
        if not self.is_replaced:
            self._left = self.picture, self.is_frozen
        self.source, self.is_frozen = source, False
        self._changed_source()
        self.show(source.at(0))

    def go_back(self) -> None:
        """Return to the original source in its previous state."""
        if not self.is_replaced:
            raise ValueError("there is nothing to return to: these are the original pictures")
        self.source = self._own
        self.picture, self.is_frozen = self._left
        self._changed_source()
        if self.is_frozen and self.picture is not None:
            self.show(self.picture)
        self._show()
        self.tell_state()

    @property
    def back(self) -> str | None:
        """The target of `go_back`: live, recording or picture; None = nothing."""
        return self._own.kind if self.is_replaced else None

    def _changed_source(self) -> None:
        self.changed_source()
        self.send(self._setup())

    # In the thread of the view.

    def tell(self, link: Link) -> None:
        link.send(self._setup())
        link.send(self._state())
        link.shown = None

    def tell_state(self) -> None:
        self.send(self._state())
        self._still_due = time.monotonic() + _REST

    def show_again(self) -> None:
        """Send the picture again, with its header fields."""
        for link in self.links:
            link.shown = None

    def look(self, now: float) -> float:
        due = min(self._look_at_links(now), self._look_at_still(now))
        return min(due, self._uploads.look(now))

    def _look_at_links(self, now: float) -> float:
        lacking = [link for link in self.links if link.lacks(self.picture)]
        if self.picture is None or not lacking:
            return math.inf
        if now < self._clock.due:
            return self._clock.due
        if ready := [link for link in lacking if link.has_room(now)]:
            self._clock.sent(now)
            self._send_picture(self.picture, ready, now)
        return math.inf if len(ready) == len(lacking) else now + SLOW

    def settle(self) -> None:
        if not self.is_here:
            self.source.settle()
        super().settle()

    def snapshot(self) -> bytes:
        self.settle()
        try:
            draw = self.ask(self.still)
        except RuntimeError:  # closed: the picture no longer changes
            draw = self.still()
        return draw()

    def _look_at_still(self, now: float) -> float:
        """Redraw the picture for a saved notebook after a pause in the changes."""
        links = [link for link in self.links if link.keeps_still]
        if now >= self._still_due and links:
            if self._stills.is_busy:
                return now + _REST
            self._stills.begin(self.still(), lambda picture: _keep(links, picture))
        if now >= self._still_due or not links:
            self._still_due = math.inf
        return self._still_due

    def ask(self, function: Callable[[], T]) -> T:
        """Call a function in the view's thread, and return its result or raise its exception."""
        return function() if self.is_here else self.later(function).result()

    def later(self, function: Callable[[], T]) -> Future[T]:
        """Call a function in the view's thread; its result or exception comes later."""
        answer: Future[T] = Future()

        def do() -> None:
            try:
                answer.set_result(function())
            except BaseException as error:
                answer.set_exception(error)

        if not self.post(do):
            answer.set_exception(RuntimeError("the panel is closed"))
        return answer

    @property
    def is_over(self) -> bool:
        return self._is_over

    def parted(self) -> None:
        """Without views, compute nothing."""

    def _setup(self) -> dict[str, Any]:
        source = self.source
        about = {"title": source.title, "is_live": source.is_live, "count": source.count}
        return {"type": "setup", **about, "back": self.back}

    def _state(self) -> dict[str, Any]:
        k = None if self.picture is None else self.picture.k
        name = "" if self.picture is None else self.picture.name
        over = "" if self.is_replaced else self._over
        is_live = self.source.is_live and not (self.is_frozen or over)
        mine = {"type": "state", "state": "running" if is_live else "paused", "k": k, "name": name}
        undo = {"can_undo": self.history.can_undo, "can_redo": self.history.can_redo}
        return {**mine, "frozen": self.is_frozen, "over": over, **undo, **self.state()}

    def _send_picture(self, picture: Picture, links: list[Link], now: float) -> None:
        head, buffers = self.head(picture)
        height, width = picture.frame.image.shape[:2]
        about = {"type": "frame", "k": picture.k, "name": picture.name, "size": [width, height]}
        pictures: dict[int, bytes] = {}
        for link in links:
            if link.width not in pictures:
                pictures[link.width] = jpeg(reduced(picture.frame, link.width))
            link.shown = picture
            link.send_frame({**about, **head}, [pictures[link.width], *buffers], now)

    def _take(self, picture: Picture) -> None:
        """Note a new picture; any thread."""
        self._taken = picture
        if not self._is_told:
            self._is_told = True
            self.post(self._show)

    def _note_end(self, why: str) -> None:
        """Note that no more pictures come; any thread."""

        def end() -> None:
            self._over = why
            self.tell_state()

        self.post(end)

    def _show(self) -> None:
        self._is_told = False  # before reading `_taken`: later pictures post again
        if self.is_replaced:
            return
        if self._taken is not None and not (self.is_frozen and self.picture is not None):
            self.show(self._taken)

    def show(self, picture: Picture) -> None:
        """Show a new picture."""
        is_first = self.picture is None
        self.picture = picture
        self.changed_picture()
        if is_first or not self.source.is_live:
            self.tell_state()

    def look_at(self, k: int) -> None:
        """Show a picture of a recording."""
        self._taken = self.source.at(k)
        self.show(self._taken)

    def _look_at(self, link: Link, message: dict[str, Any]) -> None:
        if not self.source.count or message["k"] >= self.source.count:
            raise Refused(f"unknown picture {message['k']}")
        try:
            self.look_at(message["k"])
        except (OSError, ValueError, IndexError) as error:
            raise Refused(str(error)) from None

    def freeze(self, on: bool) -> None:
        """Freeze the picture, or continue with newer ones."""
        self.is_frozen = on
        self._show()
        self.tell_state()

    def _in_place(self, act: Callable[[dict[str, Any]], object]) -> Handler:
        """Return a handler; an error goes to the browser that sent the message."""

        def handle(link: Link, message: dict[str, Any]) -> None:
            if not message.get("goes_on"):
                self.history.end_change()
            try:
                act(message)
            except (TypeError, ValueError, OSError) as error:
                raise Refused(str(error)) from None

        return handle

    def _changing(self, act: Callable[[dict[str, Any]], object]) -> Callable[[Any], object]:
        return lambda message: self.change(lambda: act(message))

    def _bye(self, link: Link, message: dict[str, Any]) -> None:
        self._uploads.drop(lambda one: one.link is link and one.view == message["id"])
        super()._bye(link, message)

    def _disconnect(self, link: Link) -> None:
        self._uploads.drop(lambda one: one.link is link)
        super()._disconnect(link)


def _keep(links: list[Link], picture: bytes | None) -> None:
    if picture is not None:
        for link in links:
            link.keep(picture)


def file_to_save(path: str | PathLike[str]) -> Path:
    """Return the file for a tool to write; ValueError for another name, also through a link."""
    file = as_path(path)
    real = Path(os.path.realpath(file))
    for name in (file.name, real.name):
        if not (name.isprintable() and re.fullmatch(r"\w.*\.toml", name, re.IGNORECASE)):
            raise ValueError(
                f"{one_line(file)}: a file name must end in .toml, and begin with a letter, "
                f"a digit or _, got {quoted(name)}"
            )
    if not real.parent.is_dir():
        raise ValueError(f"{one_line(file)}: unknown folder {one_line(file.parent)}")
    refuse_device(file)
    return file


def refuse_device(file: Path) -> None:
    """Raise a ValueError if a path is a device or a pipe; reading a pipe may never end."""
    if file.exists() and not file.is_file():
        raise ValueError(f"{one_line(file)} is not a file")
