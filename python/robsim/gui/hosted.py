"""The base of all panels: a page, a place below a cell, a picture, an end."""

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

_PATIENCE = 3.0  # s that a page may be disconnected, such as while reloading
#: s for each panel to end, when Python ends.
AT_EXIT = 1.0

#: All open panels; hold the lock to read them.
opened: list[HostedPanel] = []
lock = threading.RLock()


class HostedPanel(Closing, ABC):
    """A panel shown by a page or a notebook; subclasses add its functions."""

    #: The function that creates another panel, for messages.
    _maker: ClassVar[str]
    _view: View

    def __init__(self) -> None:
        self._page: Page | None = None
        with lock:
            opened.append(self)

    @property
    @abstractmethod
    def _is_closed(self) -> bool:
        """Whether the panel has ended."""

    @abstractmethod
    def _pause_soon(self) -> None:
        """Pause the run, without waiting for long."""

    # Actions.

    def close(self) -> None:
        """End the run's thread and the page; a notebook keeps the last picture."""
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
        """Return a picture of the panel as PNG."""
        return self._view.snapshot()

    def message(self, kind: str, **fields: Any) -> list[dict[str, Any]]:
        """Send the panel a message like a mouse action in the page, and wait for its completion.

        Results computed in other threads come later, such as a colour score or the positions of
        floor sheets.

        Parameters
        ----------
        kind : str
            Type of the message, such as ``"press"``. ``robsim/gui/PROTOCOL.md`` lists all messages
            of a browser.
        **fields
            Its fields, such as ``button="step"``: numbers, texts, lists or None.

        Returns
        -------
        list of dict
            The answers of the panel, without pictures, such as ``tree`` to ``inspect``; often none.
            A failing callback does not make this fail: see `Panel.error`.

        Raises
        ------
        RuntimeError
            If the panel is closed.
        TypeError, ValueError
            If the message is unknown or refused; the text gives the reason.
        """
        self._check_open()
        return answers_to(self._view, kind, fields)

    # Page.

    @property
    def url(self) -> str:
        """The address of its page, for browsers on this machine; the address contains a secret."""
        return self._serve().url

    def open(self, *, port: int = 0) -> None:
        """Show the panel in a browser window, beside a notebook or without one.

        Parameters
        ----------
        port : int
            Port of the page's server, only for this machine; 0 = any free port.

        Raises
        ------
        OSError
            If the port is unavailable.
        TypeError, ValueError
            If `port` is not a port number.

        Warns
        -----
        UserWarning
            If no browser could be started; the warning contains the address.
        """
        page = self._serve(port)
        if not page.open():
            warnings.warn(f"no browser could be started: open {page.url}", stacklevel=2)

    def wait(self) -> None:
        """Wait until its page has been opened, and closed again.

        Use this at the end of a script, which would otherwise end its panels. Ctrl-C pauses the
        run, and ends the wait; `close` in another thread ends it, too.
        """
        page = self._page or self._serve()  # an ended page is not started again
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
                " and reload the page.\nOr in a browser window: "
                f"{self._maker}(...).open()"
            )
        else:
            _end_before_zmq()
            notebook.show(self)

    def _repr_mimebundle_(self, **_: Any) -> dict[str, Any]:
        picture = base64.b64encode(self.snapshot()).decode()
        return {"text/plain": repr(self), "image/png": picture}

    # Internals.

    def _leave_cell(self) -> None:
        """Close the panel if it has neither a cell nor a page."""
        if self._page is None or not self._page.pages:
            self.close()

    def _check_open(self) -> None:
        if self._is_closed:
            raise RuntimeError(f"the panel is closed; {self._maker} opens another one")


@atexit.register
def _close_all() -> None:
    """End all threads before Python ends."""
    for one in [*opened]:
        one._close(AT_EXIT)
    if sys.stdout is not None:
        with suppress(OSError, ValueError):  # the stream may be closed
            sys.stdout.flush()  # in a kernel, this waits for all earlier output


def _end_before_zmq() -> None:
    """End panels before zmq's part for large messages: exit functions run in reverse order."""
    with suppress(ImportError):
        importlib.import_module("zmq.utils.garbage")
    atexit.unregister(_close_all)
    atexit.register(_close_all)


def answers_to(view: View, kind: str, fields: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Handle a message, and return the view's answers; TypeError, ValueError: refused."""
    from robsim.base.checks import check_choice  # loads numpy

    check_choice("kind", kind, tuple(view.messages))
    line = _Answers()
    ends_call = kind == "press" and fields.get("button") in ("end", "stop")
    settle = partial(View.settle, view) if ends_call else view.settle  # does not wait for callbacks
    settle()  # waits for the first picture of a tool
    view.receive(line, {"type": kind, "id": "caller", **_as_sent(fields)})
    settle()
    for head in line.heads:
        if head["type"] == "note" and head["level"] == "error":
            raise ValueError(head["text"])
    return line.heads


def _as_sent(fields: Mapping[str, Any]) -> dict[str, Any]:
    """Return fields in the form sent by a browser."""
    try:
        sent: dict[str, Any] = json.loads(json.dumps(fields))
    except TypeError as error:  # such as an array
        raise TypeError(f"fields must be numbers, texts, lists or None: {error}") from None
    return sent


class _Answers(Link):
    """A link without a view: it receives only direct answers, no frames and no broadcasts."""

    def __init__(self) -> None:
        super().__init__()
        self.heads: list[dict[str, Any]] = []

    def transmit(self, head: Mapping[str, Any], buffers: Buffers) -> None:
        self.heads.append(dict(head))
