"""The start of a worker: by a zygote on Linux, as a fresh process elsewhere."""

from __future__ import annotations

import os
import socket
import sys
from collections.abc import Sequence

from robsim.base.checks import check_choice
from robsim.base.in_browser import check_has_threads
from robsim.base.text import quoted
from robsim.teach.errors import GraderError
from robsim.teach.isolation._process import WorkerProcess
from robsim.teach.isolation.limits import LEVELS, Isolation, Request, WorkerLimits

HAS_ZYGOTE = sys.platform == "linux"


class IsolationError(GraderError):
    """The requested isolation is unavailable on this machine."""


def start_worker(
    *,
    entry: str,
    channel: socket.socket,
    memory: Sequence[int] = (),
    limits: WorkerLimits | None = None,
    isolation: Isolation = "auto",
    hidden: Sequence[str] = (),
    modules: Sequence[str] = ("numpy", "robsim"),
    path: Sequence[str] = (),
    without: Sequence[str] = (),
) -> WorkerProcess:
    """Start a process in a sandbox, and there call trusted code, which runs a submission.

    The entry ``"module:function"`` gets a copy of the channel's socket, and a tuple with copies of
    the descriptors `memory`. The caller closes the channel. The worker cannot read hidden folders
    and files of Python. Modules are imported with the grader's rights, once for all workers, before
    any submission; `path` has further folders of modules. `without` names layers to omit.

    Isolation ``"none"`` gives only a process, ``"process"`` adds limits, ``"auto"`` adds all layers
    that work here. ``"strict"`` does the same, but raises IsolationError if files, processes,
    network or the grader's memory stay open. Raise GraderError if no worker starts.
    """
    check_has_threads("The sandbox of submissions")
    check_choice("isolation", isolation, LEVELS)
    module, _, function = entry.partition(":")
    if not (module and function):
        raise ValueError(f"entry must be 'module:function', got {quoted(entry)}")
    request = Request(
        entry=entry,
        limits=limits or WorkerLimits(),
        isolation=isolation,
        hidden=tuple(map(os.path.abspath, hidden)),
        without=tuple(without),
    )
    modules = tuple(dict.fromkeys((*modules, module)))
    if sys.platform == "linux" and HAS_ZYGOTE:
        from robsim.teach.isolation._forked import forked_worker as worker_of
    else:
        from robsim.teach.isolation._processes.fresh import fresh_worker as worker_of
    worker = worker_of(request, channel, memory, modules, path)
    if isolation == "strict":
        _refuse_open(worker)
    return worker


def _refuse_open(worker: WorkerProcess) -> None:
    layers = worker.layers
    if missing := [what for what, closed in layers.closed.items() if not closed]:
        worker.kill()
        lacking: dict[str, list[str]] = {}
        for layer in layers.layers:
            if not layer.holds:
                lacking.setdefault(layer.text, []).append(layer.name)
        reasons = "; ".join(f"{', '.join(names)}: {why}" for why, names in lacking.items())
        raise IsolationError(
            "isolation='strict' must close files, processes, network and the grader's memory to a "
            f"submission, but here these are open: {', '.join(missing)} ({reasons})"
        )
