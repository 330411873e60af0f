"""The host in notebooks: an anywidget as a link for messages, and a still picture."""

from __future__ import annotations

import base64
import threading
import time
import uuid
import weakref
from collections import deque
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import anywidget
import traitlets
from IPython import get_ipython

from robsim.gui._driver import pause_all
from robsim.gui._link import Buffers, Link
from robsim.gui._view import View
from robsim.gui.hosts.script import script, style

if TYPE_CHECKING:
    from robsim.gui.hosted import HostedPanel
_MOST_LATE = 3  # consecutive grants before switching to polling
_POLL = 100  # ms between two polls for messages
_FIRST_TRY = 5.0  # s before the first retry without polling, then doubled.
_MOST_WAITING = 200  # messages; a view that does not poll is gone
#: Cell -> execution, panel and link of its output. Closed panels are removed.
_cells: dict[str, list[tuple[str, weakref.ref[HostedPanel], NotebookLink]]] = {}


def show(panel: HostedPanel) -> None:
    """Show a panel below the running cell: the widget, and a picture for readers without Python."""
    shell = get_ipython()
    if not hasattr(shell, "kernel"):
        print(f"{panel!r}\nA terminal cannot show it; {panel._maker}(...).open() opens a window")
        return
    if _after_cell not in shell.events.callbacks["post_run_cell"]:
        shell.events.register("post_run_cell", _after_cell)
    if panel._is_closed:
        _display({"text/plain": repr(panel), "text/html": _img(panel.snapshot())})
        return
    link = NotebookLink(panel._view, repr(panel))
    _replace(shell.get_parent(), panel, link)
    link.display(panel.snapshot)


def _replace(parent: Mapping[str, Any], panel: HostedPanel, link: NotebookLink) -> None:
    """Note the output of a cell; close the panel of its previous execution."""
    cell = parent.get("metadata", {}).get("cellId")
    if cell is None:
        return
    run = parent["header"]["msg_id"]
    shown = _cells.get(cell, [])
    _cells[cell] = [one for one in shown if one[0] == run] + [(run, weakref.ref(panel), link)]
    for old_run, old, old_link in shown:
        if old_run != run:
            old_link.close()
            is_left = all(old != other for cell in _cells.values() for _, other, _ in cell)
            if is_left and (left := old()) is not None:
                left._leave_cell()


def _after_cell(result: Any) -> None:
    """Pause when the user interrupts a cell: a kernel receives no other signal."""
    if isinstance(result.error_in_exec, KeyboardInterrupt):
        pause_all()


def _display(data: dict[str, Any], metadata: Any = None, **options: Any) -> None:
    """Show data below the running cell, or replace an earlier output; any thread may call this."""
    if (shell := get_ipython()) is not None:  # no shell while the kernel ends
        shell.display_pub.publish(data=data, metadata=metadata, **options)


def _img(picture: bytes, name: str = "robsim-still") -> str:
    data = base64.b64encode(picture).decode()
    return f'<img class="{name}" src="data:image/png;base64,{data}" alt="robsim">'


class _Pipe(anywidget.AnyWidget):
    _esm = script()
    _css = style()
    kind = traitlets.Unicode().tag(sync=True)
    still = traitlets.Unicode().tag(sync=True)  # name of the picture hidden by the widget


class NotebookLink(Link):
    """The link to a widget.

    Colab does not deliver messages of background threads. There, messages wait for the handler of
    the next message from the browser, which polls (`polled` in PROTOCOL.md). Polling ends when the
    browser receives a message without a poll, and says hello.

    ipywidgets keeps the widget of a cell's output, and so the link, but not a closed view.
    """

    is_in_notebook = True
    keeps_still = True

    def __init__(self, view: View, text: str = "") -> None:
        super().__init__()
        self._view, self._text = weakref.ref(view), text
        self._still = uuid.uuid4().hex  # needed before the widget is shown
        self._waiting: deque[tuple[dict[str, Any], Buffers]] | None = None  # set if polling
        self._delivering = threading.RLock()
        self._next_try, self._try_gap = 0.0, _FIRST_TRY  # (s)
        self.widget = _Pipe(kind=view.kind, still=self._still)
        self.widget.on_msg(self._receive)
        view.connect(self)

    def display(self, draw: Callable[[], bytes]) -> None:
        """Show the widget, and below it a picture, which the widget hides while it lives."""
        data, metadata = self.widget._repr_mimebundle_() or ({}, {})
        _display({**data, "text/plain": self._text}, metadata)
        self._publish(draw())

    def keep(self, picture: bytes) -> None:
        self._publish(picture, update=True)

    def close(self) -> None:
        """End the link; the widget disappears with its cell's output."""
        if (view := self._view()) is not None:
            view.disconnect(self)
        self.widget.close()

    def transmit(self, head: Mapping[str, Any], buffers: Buffers) -> None:
        if self._waiting is None:
            self._send(head, buffers)
            return
        if (now := time.monotonic()) >= self._next_try:
            self._next_try, self._try_gap = now + self._try_gap, 2 * self._try_gap
            self._send({"type": "polled", "gap": 0}, ())
        if len(self._waiting) < _MOST_WAITING:
            self._waiting.append((dict(head), buffers))
        else:
            self._grants.clear()

    def has_room(self, now: float) -> bool:
        return super().has_room(now) if self._waiting is None else not self._waiting

    def greet(self, view: str) -> None:
        with self._delivering:
            self._deliver()
            self._waiting = None  # until polling proves necessary
        super().greet(view)

    def grant(self, view: str, upto: int, *, late: bool = False) -> None:
        super().grant(view, upto, late=late)
        if self._waiting is None and self._n_late >= _MOST_LATE:
            self._next_try = time.monotonic() + self._try_gap
            self._waiting = deque([({"type": "polled", "gap": _POLL}, ())])

    def _receive(self, widget: object, message: Any, buffers: Buffers) -> None:
        if (view := self._view()) is not None:
            view.receive(self, message, [bytes(one) for one in buffers])  # copies memoryviews
        else:
            self.late(message)
        self._deliver()

    def _deliver(self) -> None:
        with self._delivering:  # one after another, from any thread
            while self._waiting:
                self._send(*self._waiting.popleft())

    def _send(self, head: Mapping[str, Any], buffers: Buffers) -> None:
        self.widget.send(dict(head), list(buffers))
        # ipykernel 7 answers on the (sub)shell that sent last, and counts a thread as the main one,
        # which a running cell blocks. The browser chooses a free shell.
        comm: Any = self.widget.comm
        if comm is not None:
            vars(comm).pop("_reply_subshell_id", None)

    def _publish(self, picture: bytes, *, update: bool = False) -> None:
        data = {"text/plain": self._text, "text/html": _img(picture, f"robsim-still-{self._still}")}
        _display(data, transient={"display_id": self._still}, update=update)
