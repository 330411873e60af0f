"""Namespaces: a worker's own process numbers, which end when the worker ends, and no network."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from robsim.teach.isolation._layers.calls import (
    CLONE_NEWIPC,
    CLONE_NEWNET,
    CLONE_NEWPID,
    CLONE_NEWUSER,
    PR_SET_PDEATHSIG,
    prctl,
    setns,
    unshare,
)
from robsim.teach.isolation._layers.layer import NETWORK, PIDS, Layer, attempt

assert sys.platform == "linux"

_OWN_PIDS = "/proc/self/ns/pid"


def leave_network(*, leave: bool = True) -> Layer:
    """Give this process and its children a network without any device; needs one thread."""
    return attempt(NETWORK, _leave_network) if leave else Layer.left_out(NETWORK)


def _leave_network() -> str:
    user, group = os.geteuid(), os.getegid()
    if not user:
        unshare(CLONE_NEWNET | CLONE_NEWIPC)
    else:  # the user stays the same, and has no right over anything outside
        unshare(CLONE_NEWNET | CLONE_NEWIPC | CLONE_NEWPID | CLONE_NEWUSER)
        for name, text in (("setgroups", "deny"), ("uid_map", f"{user} {user} 1")):
            _write(name, text)
        _write("gid_map", f"{group} {group} 1")
    return ""


def be_first(before: Callable[[], None]) -> None:
    """Continue in a child, the first of the namespace of processes that `leave_network` has made.

    A user other than root can make further such namespaces only from within one. This process
    waits, after a last act, and ends like its child. If this process ends first, the child ends.
    """
    child = os.fork()
    if child == 0:
        prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
        return
    before()
    _, status = os.waitpid(child, 0)
    os._exit(status and 1)


def _write(name: str, text: str) -> None:
    with open(f"/proc/self/{name}", "w") as file:
        file.write(text)


@contextmanager
def own_pids(*, leave: bool = True) -> Iterator[Layer]:
    """Let the process forked inside be the first of a namespace, and its end the namespace's."""
    if not leave:
        yield Layer.left_out(PIDS)
        return
    try:
        unshare(CLONE_NEWPID)
    except OSError as error:
        yield Layer(PIDS, False, error.strerror or str(error))
        return
    try:
        yield Layer(PIDS, True, "")
    finally:  # later children are ordinary ones again
        descriptor = os.open(_OWN_PIDS, os.O_RDONLY | os.O_CLOEXEC)
        try:
            setns(descriptor, CLONE_NEWPID)
        finally:
            os.close(descriptor)
