"""Limits of a process, enforced by the kernel."""

from __future__ import annotations

import math
import resource
import sys

from robsim.teach.isolation._layers.layer import LIMITS, Layer, missing_layers
from robsim.teach.isolation.limits import Request, WorkerLimits, as_size

assert sys.platform != "win32"


def limit(limits: WorkerLimits, *, own_user: bool) -> Layer:
    """Limit memory, processor time, files, and, for a separate user, threads."""
    wanted = {
        "RLIMIT_AS": limits.memory,
        "RLIMIT_CPU": math.ceil(limits.cpu),
        "RLIMIT_FSIZE": limits.file_size,
        "RLIMIT_NOFILE": limits.open_files,
        "RLIMIT_CORE": 0,
        "RLIMIT_MSGQUEUE": 0,
        "RLIMIT_RTPRIO": 0,
    }
    if own_user:  # the kernel counts all processes of a user
        wanted["RLIMIT_NPROC"] = limits.threads
    if refused := [name for name, value in wanted.items() if not _set(name, value)]:
        return Layer(LIMITS, False, f"the system refused {', '.join(refused)}")
    return Layer(LIMITS, True, f"memory {as_size(limits.memory)}, processor time {limits.cpu:g} s")


def _set(name: str, value: int) -> bool:
    kind = getattr(resource, name, None)
    if kind is None:  # missing on this system
        return name in ("RLIMIT_MSGQUEUE", "RLIMIT_RTPRIO")
    _, most = resource.getrlimit(kind)
    if most != resource.RLIM_INFINITY:
        value = min(value, most)
    try:
        resource.setrlimit(kind, (value, value))
    except (OSError, ValueError):
        return False
    return True


def shut_in_elsewhere(request: Request) -> list[Layer]:
    """Limit this process; return the other layers as missing."""
    missing = missing_layers(sys.platform) if request.shut else []
    return [limit(request.limits, own_user=False), *missing]
