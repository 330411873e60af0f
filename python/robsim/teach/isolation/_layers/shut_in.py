"""The sandbox of a worker, before any code of a student: all layers in their order."""

from __future__ import annotations

import sys

assert sys.platform == "linux"

import os
import signal
import sysconfig
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

from robsim.teach.isolation._layers import calls, landlock, layer, mounts, seccomp, users
from robsim.teach.isolation._layers.layer import CALLS, FILES, MEMORY, USER, Layer, attempt
from robsim.teach.isolation._layers.limits import limit
from robsim.teach.isolation.limits import Request

# Paths that the interpreter and compiled libraries read late. They have no data of a user.
_SYSTEM = (
    *("/lib", "/lib64", "/usr/lib", "/usr/lib64", "/usr/local/lib"),
    *("/etc/ld.so.cache", "/etc/localtime", "/etc/fonts", "/usr/share/zoneinfo"),
    *("/usr/share/fonts", "/usr/local/share/fonts", "/dev/zero", "/dev/urandom"),
    *("/proc/cpuinfo", "/proc/meminfo", "/sys/devices/system/cpu"),
)


def shut_in(request: Request, grants: Sequence[landlock.Grant], view: int) -> list[Layer]:
    """Make the sandbox: limits, mounts, user, memory, files, calls. Return the layers."""
    way, reason = way_to(request.user, request)  # needs /proc
    layers = [limit(request.limits, own_user=request.shut and bool(way))]
    if request.shut:
        layers.append(_made(layer.MOUNTS, request, lambda: mounts.enter(view)))
        layers.append(_change_user(request.user, way, reason))
        layers.append(attempt(MEMORY, _close_memory))
        calls.prctl(calls.PR_SET_PDEATHSIG, signal.SIGKILL)  # a change of user has cleared it
        layers.append(_made(FILES, request, lambda: f"Landlock {_keep_to(grants)}"))
        for descriptor, _ in grants:
            os.close(descriptor)
        layers.append(_made(CALLS, request, seccomp.restrict))
    else:
        calls.drop_capabilities()
        calls.prctl(calls.PR_SET_PDEATHSIG, signal.SIGKILL)
    return layers


def _made(name: str, request: Request, act: Callable[[], str]) -> Layer:
    return Layer.left_out(name) if name in request.without else attempt(name, act)


def readable_trees(modules: Iterable[str]) -> list[Path]:
    """Return the readable paths of a worker: Python, installed packages, libraries, modules."""
    names = ("stdlib", "platstdlib", "purelib", "platlib")
    trees = [sysconfig.get_path(name) for name in names]
    trees += [os.path.join(sys.base_prefix, "lib")] if sys.base_prefix != "/usr" else []
    trees += [path for path in sys.path if path.endswith(("site-packages", "dist-packages"))]
    for name in {module.partition(".")[0] for module in modules}:
        file = getattr(sys.modules.get(name), "__file__", None)
        if file and os.path.basename(file) == "__init__.py":  # of a package outside these trees
            trees.append(os.path.dirname(file))
    return [Path(tree) for tree in (*trees, *_SYSTEM) if os.path.exists(tree)]


def _keep_to(grants: Sequence[landlock.Grant]) -> int:
    own = []
    try:
        for path, rights in ((".", landlock.SCRATCH), ("/dev/null", landlock.DEVICE)):
            own.append((os.open(path, os.O_PATH | os.O_CLOEXEC), rights))
        return landlock.restrict([*grants, *own])
    finally:
        for descriptor, _ in own:
            os.close(descriptor)


def way_to(user: int | None, request: Request) -> tuple[str, str]:
    """Return the way in which a process of root becomes a user, or the reason if there is no way.

    If its Python is closed to others, the worker keeps the right to read all files, provided that
    Landlock restricts it to the granted files.
    """
    if USER in request.without or user is None:
        return "", "left out" if USER in request.without else users.reason()
    homes = {str(tree) for tree in readable_trees(["robsim"]) if tree.is_dir()}
    closed = [home for home in homes if not users.can_read(user, home)]
    if not closed:
        return "plainly", ""
    landlocked = FILES not in request.without and landlock.landlock_abi()
    if landlocked and calls.has_capability(calls.CAP_DAC_READ_SEARCH):
        return "as a reader", ""
    return "", f"others cannot read {closed[0]}"


def _change_user(user: int | None, way: str, reason: str) -> Layer:
    reader = calls.CAP_DAC_READ_SEARCH if way == "as a reader" else None
    try:
        if way and user is not None:
            calls.prctl(calls.PR_SET_KEEPCAPS, int(reader is not None))
            users.become(user)
    except OSError as error:
        way, reason = "", error.strerror or str(error)
    calls.drop_capabilities(keep=reader if way else None)
    return Layer(USER, bool(way), reason or str(user))


def _close_memory() -> str:
    calls.prctl(calls.PR_SET_DUMPABLE, 0)
    return "not dumpable"
