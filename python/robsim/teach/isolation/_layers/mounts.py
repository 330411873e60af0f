"""Own mounts: a worker finds only the names of granted files."""

from __future__ import annotations

import os
import socket
import sys
from collections.abc import Sequence
from pathlib import Path

from robsim.teach.isolation._layers import calls

assert sys.platform == "linux"

_BIND, _WITH_INNER, _PRIVATE = 1 << 12, 1 << 14, 1 << 18
_MOUNT_SETATTR, _AT_RECURSIVE, _READ_ONLY = 442, 0x8000, (1).to_bytes(32, "little")


def open_view(trees: Sequence[Path], base: str) -> int:
    """Return a mount namespace with only trees, for reading, and a folder; -1 = unavailable."""
    ours, theirs = socket.socketpair()
    with ours, theirs:
        child = os.fork()  # no failure there changes the mounts of this process
        if child == 0:
            try:
                socket.send_fds(theirs, [b"."], [_view(trees, os.path.realpath(base))])
            finally:
                os._exit(0)
        os.waitpid(child, 0)
        theirs.close()
        _, descriptors, *_ = socket.recv_fds(ours, 1, 1)
    return descriptors[0] if descriptors else -1


def _view(trees: Sequence[Path], base: str) -> int:
    os.umask(0o022)
    calls.unshare(calls.CLONE_NEWNS)
    view = os.open("/proc/self/ns/mnt", os.O_RDONLY | os.O_CLOEXEC)
    calls.mount("", "/", _PRIVATE | _WITH_INNER)
    os.chdir(base)  # so that it is the current folder when the root covers it
    calls.mount("tmpfs", base, 0, kind="tmpfs")
    names = {*trees, *(tree.resolve() for tree in trees), Path(os.devnull)}
    for name in names:
        if not names.intersection(name.parents):
            place = Path(f"{base}{name}")
            place.parent.mkdir(parents=True, exist_ok=True)
            place.mkdir() if name.is_dir() else place.touch()
            calls.mount(str(name), str(place), _BIND | _WITH_INNER)
    os.makedirs(f"{base}{base}", exist_ok=True)
    calls.syscall(_MOUNT_SETATTR, 0, os.fsencode(base), _AT_RECURSIVE, _READ_ONLY, 32)
    calls.mount(".", f"{base}{base}", _BIND)
    calls.change_root(base)
    return view


def enter(view: int) -> str:
    """Enter a namespace; in it, the folder of this worker hides its parent folder."""
    if view < 0:
        raise OSError("needs CAP_SYS_ADMIN or user namespaces, pivot_root, and Linux 5.12")
    scratch = os.getcwd()
    calls.setns(view, calls.CLONE_NEWNS)
    os.close(view)
    os.chdir(scratch)
    calls.unshare(calls.CLONE_NEWNS)
    calls.mount(".", "..", _BIND)
    os.chdir("..")
    return ""
