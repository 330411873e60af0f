"""MJPEG over HTTP: a stream of JPEG images, one part of a multipart document each."""

from __future__ import annotations

import base64
import io
import socket
import ssl
import time
from email.message import Message
from http.client import HTTPException, parse_headers
from typing import Any
from urllib.parse import unquote, urlsplit

from robsim._base.text import cut, one_line
from robsim.capture._errors import (
    CaptureError,
    FrameTimeoutError,
    NoCameraError,
    NoPermissionError,
    UnpluggedError,
)
from robsim.capture._jpeg import decoded
from robsim.capture._multipart import Parts

_WAIT = 0.1  # s in one call
_AT_ONCE = 1 << 18  # bytes
_LONGEST_HEAD = 1 << 16  # bytes


class HttpCamera:
    """The camera in Python of an address. It needs no OpenCV, and waits for ever without harm.

    Parameters
    ----------
    url : str
        ``http://host:port/path``; ``http://user:password@host`` logs in.
    open_timeout : float
        Maximum wait for the answer (s).
    """

    def __init__(self, url: str, open_timeout: float) -> None:
        parts = urlsplit(url)
        try:
            self._port = parts.port or (443 if parts.scheme == "https" else 80)
        except ValueError as error:
            raise ValueError(f"source must be an address, got {one_line(url)}: {error}") from None
        if not parts.hostname:
            raise ValueError(f"source must be an address with a host, got {one_line(url)}")
        self._host = parts.hostname
        self._path = (parts.path or "/") + (f"?{parts.query}" if parts.query else "")
        self._is_secure = parts.scheme == "https"
        self._login = None
        if parts.username is not None:
            login = f"{unquote(parts.username)}:{unquote(parts.password or '')}"
            self._login = base64.b64encode(login.encode()).decode()
        self.name = f"{parts.scheme}://{self._host}:{self._port}{one_line(self._path)}"
        self._open_timeout = open_timeout
        self._socket: socket.socket | None = None
        self._parts = Parts(b"")

    def open(self) -> None:
        """Ask for the stream."""
        self.close()
        end = time.monotonic() + self._open_timeout
        try:
            self._socket = socket.create_connection((self._host, self._port), self._open_timeout)
            if self._is_secure:
                context = ssl.create_default_context()
                self._socket = context.wrap_socket(self._socket, server_hostname=self._host)
            self._socket.sendall(self._request())
            head, rest = self._head(self._socket, end)
        except TimeoutError:
            raise FrameTimeoutError(
                f"{self.name} did not answer within {self._open_timeout:g} s: is it on, and does "
                "the address lead to it?"
            ) from None
        except OSError as error:
            raise NoCameraError(
                f"{self.name} cannot be reached ({cut(error)}): is the camera on, and are host "
                "and port right?"
            ) from error
        self._parts = Parts(self._boundary(head))
        self._parts.feed(rest)
        self._socket.settimeout(_WAIT)

    def _request(self) -> bytes:
        lines = [f"GET {self._path} HTTP/1.0", f"Host: {self._host}:{self._port}"]
        if self._login is not None:
            lines.append(f"Authorization: Basic {self._login}")
        return "\r\n".join([*lines, "", ""]).encode("ascii", "replace")

    def _head(self, connection: socket.socket, end: float) -> tuple[bytes, bytes]:
        data = b""
        while b"\r\n\r\n" not in data:
            connection.settimeout(max(end - time.monotonic(), 1e-3))
            received = connection.recv(_AT_ONCE)
            if not received or len(data) > _LONGEST_HEAD:
                raise NoCameraError(f"{self.name} gives no answer of HTTP: is it a camera?")
            data += received
        head, _, rest = data.partition(b"\r\n\r\n")
        return head + b"\r\n\r\n", rest

    def _boundary(self, head: bytes) -> bytes:
        stream = io.BytesIO(head)
        words = stream.readline().decode("latin-1").strip().split(None, 2)
        status = words[1] if len(words) > 1 else ""
        try:
            headers: Message = parse_headers(stream)
        except HTTPException:
            headers = Message()
        if status in ("401", "403"):
            raise NoPermissionError(
                f"{self.name} answers {status}: give user and password in the address, as "
                "http://user:password@host/path (digest authentication: back_end='ffmpeg')"
            )
        if status != "200":
            said = cut(" ".join(words[1:]))
            where = f" {cut(headers['Location'])}" if headers["Location"] else ""
            raise NoCameraError(f"{self.name} answers {said}{where}: is the path right?")
        boundary = headers.get_param("boundary")
        if headers.get_content_maintype() != "multipart" or not isinstance(boundary, str):
            raise CaptureError(
                f"{self.name} sends {cut(headers.get_content_type())} and no MJPEG stream: give "
                "the address of that, or back_end='ffmpeg'"
            )
        return boundary.encode("latin-1", "replace")

    def read(self) -> tuple[Any, None] | None:
        """Return the next image, or None if none has come yet."""
        assert self._socket is not None
        end = time.monotonic() + _WAIT
        while (part := self._parts.next()) is None:
            if time.monotonic() > end:
                return None
            try:
                received = self._socket.recv(_AT_ONCE)
            except TimeoutError:
                return None
            except OSError as error:
                raise UnpluggedError(f"{self.name} broke off: {cut(error)}") from error
            if not received:
                raise UnpluggedError(
                    f"{self.name} has ended the stream: is the camera off, or is another reader "
                    "connected?"
                )
            self._parts.feed(received)
        return decoded(part), None

    def close(self) -> None:
        """Close the connection."""
        if self._socket is not None:
            self._socket.close()
        self._socket = None
