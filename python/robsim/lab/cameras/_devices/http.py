"""MJPEG over HTTP: a stream of JPEG images, one part of a multipart document each."""

from __future__ import annotations

import base64
import io
import socket
import time
from email.message import Message
from http.client import HTTPException, parse_headers
from typing import Any
from urllib.parse import unquote, urlsplit

import numpy as np
from PIL import Image

from robsim._core import ImageStream, is_whole_jpeg
from robsim.base.text import cut, one_line
from robsim.lab.cameras.errors import CaptureError, NoCameraError, NoPermissionError, unreached
from robsim.vision.imaging.images import MOST_PIXELS


def decoded(data: bytes) -> Any:
    """Return the pixels of a JPEG image, array (H, W, 3); None if it is torn or none.

    Decoders fill up what is missing: Pillow if there is an end marker, FFmpeg and OpenCV always.
    """
    if not is_whole_jpeg(data):
        return None
    try:
        with Image.open(io.BytesIO(data), formats=("JPEG",)) as image:
            if image.width * image.height > MOST_PIXELS:
                return None
            return np.asarray(image if image.mode == "RGB" else image.convert("RGB"))
    except (OSError, ValueError, SyntaxError):
        return None


_WAIT = 0.1  # s in one call
_AT_ONCE = 1 << 18  # bytes
_LONGEST_HEAD = 1 << 16  # bytes


class HttpCamera:
    """The camera in Python of an address. It needs no OpenCV; the interpreter decodes alone.

    The url is ``http://host:port/path``; ``http://user:password@host`` logs in. The answer comes
    within `open_timeout` (s).
    """

    def __init__(self, url: str, open_timeout: float) -> None:
        parts = urlsplit(url)
        try:
            self._port = parts.port or 80
        except ValueError as error:
            raise ValueError(f"source must be an address, got {one_line(url)}: {error}") from None
        if not parts.hostname:
            raise ValueError(f"source must be an address with a host, got {one_line(url)}")
        self._host = parts.hostname
        self._path = (parts.path or "/") + (f"?{parts.query}" if parts.query else "")
        self._login = None
        if parts.username is not None:
            login = f"{unquote(parts.username)}:{unquote(parts.password or '')}"
            self._login = base64.b64encode(login.encode()).decode()
        host = f"[{self._host}]" if ":" in self._host else self._host
        self._authority = f"{host}:{self._port}"
        self.name = f"http://{self._authority}{one_line(self._path)}"
        self._open_timeout = open_timeout
        self._stream: ImageStream | None = None

    def open(self) -> None:
        """Ask for the stream."""
        self.close()
        end = time.monotonic() + self._open_timeout
        try:
            with socket.create_connection((self._host, self._port), self._open_timeout) as line:
                line.sendall(self._request())
                head, begun = self._head(line, end)
                boundary, is_chunked = self._form(head)
                self._stream = ImageStream(
                    line.fileno(),
                    boundary=boundary,
                    begun=begun,
                    is_chunked=is_chunked,
                    name=self.name,
                )
        except CaptureError:
            raise
        except OSError as error:
            raise unreached(self.name, self._open_timeout, error) from error

    def _request(self) -> bytes:
        lines = [f"GET {self._path} HTTP/1.0", f"Host: {self._authority}"]
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

    def _form(self, head: bytes) -> tuple[bytes, bool]:
        """Return the boundary of the parts, and whether the stream comes in chunks."""
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
        # Many small cameras answer so even where HTTP/1.0 is asked for.
        is_chunked = headers.get("Transfer-Encoding", "").strip().lower() == "chunked"
        return boundary.strip('" ').encode("latin-1", "replace"), is_chunked

    def read(self) -> tuple[Any, None, float, int, int] | None:
        """Return the newest image, or None if none has come yet."""
        assert self._stream is not None
        taken = self._stream.take(_WAIT)
        if taken is None:
            return None
        jpeg, arrived, n_passed, n_torn = taken
        if not jpeg:
            return None, None, arrived, 0, n_torn - 1
        return decoded(jpeg), None, arrived, n_passed, n_torn

    def close(self) -> None:
        self._stream = None
