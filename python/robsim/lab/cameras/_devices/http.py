"""MJPEG over HTTP: a stream of JPEG images, one part of a multipart document each."""

from __future__ import annotations

import contextlib
import re
import socket
import threading
import time
from collections.abc import Iterable, Iterator
from http.client import HTTPException, HTTPResponse
from typing import Any
from urllib import request
from urllib.error import HTTPError
from urllib.parse import quote, unquote, urlsplit

from robsim._core import is_whole_jpeg
from robsim.base.text import cut, one_line
from robsim.lab.cameras._devices.jpeg import pixels
from robsim.lab.cameras.errors import (
    CaptureError,
    NoCameraError,
    NoPermissionError,
    UnpluggedError,
    unreached,
)

_WAIT = 0.1  # s in one call
# bytes:
_AT_ONCE = 1 << 18
_LONGEST_LINE = 1 << 10
_LONGEST_HEAD = 1 << 16
_LONGEST_PART = 1 << 26
# Some cameras send no carriage returns.
_BLANK_LINE = re.compile(rb"\n\r*\n")
_LENGTH = re.compile(rb"\ncontent-length:[ \t]*(\d{1,8})(?!\d)", re.IGNORECASE)
_IMAGE, _SCAN = 0xD8, 0xDA
_END_OF_IMAGE = b"\xff\xd9"


class Parts:
    """Cuts a multipart stream, in any pieces, into the bodies of its parts.

    A part ends at its Content-Length, or at an earlier boundary: then it was cut short. Without a
    length it ends with the end marker of JPEG, as the next boundary comes with the next image.
    """

    def __init__(self, boundary: bytes) -> None:
        # With the end of its line: a short one alone may stand in an image by chance.
        self._boundary = re.compile(rb"--" + re.escape(boundary.lstrip(b"-")) + rb"[ \t]*\r?\n")
        self._data = bytearray()
        self._is_in_body = False
        self._length: int | None = None
        self._scan = self._searched = 0  # where the first one begins; bytes without a boundary

    def feed(self, piece: bytes) -> Iterator[bytes]:
        """Yield the bodies that a piece completes."""
        self._data += piece
        while self._is_in_body or self._skip_head():
            end = self._end_of_body()
            if end is None:
                return
            yield bytes(self._data[:end])
            del self._data[:end]
            self._is_in_body = False

    def _skip_head(self) -> bool:
        data = self._data
        begin = self._boundary.search(data)
        end = begin and _BLANK_LINE.search(data, begin.end() - 1)
        if begin is None:
            del data[:-_LONGEST_LINE]
        elif end is None and len(data) - begin.start() > _LONGEST_HEAD:
            del data[: begin.end()]
        if begin is None or end is None:
            return False
        length = _LENGTH.search(data, begin.end() - 1, end.end())
        self._length = int(length[1]) if length else None
        del data[: end.end()]
        self._is_in_body = True
        self._scan = self._searched = 0
        return True

    def _end_of_body(self) -> int | None:
        data, length = self._data, self._length
        # Texts and thumbnails before the first scan may hold boundaries and ends of images.
        while len(data) >= self._scan + 4 and data[self._scan] == 0xFF != data[self._scan + 1]:
            kind = data[self._scan + 1]
            if kind == _SCAN:
                break
            size = int.from_bytes(data[self._scan + 2 : self._scan + 4], "big")
            self._scan += 2 if kind == _IMAGE else 2 + size
        boundary = self._boundary.search(data, max(self._scan, self._searched))
        if boundary and (length is None or boundary.start() < length):
            return boundary.start()
        self._searched = max(0, len(data) - _LONGEST_LINE)
        if length is not None and len(data) >= length:
            return length
        tail = bytes(data[-_LONGEST_LINE:])
        end = len(data) - len(tail) + len(tail.rstrip(b"\r\n"))
        if length is None and end > self._scan and data.endswith(_END_OF_IMAGE, 0, end):
            return end
        return len(data) if len(data) > _LONGEST_PART else None


class _Answers(request.HTTPErrorProcessor):
    """Ignores the text of an error or a redirect, which may be endless."""

    def http_response(self, request: request.Request, response: HTTPResponse) -> HTTPResponse:
        if response.status != 200:
            response.length, response.chunked = 0, False
        answer: HTTPResponse = super().http_response(request, response)
        return answer

    https_response = http_response


