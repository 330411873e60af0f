"""The host without a notebook: a page on loopback, with a server in a separate thread."""

from __future__ import annotations

import asyncio
import errno
import os
import secrets
import socket
import sys
import threading
import time
import webbrowser
from concurrent.futures import Future
from contextlib import suppress

from robsim.gui._view import View
from robsim.gui.hosts.serving import Server, Socket
from robsim.gui.hosts.ticket import Ticket, stranger

_GOODBYE = 0.5  # s for pages to disconnect when the server ends
_COMING = 60.0  # s for a page to connect after its address was used
_STALLED = 60.0  # s more after a hang


class Page:
    """Serves a view on 127.0.0.1, at a secret address."""

    def __init__(self, view: View, *, port: int = 0) -> None:
        self.view = view
        self.secret = secrets.token_urlsafe(18)
        self.ticket: Ticket | None = None
        self.fault = ""  # reason for its end
        self._listening = _listen(port)
        self.port: int = self._listening.getsockname()[1]
        self.url = f"http://127.0.0.1:{self.port}/{self.secret}/"
        self.pages: set[Socket] = set()
        self._change = threading.Condition()
        self._left: float | None = None  # when the last page disconnected, or a minute later
        self._coming: asyncio.TimerHandle | None = None  # ends the wait for a page
        self._strangers: set[str] = set()  # refused users
        self._saying = threading.Thread()  # the latest message
        started: Future[None] = Future()
        self._thread = threading.Thread(
            target=self._run, args=(started,), name="robsim page", daemon=True
        )
        self._thread.start()
        started.result()

    def open(self) -> bool:
        """Show the page in the user's browser; return whether a browser was started.

        Other users can read the arguments of programs: see `Ticket`.
        """
        if not _has_screen():
            return False
        self.ticket = Ticket()
        return webbrowser.open(f"http://127.0.0.1:{self.port}/{self.ticket.word}")

    def show(self, view: View) -> None:
        """Show another view; open pages load it at once."""
        old, self.view = self.view, view
        old.post(lambda: old.send({"type": "moved"}))

    def wait(self, patience: float) -> None:
        """Wait until pages have connected, and all have been gone for some seconds.

        A reloaded or reconnecting page returns within this time; a page whose browser had stopped
        to answer has a minute more. Closing ends the wait, too.
        """
        with self._change:
            while self._thread.is_alive() and (
                self._left is None or time.monotonic() < self._left + patience
            ):
                self._change.wait(0.2)  # short, so that Ctrl-C works on Windows
        with suppress(RuntimeError):  # no message
            self._saying.join(_GOODBYE)

    def close(self) -> None:
        """End the server; the view continues."""
        with suppress(RuntimeError):  # the server has ended
            self._loop.call_soon_threadsafe(self._end.set)
        self._thread.join(5)

    # In the thread.

    def redeem(self, ticket: Ticket, peer: tuple[str, int]) -> bool:
        """Whether the peer may load the page; a second use of a ticket ends the page."""
        if who := stranger(peer, ("127.0.0.1", self.port)):
            if who not in self._strangers:
                self._strangers.add(who)
                self._say(
                    f"{who} tried to open your page and was refused; "
                    f"if your browser did not open the page, go to {self.url}"
                )
            return False
        if ticket.is_used:
            self._end_for("the browser's address was used twice")
            return False
        ticket.is_used = True
        if self._coming is not None:
            self._coming.cancel()
        self._coming = self._loop.call_later(_COMING, self._has_come)
        return True

    def _has_come(self) -> None:
        if not self.pages:
            self._end_for("the browser's address was used, but no page connected")

    def _end_for(self, reason: str) -> None:
        self.fault = f"{reason}: the page ends because another user may have opened it"
        self._end.set()
        self._say(self.fault)

    def _say(self, text: str) -> None:
        """Write to the terminal, which may block."""
        self._saying = threading.Thread(
            target=_print, args=(text,), name="robsim message", daemon=True
        )
        self._saying.start()

    def came(self, page: Socket) -> None:
        with self._change:
            self.pages.add(page)
            self._left = None
        if self._coming is not None:
            self._coming.cancel()

    def went(self, page: Socket, *, is_stalled: bool) -> None:
        with self._change:
            self.pages.discard(page)
            if not self.pages:
                self._left = time.monotonic() + (_STALLED if is_stalled else 0)

    def _run(self, started: Future[None]) -> None:
        try:
            asyncio.run(self._serve(started))
        except BaseException as error:
            self._listening.close()
            if started.done():
                raise
            started.set_exception(error)

    async def _serve(self, started: Future[None]) -> None:
        self._loop, self._end = asyncio.get_running_loop(), asyncio.Event()
        server = Server(self)
        server.add_socket(self._listening)
        started.set_result(None)
        await self._end.wait()
        server.stop()
        for page in self.pages:
            page.close(1001)
        until = self._loop.time() + _GOODBYE
        while self.pages and self._loop.time() < until:
            await asyncio.sleep(0.01)
        for page in self.pages:
            page.cut()
        await server.close_all_connections()


def _print(text: str) -> None:
    if sys.stderr is not None:
        with suppress(Exception):  # a closed pipe
            print(f"robsim: {text}", file=sys.stderr, flush=True)


def _listen(port: int) -> socket.socket:
    if type(port) is not int or port:
        from robsim.base.checks import check_int  # loads numpy

        check_int("port", port, minimum=0, maximum=65535)
    try:
        listening = socket.create_server(("127.0.0.1", port))
    except OSError as error:
        reasons = {
            errno.EADDRINUSE: "another program uses it",
            errno.EACCES: "more rights are required",
        }
        reason = reasons.get(error.errno or 0, error.strerror)
        raise OSError(f"port {port} is unavailable: {reason}; use 0 for any free port") from None
    listening.setblocking(False)
    return listening


def _has_screen() -> bool:
    """Return whether a window can open: text browsers would occupy the terminal."""
    if sys.platform in ("win32", "darwin"):
        return True
    return any(os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER"))
