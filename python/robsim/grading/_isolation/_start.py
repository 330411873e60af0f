"""A worker is started: by a zygote on Linux, as a fresh process elsewhere."""

from __future__ import annotations

import os
import socket
import sys
from collections.abc import Sequence
from functools import partial

from robsim._base.checks import check_choice
from robsim._base.text import quoted
from robsim.grading._errors import GraderError
from robsim.grading._isolation._ending import GRADER_LOST_IT, Ending
from robsim.grading._isolation._layers.layer import NETWORK, USER
from robsim.grading._isolation._limits import Limits
from robsim.grading._isolation._process import WorkerLost, WorkerProcess
from robsim.grading._isolation._processes.zygotes import ZygoteSetup, lose_user, retire, zygote_for
from robsim.grading._isolation._request import LEVELS, Isolation, Request

HAS_ZYGOTE = sys.platform == "linux"
_TRIES = 5  # of which others may kill all but one


class IsolationError(GraderError):
    """The isolation that was asked for cannot be had on this machine."""


def start_worker(
    *,
    entry: str,
    channel: socket.socket,
    memory: Sequence[int] = (),
    limits: Limits | None = None,
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
    limits : Limits, optional
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
        limits=limits or Limits(),
        isolation=isolation,
        hidden=tuple(map(os.path.abspath, hidden)),
        without=tuple(without),
    )
    descriptors = [channel.fileno(), *memory]
    modules = tuple(dict.fromkeys((*modules, module)))
    if HAS_ZYGOTE:
        setup = ZygoteSetup(
            modules,
            tuple(path),
            shut=request.shut,
            network=NETWORK in request.without,
        )
        worker = _from_zygote(setup, request, descriptors)
    else:
        from robsim.grading._isolation._processes.fresh import fresh_worker

        worker = fresh_worker(request, descriptors, modules, path)
    if isolation == "strict":
        _refuse_open(worker)
    return worker


def _from_zygote(setup: ZygoteSetup, request: Request, descriptors: list[int]) -> WorkerProcess:
    if request.isolation != "none":
        _close_own_memory()
    for _ in range(_TRIES):
        try:
            return _asked(setup, request, descriptors)
        except (WorkerLost, ConnectionError):  # it was killed: with the next one
            retire(setup)
    raise GraderError(f"a worker was killed {_TRIES} times while it was started")


def _asked(setup: ZygoteSetup, request: Request, descriptors: list[int]) -> WorkerProcess:
    """Ask a zygote for a worker, with a user of its own where that can be had."""
    from dataclasses import replace

    from robsim.grading._isolation._layers import users

    user = users.take_user() if request.shut and USER not in request.without else None
    request = replace(request, user=user)
    ours, theirs = socket.socketpair()
    reading, writing = os.pipe()
    try:
        with theirs:
            zygote = zygote_for(setup)
            zygote.ask(request, [descriptors[0], writing, theirs.fileno(), *descriptors[1:]])
    except BaseException:
        ours.close()
        os.close(reading)
        _give_back(user, GRADER_LOST_IT)
        raise
    finally:
        os.close(writing)
    try:
        return WorkerProcess(
            request, ours, reading, on_end=partial(_give_back, user), on_hang=zygote.kill
        )
    except BaseException:
        _give_back(user, GRADER_LOST_IT)
        raise


def _give_back(user: int | None, ending: Ending) -> None:
    from robsim.grading._isolation._layers import users

    if user is None:
        return
    if ending is GRADER_LOST_IT:
        lose_user(user)  # it may have left something
    else:
        users.give_back(user)


def _close_own_memory() -> None:
    """Let no other process of the same user look into this one."""
    from robsim.grading._isolation._layers import calls

    calls.prctl(calls.PR_SET_DUMPABLE, 0)


def _refuse_open(worker: WorkerProcess) -> None:
    """End a worker that is not shut in, and say why."""
    layers = worker.layers
    if missing := [what for what, closed in layers.closed.items() if not closed]:
        worker.kill()
        reasons = "; ".join(f"{x.name}: {x.text}" for x in layers.layers if not x.holds)
        raise IsolationError(
            "isolation='strict' needs files, processes, network and the grader's memory closed "
            f"to a submission; open here: {', '.join(missing)} ({reasons})"
        )