class HttpCamera:
    """The HTTP camera of an address, opened once; its images are BGR.

    The url is ``http://host:port/path``; ``http://user:password@host`` logs in if that host
    requires a login. A thread reads the stream and keeps its newest whole image.
    """

    def __init__(self, url: str, open_timeout: float) -> None:
        self.options = {"url": url, "open_timeout": open_timeout}
        self.open_timeout = open_timeout
        parts = urlsplit(url)
        try:
            host, _ = parts.hostname, parts.port
        except ValueError as error:
            raise ValueError(f"source must be an address, got {one_line(url)}: {error}") from None
        if not host:
            raise ValueError(f"source must be an address with a host, got {one_line(url)}")
        self._host = f"http://{parts.netloc.rpartition('@')[2]}"
        query = f"?{parts.query}" if parts.query else ""
        self._url = self._host + quote((parts.path or "/") + query, "/?%:=&~+!$,;'@()*[]")
        self.name = one_line(self._url)
        self._passwords = request.HTTPPasswordMgrWithDefaultRealm()
        if parts.username is not None:
            user, password = unquote(parts.username), unquote(parts.password or "")
            self._passwords.add_password(None, f"{self._host}/", user, password)
        self._changed = threading.Condition()  # guards what follows
        self._response: HTTPResponse | None = None
        self._end: CaptureError | None = None
        self._newest: tuple[bytes, float] | None = None  # image, when it arrived
        self._n_passed = self._n_torn = 0

    def open(self) -> None:
        """Request the stream."""
        threading.Thread(target=self._run, daemon=True).start()
        with self._changed:
            self._changed.wait_for(lambda: self._response or self._end, self.open_timeout)
            if self._response is None:
                raise self._end or unreached(self.name, self.open_timeout, TimeoutError())

    def _run(self) -> None:
        try:
            with self._asked() as response:
                parts, piece = self._begun(response)
                with self._changed:
                    self._response = response
                    self._changed.notify()
                while self._end is None and (piece := piece or response.read1(_AT_ONCE)):
                    self._keep(parts.feed(piece), time.monotonic())
                    piece = b""
            end: CaptureError = UnpluggedError(
                f"{self.name} has ended the stream: is the camera off, or is another reader "
                "connected?"
            )
        except CaptureError as error:
            end = error
        except Exception as error:
            end = UnpluggedError(f"{self.name} broke off: {cut(error)}")
        with self._changed:
            self._end = end
            self._changed.notify()

    def _asked(self) -> HTTPResponse:
        """Return the answer, only by HTTP and without a proxy."""
        opener = request.OpenerDirector()
        for handler in (
            *(request.HTTPHandler(), request.HTTPSHandler(), request.UnknownHandler()),
            *(request.HTTPRedirectHandler(), request.HTTPDefaultErrorHandler(), _Answers()),
            request.HTTPDigestAuthHandler(self._passwords),
            request.HTTPBasicAuthHandler(self._passwords),
        ):
            opener.add_handler(handler)
        try:
            response: HTTPResponse = opener.open(self._url)
            return response
        except HTTPError as error:
            if error.code in (401, 403):
                raise NoPermissionError(
                    f"{self.name} answers {error.code}: pass user and password in the address, as "
                    "http://user:password@host/path; robsim sends the password only to this host"
                ) from None
            why, place = str(error.reason).partition("\n")[0], error.headers.get("Location", "")
            said = cut(f"{error.code} {why} {place}".strip())
            raise NoCameraError(f"{self.name} answers {said}: check the path") from None
        except (HTTPException, ValueError) as error:
            raise NoCameraError(
                f"{self.name} gives no valid HTTP answer ({cut(error)}): is it a camera?"
            ) from None
        except OSError as error:
            reason = getattr(error, "reason", error)
            raise unreached(self.name, self.open_timeout, reason) from None

    def _begun(self, response: HTTPResponse) -> tuple[Parts, bytes]:
        """Return the parser of the parts, and their first bytes."""
        kind, boundary = response.headers.get_content_type(), response.headers.get_param("boundary")
        if kind.startswith("multipart/") and isinstance(boundary, str):
            response.length = None  # some cameras tell one
            return Parts(boundary.strip('" ').encode("latin-1", "replace")), b""
        begun = b""
        while b"\n" not in begun.lstrip() and len(begun) < _LONGEST_LINE:
            if not (piece := response.read1(_AT_ONCE)):
                break
            begun += piece
        line, _, rest = begun.lstrip().partition(b"\n")
        if line.startswith(b"--") and rest:
            return Parts(line.rstrip()), begun
        what = "a single image" if begun.startswith(b"\xff\xd8") else cut(kind)
        raise CaptureError(
            f"{self.name} sends {what}, not an MJPEG stream: pass the stream's address, or "
            "back_end='ffmpeg'"
        )

    def _keep(self, images: Iterable[bytes], arrived: float) -> None:
        for image in images:
            is_whole = is_whole_jpeg(image)
            with self._changed:
                if is_whole:
                    self._n_passed += self._newest is not None
                    self._newest = image, arrived
                else:
                    self._n_torn += 1
                self._changed.notify()

    def read(self) -> tuple[Any, None, float, int, int] | None:
        """Return the newest image in the form of `PythonCamera`, or None without an image."""
        with self._changed:
            self._changed.wait_for(lambda: self._newest or self._n_torn or self._end, _WAIT)
            newest, n_passed, n_torn = self._newest, self._n_passed, self._n_torn
            self._newest, self._n_passed, self._n_torn = None, 0, 0
            if newest is None and not n_torn:
                if self._end is None:
                    return None
                raise self._end
        if newest is None:
            return None, None, time.monotonic(), 0, n_torn - 1
        image, arrived = newest
        return pixels(image), None, arrived, n_passed, n_torn

    def close(self) -> None:
        """End the thread during any wait."""
        with self._changed:
            self._end = self._end or UnpluggedError(f"{self.name} is closed")
        if self._response is not None:
            with contextlib.suppress(AttributeError, OSError, ValueError):  # of one that ended
                line = socket.fromfd(self._response.fileno(), socket.AF_INET, socket.SOCK_STREAM)
                with line:
                    line.shutdown(socket.SHUT_RDWR)
