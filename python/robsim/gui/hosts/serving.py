"""The page's server and its access rules: the files of the page, and the link to it."""

from __future__ import annotations

import asyncio
import json
import secrets
import struct
from collections.abc import Mapping
from typing import Any, Protocol

import tornado.httpserver
import tornado.httputil
import tornado.iostream
import tornado.routing
import tornado.web
import tornado.websocket

from robsim.gui._link import Buffers, Link
from robsim.gui._view import View
from robsim.gui.hosts.script import page_script, script, style
from robsim.gui.hosts.ticket import Ticket

MOST_BYTES = 1 << 20  # of a message from the browser
_MOST_PAGES = 16
_MOST_REQUESTS = 64  # connections other than open pages.
_PATIENCE = 10.0  # s for a request to arrive, and between two requests.
_PING = 20.0  # s
_MUCH_BEHIND = 1 << 22  # bytes
_MOST_BEHIND = 1 << 25  # bytes of backlog before a slow page is disconnected; it reconnects
_HEADERS = {
    "Cache-Control": "no-store",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Content-Security-Policy": (
        "default-src 'none'; script-src 'self'; img-src 'self' blob: data:; "
        "media-src blob:; "
        "connect-src 'self' ws://{host}; style-src 'self' 'unsafe-inline'; "
        "frame-ancestors 'none'; base-uri 'none'; form-action 'none'"
    ),
}
_PAGE = """<!doctype html>
<html lang="en">
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>robsim</title>
<link rel="icon" href="data:,">
<link rel="stylesheet" href="view.css">
<body class="robsim-page" data-kind="{kind}">
<script type="module" src="page.js"></script>
"""
_REFUSED = "This address works once, for one user. The program that serves the page has another."


class Host(Protocol):
    """The owner of a server: a view at a secret address, and the pages that show it."""

    view: View
    secret: str
    ticket: Ticket | None
    port: int
    pages: set[Socket]

    def came(self, page: Socket) -> None:
        """Note that a page has connected."""

    def went(self, page: Socket, *, is_stalled: bool) -> None:
        """Note that a page has disconnected."""

    def redeem(self, ticket: Ticket, peer: tuple[str, int]) -> bool:
        """Whether the peer may load the page with a ticket."""


class Server(tornado.httpserver.HTTPServer):
    """An HTTP server with few connections and short timeouts."""

    def initialize(self, host: Host) -> None:  # type: ignore[override]  # as tornado has it
        """Serve the files and the link of a host."""
        self._requests: dict[tornado.iostream.IOStream, None] = {}  # the oldest first
        super().initialize(
            _application(host, self),
            max_header_size=1 << 14,
            max_body_size=MOST_BYTES,
            max_buffer_size=2 * MOST_BYTES,
            idle_connection_timeout=_PATIENCE,
            body_timeout=_PATIENCE,
        )

    def handle_stream(self, stream: tornado.iostream.IOStream, address: tuple[Any, ...]) -> None:
        """Take a connection; if there are too many, close the oldest."""
        for other in [other for other in self._requests if other.closed()]:
            del self._requests[other]
        while len(self._requests) >= _MOST_REQUESTS:
            oldest = next(iter(self._requests))
            del self._requests[oldest]
            oldest.close()
        self._requests[stream] = None
        super().handle_stream(stream, address)

    def keep(self, stream: tornado.iostream.IOStream | None) -> None:
        """Keep a connection, which is now the link to a page."""
        if stream is not None:
            self._requests.pop(stream, None)


def _application(host: Host, server: Server) -> tornado.web.Application:
    contents = {
        "": ("text/html", _PAGE),
        "view.css": ("text/css", style()),
        "view.js": ("text/javascript", script()),
        "page.js": ("text/javascript", page_script()),
    }
    files = [
        tornado.routing.Rule(_At(host.secret, name), _File, {"host": host, "content": content})
        for name, content in contents.items()
    ]
    line = tornado.routing.Rule(
        _At(host.secret, "socket"), Socket, {"host": host, "server": server}
    )
    return tornado.web.Application(
        [*files, line],
        default_handler_class=_Other,
        default_handler_args={"host": host},
        websocket_max_message_size=MOST_BYTES,
        websocket_ping_interval=_PING,
        log_function=lambda handler: None,
    )


class _At(tornado.routing.Matcher):
    """A name below the secret, compared in constant time."""

    def __init__(self, secret: str, name: str) -> None:
        self._secret, self._name = secret.encode(), name

    def match(self, request: tornado.httputil.HTTPServerRequest) -> dict[str, Any] | None:
        secret, _, name = request.path.removeprefix("/").partition("/")
        is_ours = secrets.compare_digest(secret.encode(), self._secret)
        return {} if is_ours and "/" in request.path[1:] and name == self._name else None


class _Guarded(tornado.web.RequestHandler):
    """Answers only robsim's own pages."""

    def initialize(self, host: Host) -> None:
        self._host = host

    def set_default_headers(self) -> None:
        for name, value in _HEADERS.items():
            self.set_header(name, value.replace("{host}", self.request.host))
        self.clear_header("Server")

    def prepare(self) -> None:
        if not self._is_allowed():
            raise tornado.web.HTTPError(403)

    def write_error(self, status_code: int, **_: Any) -> None:
        self.finish()

    def _is_allowed(self) -> bool:
        """Return whether the request is from robsim's page: no rebound name, no other site."""
        hosts = [f"{name}:{self._host.port}" for name in ("127.0.0.1", "localhost")]
        origins = [None, *(f"http://{host}" for host in hosts)]
        headers = self.request.headers
        return headers.get("Host") in hosts and headers.get("Origin") in origins


