"""Users for workers: numbers that nobody has, one for each worker that runs on a machine."""

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
# To hand over a folder, to remove what is in it, to end processes, to change group and user.
_NEEDED = (0, 1, 5, 6, 7)
_taken: dict[int, socket.socket] = {}
_lock = threading.Lock()


def take_user() -> int | None:
    """Return a user number for one worker, until `give_back`; None = no right, or none is free.

    A socket of that name says to graders in other processes that it is taken: the kernel removes
    it with its process.
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
    """Return why there is no user for a worker."""
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
    """Turn this process into one of a user, for good."""
    os.setgroups([])
    os.setresgid(user, user, user)
    os.setresuid(user, user, user)


def end_all_of(user: int) -> None:
    """End a user's processes in one signal, so that none forks away; for root with one thread."""
    child = os.fork()
    if child == 0:
        try:
            become(user)
            os.kill(-1, signal.SIGKILL)
        except BaseException:  # no such process: there was nothing to end
            pass
        finally:
            os._exit(0)
    os.waitpid(child, 0)


def can_read(user: int, path: str) -> bool:
    """Return whether a user without any group of ours can get to a folder and read in it."""
    here = os.path.realpath(path)
    while True:
        status = os.stat(here)
        # Its owner's rights are for none of our numbers: others' rights count.
        needed = 0o5 if here == os.path.realpath(path) else 0o1
        if status.st_mode & needed != needed and status.st_uid != user:
            return False
        if here == os.path.dirname(here):
            return True
        here = os.path.dirname(here)
