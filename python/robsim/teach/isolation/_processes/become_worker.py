"""The change of a fresh process into a worker with a sandbox, inside the worker."""

from __future__ import annotations

import os
import select
import signal
import socket
import sys
import traceback
from collections.abc import Sequence
from contextlib import suppress
from typing import NoReturn

from robsim.teach.isolation._layers.layer import PROCESS, Layer, Layers
from robsim.teach.isolation._processes.working import settle, tell, work
from robsim.teach.isolation.ending import NOT_SHUT_IN
from robsim.teach.isolation.limits import Request

assert sys.platform != "win32"

#: A descriptor of a path and the rights granted below it (`_layers.landlock`).
Grants = Sequence[tuple[int, int]]


def become_worker(
    request: Request,
    descriptors: Sequence[int],
    scratch: str,
    *,
    grants: Grants = (),
    view: int = -1,
    alive: int | None = None,
    made: Sequence[Layer] = (),
) -> NoReturn:
    """Turn this process into a worker, which reads `grants` in the folder `scratch`; never return.

    The descriptors are its channel, output, report and memory. It sees the mounts of `view`. The
    pipe `alive` ends with the parent. The layers `made` exist already.
    """
    code = NOT_SHUT_IN
    try:
        channel, output, life, *memory = descriptors
        _be_alone(output, [channel, life, view, *memory, *(g[0] for g in grants)], scratch, alive)
        with socket.socket(fileno=life) as report:
            shut = _shut_in(request, grants, view, alive)
            settle(os.getcwd())
            layers = Layers((Layer(PROCESS, True, ""), *made, *shut))
            tell(layers, report)
        with socket.socket(fileno=channel) as connection:
            code = work(request, layers, connection, memory)
    except BaseException:
        traceback.print_exc()
    finally:
        os._exit(code)


def _be_alone(output: int, keep: Sequence[int], scratch: str, alive: int | None) -> None:
    """Leave the parent's session, descriptors, folder and signals."""
    signal.set_wakeup_fd(-1)
    for number in (signal.SIGCHLD, signal.SIGTERM, signal.SIGINT):
        signal.signal(number, signal.SIG_DFL)
    if os.getsid(0) != os.getpid():
        os.setsid()
    if alive is not None and select.select([alive], [], [], 0)[0]:
        os._exit(NOT_SHUT_IN)  # the parent has ended and reads no report
    null = os.open(os.devnull, os.O_RDWR)
    os.dup2(null, 0)
    os.dup2(output, 1)
    os.dup2(output, 2)
    _close_all_but({0, 1, 2, *keep})
    os.chdir(scratch)


def _close_all_but(keep: set[int]) -> None:
    try:
        opened = [int(name) for name in os.listdir("/dev/fd")]
    except OSError:
        opened = list(range(256))
    for number in set(opened) - keep:
        with suppress(OSError):  # the descriptor of the list
            os.close(number)


def _shut_in(request: Request, grants: Grants, view: int, alive: int | None) -> list[Layer]:
    if request.isolation == "none":
        return []
    if sys.platform == "linux" and alive is not None:  # there is a zygote
        from robsim.teach.isolation._layers.shut_in import shut_in

        return shut_in(request, grants, view)
    from robsim.teach.isolation._layers.limits import shut_in_elsewhere

    return shut_in_elsewhere(request)
