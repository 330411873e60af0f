"""Workers that a zygote forks, on Linux: each in some milliseconds, with a separate user."""

from __future__ import annotations

import sys

assert sys.platform == "linux"

import os
import socket
from collections.abc import Sequence
from dataclasses import replace
from functools import partial

from robsim.teach.errors import GraderError
from robsim.teach.isolation._layers import calls, users
from robsim.teach.isolation._layers.layer import NETWORK, USER
from robsim.teach.isolation._process import WorkerLost, WorkerProcess
from robsim.teach.isolation._processes.zygotes import ZygoteSetup, lose_user, retire, zygote_for
from robsim.teach.isolation.ending import GRADER_LOST_IT, Ending
from robsim.teach.isolation.limits import Request

_TRIES = 5  # other processes may kill all but one


def forked_worker(
    request: Request,
    channel: socket.socket,
    memory: Sequence[int],
    modules: Sequence[str],
    path: Sequence[str],
) -> WorkerProcess:
    setup = ZygoteSetup(
        tuple(modules), tuple(path), shut=request.shut, network=NETWORK in request.without
    )
    descriptors = [channel.fileno(), *memory]
    if request.isolation != "none":
        calls.prctl(calls.PR_SET_DUMPABLE, 0)  # hides this process from the user's other ones
    for _ in range(_TRIES):
        try:
            return _asked(setup, request, descriptors)
        except (WorkerLost, ConnectionError):  # killed: retry with the next one
            retire(setup)
    raise GraderError(f"a worker was killed {_TRIES} times during its start")


def _asked(setup: ZygoteSetup, request: Request, descriptors: list[int]) -> WorkerProcess:
    """Request a worker from a zygote, with a separate user if available."""
    user = users.take_user() if request.shut and USER not in request.without else None
    request = replace(request, user=user)
    ours, theirs = socket.socketpair()
    ours.setsockopt(socket.SOL_SOCKET, socket.SO_PASSCRED, 1)  # sends the worker's number
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
    if user is None:
        return
    if ending is GRADER_LOST_IT:
        lose_user(user)  # processes of the worker may be left
    else:
        users.give_back(user)
