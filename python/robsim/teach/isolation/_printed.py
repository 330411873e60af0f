"""What a worker prints, cut."""

from __future__ import annotations

from robsim.teach.isolation.limits import as_size


class Printed:
    """The first bytes of what a worker prints; the rest is counted, and dropped."""

    def __init__(self, most: int) -> None:
        self._most = most
        self._kept = bytearray()
        self._dropped = 0

    def add(self, part: bytes) -> None:
        """Take some of it."""
        room = self._most - len(self._kept)
        self._kept += part[:room]
        self._dropped += len(part) - len(part[:room])

    @property
    def text(self) -> str:
        """What is kept, with a line that says where it was cut. It may be anything."""
        text = bytes(self._kept).decode("utf-8", "replace")
        return f"{text}\n... cut after {as_size(self._most)}" if self._dropped else text
