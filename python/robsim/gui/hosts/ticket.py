"""The address for starting a browser: it opens the page once, and only for its user."""

from __future__ import annotations

import os
import secrets
import sys
from pathlib import Path

_ESTABLISHED = "01"  # see proc_pid_net(5); a closed socket has no user


class Ticket:
    """A word that opens the page once, because all users can read a browser's arguments."""

    def __init__(self) -> None:
        self.word = secrets.token_urlsafe(18)
        self.is_used = False

    def is_path(self, path: str) -> bool:
        """Whether a path of the server is this word, compared in constant time."""
        return secrets.compare_digest(path.removeprefix("/").encode(), self.word.encode())


def stranger(peer: tuple[str, int], server: tuple[str, int]) -> str:
    """Return the name of a server's peer on loopback if it is another user; otherwise "".

    Only Linux reports the user. macOS and Windows start the browser by a hidden message.
    """
    if sys.platform != "linux":
        return ""
    user = _user_of(_as_listed(*peer), _as_listed(*server))
    if user is None:
        return "an unknown user"
    return "" if user in (os.geteuid(), 0) else f"another user ({user})"


def _user_of(*ends: str) -> int | None:
    for table in ("tcp", "tcp6"):
        try:
            lines = Path("/proc/net", table).read_text("ascii").splitlines()[1:]
        except OSError:
            continue
        for fields in map(str.split, lines):
            if fields[3] == _ESTABLISHED and all(map(str.endswith, fields[1:3], ends)):
                return int(fields[7])
    return None


def _as_listed(address: str, port: int) -> str:
    """Return an IPv4 address as /proc/net/tcp lists it; lines of tcp6 end with the same text."""
    word = int.from_bytes(map(int, address.split(".")), sys.byteorder)
    return f"{word:08X}:{port:04X}"
