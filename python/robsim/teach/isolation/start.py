"""A worker is started: by a zygote on Linux, as a fresh process elsewhere."""

from __future__ import annotations

import os
import socket
import sys
from collections.abc import Sequence

from robsim.base.checks import check_choice
from robsim.base.text import quoted
from robsim.teach.errors import GraderError
from robsim.teach.isolation._process import WorkerProcess
from robsim.teach.isolation.limits import LEVELS, Isolation, Request, WorkerLimits

HAS_ZYGOTE = sys.platform == "linux"


class IsolationError(GraderError):
    """The isolation that was asked for cannot be had on this machine."""


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
    """Start a process that is shut in, and there calls trusted code, which runs a submission.

    Parameters
    ----------
    entry : str
        ``"module:function"``, called in the worker as ``function(channel, memory)`` with a socket
        and a tuple of descriptors. What it returns is dropped.
    channel : socket.socket
        The worker's end; it gets a copy, and the caller closes this one.
    memory : sequence of int
        Descriptors that it gets copies of.
    limits : WorkerLimits, optional
        What it may take.
    isolation : {"auto", "none", "process", "strict"}
        ``"auto"``: all that works here; ``"none"``: a process, and nothing else; ``"process"``:
        with limits; ``"strict"``: as ``"auto"``, and an error where files, processes, network or
        the grader's memory stay open to it.
    hidden : sequence of str
        Folders and files of Python that it must not read.
    modules : sequence of str
        What is imported before it is shut in. Once for all workers, in a process that has never
        seen a submission: what these modules do when imported, they do with the grader's rights.
    path : sequence of str
        Further folders in which modules are looked for.
    without : sequence of str
        Names of layers to leave out, as the report has them: to try what the others hold.

    Raises
    ------
    IsolationError
        If ``"strict"`` cannot be had.
    GraderError
        If no worker can be started.
    """
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
    """End a worker that is not shut in, and say why."""
    layers = worker.layers
    if missing := [what for what, closed in layers.closed.items() if not closed]:
        worker.kill()
        lacking: dict[str, list[str]] = {}
        for layer in layers.layers:
            if not layer.holds:
                lacking.setdefault(layer.text, []).append(layer.name)
        reasons = "; ".join(f"{', '.join(names)}: {why}" for why, names in lacking.items())
        raise IsolationError(
            "isolation='strict' needs files, processes, network and the grader's memory closed "
            f"to a submission; open here: {', '.join(missing)} ({reasons})"
        )