class _File(_Guarded):
    def initialize(self, host: Host, content: tuple[str, str]) -> None:  # type: ignore[override]
        super().initialize(host)
        self._content = content

    def get(self) -> None:
        kind, text = self._content
        self.set_header("Content-Type", f"{kind}; charset=utf-8")
        self.finish(text.replace("{kind}", self._host.view.kind) if kind == "text/html" else text)


class _Other(_Guarded):
    """Redirects a browser with a valid ticket to the page."""

    def prepare(self) -> None:
        super().prepare()
        ticket = self._host.ticket
        if self.request.method != "GET" or ticket is None or not ticket.is_path(self.request.path):
            raise tornado.web.HTTPError(404)
        connection: Any = self.request.connection
        if self._host.redeem(ticket, connection.context.address):
            self.redirect(f"/{self._host.secret}/")
        else:
            self.set_status(403)
            self.finish(_REFUSED)


class Socket(_Guarded, tornado.websocket.WebSocketHandler):
    """The link to one page."""

    def initialize(self, host: Host, server: Server) -> None:  # type: ignore[override]
        super().initialize(host)
        self._server = server
        self._link: PageLink | None = None
        self._view = host.view
        self._stream: tornado.iostream.IOStream | None = None
        self._protocol: Any = None
        self._is_cut = False

    def prepare(self) -> None:
        super().prepare()
        if len(self._host.pages) >= _MOST_PAGES:
            raise tornado.web.HTTPError(503)

    def check_origin(self, origin: str) -> bool:
        return True  # checked in `prepare`

    def open(self, *_: str, **__: str) -> None:
        assert self.ws_connection is not None
        self._protocol, self._stream = self.ws_connection, self.ws_connection.stream
        self._server.keep(self._stream)
        self.set_nodelay(True)
        self._link = PageLink(self, asyncio.get_running_loop())
        self._host.came(self)
        self._view.connect(self._link)
        if self.get_query_argument("kind", self._view.kind) != self._view.kind:
            self._link.send({"type": "moved"})  # the view moved while the page was disconnected

    def cut(self) -> None:
        """Close the link at once, without a message."""
        self._is_cut = True
        if self._stream is not None:
            self._stream.close()

    def on_message(self, message: str | bytes) -> None:
        assert self._link is not None
        self._view.receive(self._link, *unpacked_message(message))

    def on_close(self) -> None:
        if self._link is not None:
            protocol = self._protocol
            timed_out = protocol.server_terminated and not protocol.client_terminated
            self._host.went(self, is_stalled=self._is_cut or timed_out)
            self._view.disconnect(self._link)


def unpacked_message(message: str | bytes) -> tuple[Any, Buffers]:
    """Return the content of a browser's message, and its buffers; None = invalid."""
    try:
        if isinstance(message, str):
            return json.loads(message), ()
        return _unpacked(message)
    except (ValueError, RecursionError, struct.error):
        return None, ()


def _unpacked(packed: bytes) -> tuple[Any, Buffers]:
    (length,) = struct.unpack_from("<I", packed)
    head = json.loads(packed[4 : 4 + length])
    lengths = head.get("buffers") if isinstance(head, dict) else None
    if not isinstance(lengths, list) or any(type(one) is not int or one < 0 for one in lengths):
        raise ValueError("the lengths of the buffers are missing")
    at, buffers = 4 + length, []
    for length in lengths:
        buffers.append(packed[at : at + length])
        at += length + -length % 4
    if at != len(packed):
        raise ValueError("the buffers have different lengths")
    return head, buffers


class PageLink(Link):
    """The link to one page, for the view."""

    def __init__(self, socket: Socket, loop: asyncio.AbstractEventLoop) -> None:
        super().__init__()
        self._socket = socket
        self._loop = loop
        self._behind = 0  # bytes waiting to be sent

    @property
    def is_behind(self) -> bool:
        return self._behind > _MUCH_BEHIND

    def transmit(self, head: Mapping[str, Any], buffers: Buffers) -> None:
        packed = packed_message(head, buffers)
        self._loop.call_soon_threadsafe(self._write, packed)  # RuntimeError: the server has ended

    def _write(self, packed: bytes) -> None:
        if self._behind > _MOST_BEHIND:
            self._socket.cut()
            return
        try:
            sent = self._socket.write_message(packed, binary=True)
        except tornado.websocket.WebSocketClosedError:
            return
        self._behind += len(packed)
        sent.add_done_callback(lambda done: self._is_sent(done, len(packed)))

    def _is_sent(self, done: asyncio.Future[None], length: int) -> None:
        self._behind -= length
        if not done.cancelled():
            done.exception()  # retrieved: the page has disconnected


def packed_message(head: Mapping[str, Any], buffers: Buffers) -> bytes:
    """Return a message as one block of bytes; see PROTOCOL.md."""
    lengths = [len(buffer) for buffer in buffers]
    text = json.dumps({**head, "buffers": lengths}, separators=(",", ":"), allow_nan=False)
    content = text.encode()
    content += b" " * (-len(content) % 4)
    parts = [struct.pack("<I", len(content)), content]
    for buffer in buffers:
        parts += [buffer, b"\0" * (-len(buffer) % 4)]
    return b"".join(parts)
