"""What all panels have in common: a page, a place below a cell, a picture, an end."""

from __future__ import annotations

import atexit
import base64
import importlib
import json
import sys
import threading
import warnings
from abc import ABC, abstractmethod
from collections.abc import Mapping
from contextlib import suppress
from functools import partial
from typing import TYPE_CHECKING, Any, ClassVar

from robsim.base.closing import Closing
from robsim.gui._link import Buffers, Link
from robsim.gui._view import View

if TYPE_CHECKING:
    from robsim.gui.hosts.page import Page

_PATIENCE = 3.0  # s that a page may be away, such as while it is loaded anew
#: s for each panel to end, when Python does.
AT_EXIT = 1.0

#: All that are open, with the lock that is held to look.
opened: list[HostedPanel] = []
lock = threading.RLock()


class HostedPanel(Closing, ABC):
    """A panel that a page or a notebook shows; what it does itself is a subclass's."""

    #: What makes another one, for messages.
    _maker: ClassVar[str]
    _view: View

    def __init__(self) -> None:
        self._page: Page | None = None
        with lock:
            opened.append(self)

    @property
    @abstractmethod
    def _is_closed(self) -> bool:
        """Whether it has ended."""

    @abstractmethod
    def _pause_soon(self) -> None:
        """Pause what runs, without waiting for long."""

    # What it does.

    def close(self) -> None:
        """End the run's thread and the page; what is shown in a notebook stays as it is."""
        self._close(timeout=5.0)

    def _close(self, timeout: float) -> None:
        with lock:
            page, self._page = self._page, None
            if self in opened:
                opened.remove(self)
        self._view.close(timeout)
        if page is not None:
            page.close()

    def snapshot(self) -> bytes:
        """Return a picture of what it shows, a PNG."""
        return self._view.snapshot()

    def message(self, kind: str, **fields: Any) -> list[dict[str, Any]]:
        """Do what the page asks for when the mouse does something there, and wait for its end.

        What is computed beside the panel, such as how well colours would do in other light, or
        where floor sheets are, comes later.

        Parameters
        ----------
        kind : str
            Type of the message, such as ``"press"``. ``robsim/gui/PROTOCOL.md`` lists all that a
            browser may send.
        **fields
            Its fields, such as ``button="step"``: numbers, texts, lists or None.

        Returns
        -------
        list of dict
            What the panel answers, without pictures, such as ``tree`` to ``inspect``; often
            nothing. A callback that fails does not make this fail: `Panel.error` has it.

        Raises
        ------
        RuntimeError
            If the panel is closed.
        TypeError, ValueError
            If there is no such message, or what it asks for is refused; the text says why.
        """
        self._check_open()
        return answers_to(self._view, kind, fields)

    # Where it is shown.

    @property
    def url(self) -> str:
        """The address of its page, for browsers on this machine; it holds a secret."""
        return self._serve().url

    def open(self, *, port: int = 0) -> None:
        """Show it in a window of the browser, beside a notebook or without one.

        Parameters
        ----------
        port : int
            Where its page is served, on this machine alone; 0 = any port that is free.

        Raises
        ------
        OSError
            If the port cannot be used.
        TypeError, ValueError
            If `port` is no port.

        Warns
        -----
        UserWarning
            If there is no browser that could be started: it tells the address.
        """
        page = self._serve(port)
        if not page.open():
            warnings.warn(f"no browser could be started: open {page.url}", stacklevel=2)

    def wait(self) -> None:
        """Wait until its page has been opened, and closed again.

        For the end of a script, which otherwise ends its panels. Ctrl-C pauses what runs, and ends
        the wait; so does `close` in another thread.
        """
        page = self._page or self._serve()  # one that has ended is not begun again
        try:
            page.wait(_PATIENCE)
        except KeyboardInterrupt:
            self._pause_soon()

    def _serve(self, port: int = 0) -> Page:
        from robsim.gui.hosts.page import Page  # loads tornado

        with lock:
            self._check_open()
            page = self._page
            if page is not None and (page.fault or port not in (0, page.port)):
                page.close()
                self._page = None
            if self._page is None:
                self._page = Page(self._view, port=port)
            return self._page

    def _ipython_display_(self) -> None:
        try:
            from robsim.gui.hosts import notebook
        except ImportError:
            print(
                f'{self!r}\nTo see it here: pip install "robsim[notebook]", then restart the kernel'
                " and reload the page.\nOr in a browser window of its own: "
                f"{self._maker}(...).open()"
            )
        else:
            _end_before_zmq()
            notebook.show(self)

    def _repr_mimebundle_(self, **_: Any) -> dict[str, Any]:
        picture = base64.b64encode(self.snapshot()).decode()
        return {"text/plain": repr(self), "image/png": picture}

    # How.

    def _leave_cell(self) -> None:
        """Close it, if no cell shows it any more, unless its page does."""
        if self._page is None or not self._page.pages:
            self.close()

    def _check_open(self) -> None:
        if self._is_closed:
            raise RuntimeError(f"the panel is closed: {self._maker} opens another one")


@atexit.register
def _close_all() -> None:
    """End all threads while there still is a Python for them."""
    for one in [*opened]:
        one._close(AT_EXIT)
    if sys.stdout is not None:
        with suppress(OSError, ValueError):  # it may be closed
            sys.stdout.flush()  # in a kernel this waits until all before it is sent


def _end_before_zmq() -> None:
    """Let panels end before the part of zmq that sends large messages: last come, first to go."""
    with suppress(ImportError):
        importlib.import_module("zmq.utils.garbage")
    atexit.unregister(_close_all)
    atexit.register(_close_all)


def answers_to(view: View, kind: str, fields: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Handle a message, return the answers of the view; TypeError, ValueError: it is refused."""
    from robsim.base.checks import check_choice  # loads numpy

    check_choice("kind", kind, tuple(view.messages))
    line = _Answers()
    ends_call = kind == "press" and fields.get("button") in ("end", "stop")
    settle = partial(View.settle, view) if ends_call else view.settle  # waits for no callback
    settle()  # a tool has its first picture, if there is one
    view.receive(line, {"type": kind, "id": "caller", **_as_sent(fields)})
    settle()
    for head in line.heads:
        if head["type"] == "note" and head["level"] == "error":
            raise ValueError(head["text"])
    return line.heads


def _as_sent(fields: Mapping[str, Any]) -> dict[str, Any]:
    """Return fields as a browser would send them."""
    try:
        sent: dict[str, Any] = json.loads(json.dumps(fields))
    except TypeError as error:  # such as an array
        raise TypeError(f"fields must be numbers, texts, lists or None: {error}") from None
    return sent


class _Answers(Link):
    """A line that nobody watches: it gets what is said to it alone, and neither frames nor news."""

    def __init__(self) -> None:
        super().__init__()
        self.heads: list[dict[str, Any]] = []

    def transmit(self, head: Mapping[str, Any], buffers: Buffers) -> None:
        self.heads.append(dict(head))
