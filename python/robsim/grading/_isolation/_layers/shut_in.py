"""What a worker does to itself before any code of a student's: all layers, in their order."""

from __future__ import annotations

import os
import signal
import sys
import sysconfig
from collections.abc import Iterable, Sequence
from pathlib import Path

from robsim.grading._isolation._layers import calls, landlock, seccomp, users
from robsim.grading._isolation._layers.layer import (
    CALLS,
    FILES,
    MEMORY,
    USER,
    Layer,
    attempt,
)
from robsim.grading._isolation._layers.limits import limit
from robsim.grading._isolation._request import Request

# What the interpreter and compiled libraries read late. Nothing of a user's is in there.
_SYSTEM = (
    *("/lib", "/lib64", "/usr/lib", "/usr/lib64", "/usr/local/lib"),
    *("/etc/ld.so.cache", "/etc/localtime", "/etc/fonts", "/usr/share/zoneinfo"),
    *("/usr/share/fonts", "/usr/local/share/fonts", "/dev/zero", "/dev/urandom"),
    *("/proc/cpuinfo", "/proc/meminfo", "/sys/devices/system/cpu"),
)


def shut_in(request: Request, grants: Sequence[landlock.Grant]) -> list[Layer]:
    """Shut this process in: limits, user, memory, files, system calls. Return what held."""
    layers = [limit(request.limits, own_user=request.user is not None and request.shut)]
    if request.shut:
        layers.append(_change_user(request.user, landlocked=bool(landlock.landlock_abi())))
        layers.append(attempt(MEMORY, _close_memory))
        calls.prctl(calls.PR_SET_PDEATHSIG, signal.SIGKILL)  # a change of user has cleared it
        layers.append(attempt(FILES, lambda: f"Landlock {_keep_to(grants)}"))
        for descriptor, _ in grants:
            os.close(descriptor)
        layers.append(attempt(CALLS, _refuse_calls))
    else:
        calls.drop_capabilities()
        calls.prctl(calls.PR_SET_PDEATHSIG, signal.SIGKILL)
    return layers


def readable_trees(modules: Iterable[str]) -> list[Path]:
    """Return what a worker may read: Python, installed packages, libraries, loaded modules."""
    names = ("stdlib", "platstdlib", "purelib", "platlib")
    trees = [sysconfig.get_path(name) for name in names]
    trees += [os.path.join(sys.base_prefix, "lib")] if sys.base_prefix != "/usr" else []
    trees += [path for path in sys.path if path.endswith(("site-packages", "dist-packages"))]
    for name in {module.partition(".")[0] for module in modules}:
        file = getattr(sys.modules.get(name), "__file__", None)
        if file and os.path.basename(file) == "__init__.py":  # one that is not installed there
            trees.append(os.path.dirname(file))
    return [Path(tree) for tree in (*trees, *_SYSTEM) if os.path.exists(tree)]


def _keep_to(grants: Sequence[landlock.Grant]) -> int:
    """Restrict this process to the grants, and its working folder to write in."""
    own = []
    try:
        for path, rights in ((".", landlock.SCRATCH), ("/dev/null", landlock.DEVICE)):
            own.append((os.open(path, os.O_PATH | os.O_CLOEXEC), rights))
        return landlock.restrict([*grants, *own])
    finally:
        for descriptor, _ in own:
            os.close(descriptor)


def _refuse_calls() -> str:
    seccomp.restrict()
    return "seccomp"


def _change_user(user: int | None, *, landlocked: bool) -> Layer:
    """Become a user of one's own; where its Python is closed to others, only with Landlock.

    Who may read all files reads those alone that Landlock grants.
    """
    if user is None:
        calls.drop_capabilities()
        reason = "needs root" if os.geteuid() else "root lacks some of its rights here"
        return Layer(USER, False, reason)
    homes = {str(tree) for tree in readable_trees(["robsim"]) if tree.is_dir()}
    closed = [home for home in homes if not users.can_read(user, home)]
    reader = calls.CAP_DAC_READ_SEARCH
    try:
        if not closed:
            users.become(user)
            calls.drop_capabilities()
        elif landlocked and calls.has_capability(reader):
            calls.prctl(calls.PR_SET_KEEPCAPS, 1)
            users.become(user)
            calls.drop_capabilities(keep=reader)
        else:
            calls.drop_capabilities()
            return Layer(USER, False, f"others cannot read {closed[0]}")
    except OSError as error:
        calls.drop_capabilities()
        return Layer(USER, False, error.strerror or str(error))
    return Layer(USER, True, str(user))


def _close_memory() -> str:
    """Let no other process look into this one, and this one into none of its user's."""
    calls.prctl(calls.PR_SET_DUMPABLE, 0)
    return "not dumpable"
