"""The parts of a multipart stream, found where they really end."""

from __future__ import annotations

import re

_LENGTH = re.compile(rb"^content-length:\s*(\d{1,9})\s*$", re.IGNORECASE | re.MULTILINE)
_END_OF_IMAGE = b"\xff\xd9"
_LONGEST = 1 << 26  # bytes of a part


class Parts:
    """Cuts what is fed to it into the bodies of its parts.

    A part ends at its Content-Length, or where the next boundary begins if that comes before:
    then it was cut short. Without a length it ends with the end marker of JPEG, so that an image
    is there as soon as its last byte, and not only when the next one begins.

    Parameters
    ----------
    boundary : bytes
        As the header of the stream names it, with or without the two dashes before it.
    """

    def __init__(self, boundary: bytes) -> None:
        self._marker = b"--" + boundary.strip(b'" ').lstrip(b"-")
        self._data = bytearray()
        self._in_body = False
        self._length: int | None = None
        self._searched = 0  # bytes that hold no marker

    def feed(self, data: bytes) -> None:
        """Take what has come."""
        self._data += data

    def next(self) -> bytes | None:
        """Return the next part, or None if there is no whole one yet."""
        if not self._in_body and not self._skip_head():
            return None
        end = self._end_of_body()
        if end is None:
            if len(self._data) <= _LONGEST:
                return None
            end = len(self._data)
        body = bytes(self._data[:end])
        del self._data[:end]
        self._in_body = False
        return body

    def _skip_head(self) -> bool:
        start = self._data.find(self._marker)
        if start < 0:
            del self._data[: max(0, len(self._data) - len(self._marker))]
            return False
        end = self._data.find(b"\r\n\r\n", start)
        if end < 0:
            return False
        length = _LENGTH.search(bytes(self._data[start:end]).replace(b"\r", b""))
        self._length = int(length[1]) if length else None
        del self._data[: end + 4]
        self._in_body = True
        self._searched = 0
        return True

    def _end_of_body(self) -> int | None:
        limit = len(self._data) if self._length is None else self._length
        marker = self._data.find(self._marker, self._searched, limit + len(self._marker))
        if 0 <= marker < limit:
            return marker
        self._searched = max(0, min(len(self._data), limit) - len(self._marker))
        if self._length is not None:
            return limit if len(self._data) >= limit else None
        whole = self._data.rstrip(b"\r\n")
        return len(whole) if whole.endswith(_END_OF_IMAGE) else None
