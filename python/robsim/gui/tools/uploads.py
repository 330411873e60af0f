"""Files sent by browsers in parts, joined and decoded in memory."""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from robsim.base.text import one_line
from robsim.gui._link import Link, Messages, Refused, one_buffer, text, whole
from robsim.gui._worker import Beside

_LONGEST_NAME = 200  # characters
MOST_BYTES = 64_000_000  # of a file
MOST_OF_A_PART = 1 << 19  # bytes
_MOST_FILES = 4  # of all browsers, incomplete or waiting for decoding
PATIENCE = 60.0  # s for the next part

#: The browsers' messages about uploads.
UPLOAD_MESSAGES: Messages = {
    "upload": {
        "key": text,
        "name": text,
        "size": whole,
        "at": whole,
        "buffers": one_buffer(MOST_OF_A_PART),
    },
    "give_up": {"key": text},
}


@dataclass(eq=False)
class Upload:
    """A file during its upload."""

    link: Link
    view: str  # the sending view in the browser
    key: str  # its key in the browser
    name: str  # for people
    size: int  # bytes
    content: bytearray = field(default_factory=bytearray)
    heard: float = 0.0  # when the newest part came, by the monotonic clock (s)
    is_wanted: bool = True  # False once cancelled

    @property
    def is_complete(self) -> bool:
        return len(self.content) == self.size

    def add(self, message: dict[str, Any]) -> None:
        """Add a part; `Refused` gives the reason against it."""
        part, at = message["buffers"], message["at"]
        if (_name_in(message), message["size"]) != (self.name, self.size):
            raise Refused(f"{self.name} was changed during the upload")
        if at != len(self.content):
            raise Refused(f"{self.name} must continue at byte {len(self.content)}, got byte {at}")
        if not part or at + len(part) > self.size:
            raise Refused(f"the size of {self.name} differs from the announced {self.size} bytes")
        self.content += part


class Uploads:
    """The uploads of a panel, in the thread of its view.

    A browser waits for the answer to a part before it sends the next one. Stalled and cancelled
    uploads are forgotten, also if the link closes. A separate thread decodes one file at a time:
    `read(content, name)` returns a function for the view's thread, or raises ValueError.
    """

    def __init__(self, beside: Beside, read: Callable[[bytes, str], Callable[[], object]]) -> None:
        self._read_file = read
        self._coming: dict[tuple[Link, str], Upload] = {}
        self._complete: deque[Upload] = deque()  # the first one is being decoded
        self._beside = beside

    def take(self, link: Link, message: dict[str, Any]) -> None:
        """Take a part, and send the answer."""
        key = message["key"]
        try:
            upload = self._coming.get((link, key)) or self._begun(link, message)
            upload.add(message)
        except Refused as error:
            self._coming.pop((link, key), None)
            self._answer(link, key, "refused", text=str(error))
            return
        if not upload.is_complete:
            upload.heard = time.monotonic()
            self._answer(link, key, "more", at=len(upload.content))
            return
        del self._coming[link, key]
        self._complete.append(upload)
        self._answer(link, key, "read", at=upload.size)
        if len(self._complete) == 1:
            self._read()

    def drop(self, is_meant: Callable[[Upload], bool]) -> None:
        """Forget some uploads; the result of a decoding under way is dropped."""
        for upload in filter(is_meant, [*self._coming.values(), *self._complete]):
            upload.is_wanted = False
            self._coming.pop((upload.link, upload.key), None)

    def give_up(self, link: Link, message: dict[str, Any]) -> None:
        self.drop(lambda one: one.link is link and one.key == message["key"])

    def look(self, now: float) -> float:
        """Forget stalled uploads; return the time of the next look."""
        self.drop(lambda upload: not upload.is_complete and upload.heard <= now - PATIENCE)
        return min((one.heard + PATIENCE for one in self._coming.values()), default=math.inf)

    def _begun(self, link: Link, message: dict[str, Any]) -> Upload:
        key, name, size = message["key"], _name_in(message), message["size"]
        if message["at"] != 0:
            raise Refused(f"{name} is no longer known: load the file again")
        if size == 0:
            raise Refused(f"{name} is empty")
        if size > MOST_BYTES:
            most = MOST_BYTES // 1_000_000
            raise Refused(f"{name} has {size / 1e6:.1f} MB; at most {most} MB are allowed")
        if len(self._coming) + len(self._complete) >= _MOST_FILES:
            raise Refused("too many uploads at the same time: load the file again later")
        upload = Upload(link, message["id"], key, name, size)
        self._coming[link, key] = upload
        return upload

    def _read(self) -> None:
        """Decode the first complete file."""
        upload = self._complete[0]

        def read() -> Callable[[], object] | str:
            if not upload.is_wanted:
                return ""
            try:
                return self._read_file(bytes(upload.content), upload.name)
            except ValueError as error:
                return str(error)

        self._beside.begin(read, lambda made: self._finish(upload, made))

    def _finish(self, upload: Upload, made: Callable[[], object] | str | None) -> None:
        self._complete.popleft()
        if self._complete:
            self._read()
        if not upload.is_wanted:
            return
        why = made if isinstance(made, str) else f"{upload.name} cannot be loaded"
        if callable(made):
            try:
                made()
            except (ValueError, Refused) as error:
                why = str(error)
            else:
                self._answer(upload.link, upload.key, "taken", at=upload.size)
                return
        self._answer(upload.link, upload.key, "refused", text=why)

    def _answer(self, link: Link, key: str, state: str, *, at: int = 0, text: str = "") -> None:
        link.send({"type": "uploaded", "key": key, "state": state, "at": at, "text": text})


def _name_in(message: dict[str, Any]) -> str:
    return one_line(message["name"])[:_LONGEST_NAME]
