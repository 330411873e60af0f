"""Users for workers: unused numbers, one for each worker that runs on a machine."""

from __future__ import annotations

import os
import signal
import socket
import sys
import threading
from contextlib import suppress

from robsim.teach.isolation._layers.calls import has_capability

assert sys.platform == "linux"

#: Numbers that systemd's list of users keeps free.
FIRST_USER, LAST_USER = 60600, 61180
# To hand over a folder, to remove its content, to end processes, to change group and user.
_NEEDED = (0, 1, 5, 6, 7)
_taken: dict[int, socket.socket] = {}
_lock = threading.Lock()


def take_user() -> int | None:
    """Return a user number for one worker, until `give_back`; None = no right, or no free one.

    A socket of that name marks the number as taken for graders in other processes. The kernel
    removes the socket when its process ends.
    """
    if os.geteuid() != 0 or not all(map(has_capability, _NEEDED)):
        return None
    used = _users_of_processes()
    with _lock:
        for user in range(FIRST_USER, LAST_USER + 1):
            if user in _taken or user in used or _has_name(user):
                continue
            claim = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
            try:
                claim.bind(f"\0robsim-worker-{user}")
            except OSError:
                claim.close()
                continue
            _taken[user] = claim
            return user
    return None


def reason() -> str:
    """Return the reason why no user is available for a worker."""
    if os.geteuid() != 0:
        return "needs root"
    if not all(map(has_capability, _NEEDED)):
        return "root lacks some of its rights here"
    return "all are taken"


def give_back(user: int) -> None:
    with _lock:
        claim = _taken.pop(user, None)
    if claim is not None:
        claim.close()


def _users_of_processes() -> set[int]:
    users = set()
    for name in os.listdir("/proc"):
        if name.isdigit():
            with suppress(OSError):
                users.add(os.stat(f"/proc/{name}").st_uid)
    return users


def _has_name(user: int) -> bool:
    import pwd

    try:
        pwd.getpwuid(user)
    except KeyError:
        return False
    return True


def become(user: int) -> None:
    """Change this process to a user forever."""
    os.setgroups([])
    os.setresgid(user, user, user)
    os.setresuid(user, user, user)


def end_all_of(user: int) -> None:
    """End a user's processes with one signal, before any can fork; for root with one thread."""
    child = os.fork()
    if child == 0:
        try:
            become(user)
            os.kill(-1, signal.SIGKILL)
        except BaseException:  # no process to end
            pass
        finally:
            os._exit(0)
    os.waitpid(child, 0)


def can_read(user: int, path: str) -> bool:
    """Return whether a user without any of our groups can reach a folder and read in it."""
    here = os.path.realpath(path)
    while True:
        status = os.stat(here)
        # The owner's rights do not hold for our numbers: others' rights count.
        needed = 0o5 if here == os.path.realpath(path) else 0o1
        if status.st_mode & needed != needed and status.st_uid != user:
            return False
        if here == os.path.dirname(here):
            return True
        here = os.path.dirname(here)
