"""The host in notebooks: one anywidget, used as a line for messages, and a picture that stays."""

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
_MOST_LATE = 3  # grants in a row, until messages are no longer sent by themselves
_POLL = 100  # ms between two questions whether there are messages
_FIRST_TRY = 5.0  # s, then twice as long, and so on: do they come by themselves again?
_MOST_WAITING = 200  # messages; whoever does not come for them is gone
#: Cell -> what it shows: the run of the cell, the panel, its line. A panel that is closed goes.
_cells: dict[str, list[tuple[str, weakref.ref[HostedPanel], NotebookLink]]] = {}


def show(panel: HostedPanel) -> None:
    """Show a panel below the cell that runs: the widget, and a picture for readers without it."""
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
    """Note what a cell shows; what an earlier run of it showed is closed."""
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
    """Pause when the user interrupts a cell: no other signal reaches a kernel."""
    if isinstance(result.error_in_exec, KeyboardInterrupt):
        pause_all()


def _display(data: dict[str, Any], metadata: Any = None, **options: Any) -> None:
    """Show something below the cell that runs, or in place of an earlier output; any thread may."""
    if (shell := get_ipython()) is not None:  # the kernel ends
        shell.display_pub.publish(data=data, metadata=metadata, **options)


def _img(picture: bytes, name: str = "robsim-still") -> str:
    data = base64.b64encode(picture).decode()
    return f'<img class="{name}" src="data:image/png;base64,{data}" alt="robsim">'


class _Pipe(anywidget.AnyWidget):
    _esm = script()
    _css = style()
    kind = traitlets.Unicode().tag(sync=True)
    still = traitlets.Unicode().tag(sync=True)  # the name of the picture that it hides


class NotebookLink(Link):
    """The line to a widget.

    Where messages of background threads are not delivered, as in Colab, they wait for the handler
    of the next message from the browser, which asks for them (`polled` in PROTOCOL.md), until it
    says hello since one has come by itself.

    ipywidgets keeps the widget of a cell's output, and so the line, but not a view that is closed.
    """

    is_in_notebook = True
    keeps_still = True

    def __init__(self, view: View, text: str = "") -> None:
        super().__init__()
        self._view, self._text = weakref.ref(view), text
        self._still = uuid.uuid4().hex  # known before the widget is shown
        self._waiting: deque[tuple[dict[str, Any], Buffers]] | None = None  # if polled
        self._delivering = threading.RLock()
        self._next_try, self._try_gap = 0.0, _FIRST_TRY  # (s)
        self.widget = _Pipe(kind=view.kind, still=self._still)
        self.widget.on_msg(self._receive)
        view.connect(self)

    def display(self, draw: Callable[[], bytes]) -> None:
        """Show the widget, and below it a picture, which it hides while it lives."""
        data, metadata = self.widget._repr_mimebundle_() or ({}, {})
        _display({**data, "text/plain": self._text}, metadata)
        self._publish(draw())

    def keep(self, picture: bytes) -> None:
        self._publish(picture, update=True)

    def close(self) -> None:
        """End the line; what the widget shows is gone with its cell's output."""
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
            self._waiting = None  # until it turns out that nothing comes by itself
        super().greet(view)

    def grant(self, view: str, upto: int, *, late: bool = False) -> None:
        super().grant(view, upto, late=late)
        if self._waiting is None and self._n_late >= _MOST_LATE:
            self._next_try = time.monotonic() + self._try_gap
            self._waiting = deque([({"type": "polled", "gap": _POLL}, ())])

    def _receive(self, widget: object, message: Any, buffers: Buffers) -> None:
        if (view := self._view()) is not None:
            view.receive(self, message, [bytes(one) for one in buffers])  # copies of memoryviews
        else:
            self.late(message)
        self._deliver()

    def _deliver(self) -> None:
        with self._delivering:  # one after another, whichever thread sends them
            while self._waiting:
                self._send(*self._waiting.popleft())

    def _send(self, head: Mapping[str, Any], buffers: Buffers) -> None:
        self.widget.send(dict(head), list(buffers))
        # ipykernel 7 answers on the (sub)shell that sent last, and counts a thread as the main
        # one, which a running cell blocks. The browser chooses one that is not blocked.
        comm: Any = self.widget.comm
        if comm is not None:
            vars(comm).pop("_reply_subshell_id", None)

    def _publish(self, picture: bytes, *, update: bool = False) -> None:
        data = {"text/plain": self._text, "text/html": _img(picture, f"robsim-still-{self._still}")}
        _display(data, transient={"display_id": self._still}, update=update)
