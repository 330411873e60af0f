"""Namespaces: process numbers of a worker's own, which end with it; no network."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager

from robsim.grading._isolation._layers.calls import (
    CLONE_NEWIPC,
    CLONE_NEWNET,
    CLONE_NEWPID,
    CLONE_NEWUSER,
    setns,
    unshare,
)
from robsim.grading._isolation._layers.layer import NETWORK, PIDS, Layer, attempt

_OWN_PIDS = "/proc/self/ns/pid"


def leave_network(*, leave: bool = True) -> Layer:
    """Give this process, and what it starts, a network without any device; needs one thread."""
    return attempt(NETWORK, _leave_network) if leave else Layer.left_out(NETWORK)


def _leave_network() -> str:
    user, group = os.geteuid(), os.getegid()
    unshare(CLONE_NEWNET | CLONE_NEWIPC | (CLONE_NEWUSER if user else 0))
    if user:  # the user remains who it is, and has no right over anything outside
        for name, text in (("setgroups", "deny"), ("uid_map", f"{user} {user} 1")):
            _write(name, text)
        _write("gid_map", f"{group} {group} 1")
    return ""


def _write(name: str, text: str) -> None:
    with open(f"/proc/self/{name}", "w") as file:
        file.write(text)


@contextmanager
def own_pids(*, leave: bool = True) -> Iterator[Layer]:
    """Let the process that is forked within be the first of a namespace, which ends with it."""
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
