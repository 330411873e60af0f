"""The zygote: a trusted process that has imported the workers' modules, and forks workers.

The zygote has one thread, reads requests from the grader, and never runs a student's code. If it
ends, its workers end: the kernel sends each SIGKILL when its parent dies.
"""

from __future__ import annotations

import sys

assert sys.platform == "linux"

import gc
import importlib
import json
import os
import resource
import selectors
import signal
import socket
import time
import traceback
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

from robsim.teach.isolation._layers import calls, landlock, users
from robsim.teach.isolation._layers.layer import PIDS, Layer
from robsim.teach.isolation._layers.mounts import open_view
from robsim.teach.isolation._layers.namespaces import be_first, leave_network, own_pids
from robsim.teach.isolation._layers.shut_in import readable_trees, way_to
from robsim.teach.isolation._processes import scratch
from robsim.teach.isolation._processes.become_worker import become_worker
from robsim.teach.isolation._processes.descendants import end_strays
from robsim.teach.isolation._processes.written import exceeds
from robsim.teach.isolation.limits import Request

#: Longest request (bytes).
LONGEST = 1 << 16
_MOST_DESCRIPTORS = 16
_LOOK = 0.25  # s between checks of the workers' files


@dataclass
class _Child:
    process: int
    life: socket.socket
    user: int | None
    folder: str
    most_written: int  # bytes
    own_pids: bool
    too_much_written: bool = False
    ending: dict[str, Any] = field(default_factory=dict)


class Zygote:
    """The loop that forks workers, ends them, and reports their endings."""

    def __init__(self, control: socket.socket, *, base: str, made: list[Layer], view: int) -> None:
        self._control = control
        self._base = base
        self._made = made
        self._view = view
        self._children: dict[int, _Child] = {}
        self._cleaners: dict[int, _Child] = {}
        self._grants: dict[tuple[str, ...], list[landlock.Grant]] = {}
        self._selector = selectors.DefaultSelector()
        self._alive = os.pipe()
        self._signals, self._signalled = socket.socketpair()
        self._open = True
        self._next_look = 0.0  # s

    def serve(self) -> None:
        """Serve until the grader ends; then end all workers."""
        self._signals.setblocking(False)
        self._signalled.setblocking(False)
        signal.set_wakeup_fd(self._signalled.fileno(), warn_on_full_buffer=False)
        signal.signal(signal.SIGCHLD, lambda number, frame: None)
        self._selector.register(self._control, selectors.EVENT_READ, self._hear)
        self._selector.register(self._signals, selectors.EVENT_READ, self._reap)
        while self._open:
            for key, _ in self._selector.select(_LOOK if self._children else None):
                key.data()
            self._look()
        for child in list(self._children.values()):
            self._kill(child)
            os.waitpid(child.process, 0)
            self._end_what_is_left(child)
        for cleaner in self._cleaners:
            os.waitpid(cleaner, 0)

    def _look(self) -> None:
        """End workers that have written too much, at intervals."""
        if time.monotonic() < self._next_look:
            return
        self._next_look = time.monotonic() + _LOOK
        for child in self._children.values():
            if exceeds(child.folder, child.most_written):
                child.too_much_written = True
                self._kill(child)

    def _hear(self) -> None:
        """Take a request of the grader, or notice its end."""
        try:
            message, descriptors, _, _ = socket.recv_fds(self._control, LONGEST, _MOST_DESCRIPTORS)
        except ConnectionError:
            message, descriptors = b"", []
        if not message:
            self._open = False
            return
        content = json.loads(message)
        if "end user" in content:
            users.end_all_of(content["end user"])
            self._control.send(b".")
        else:
            self._start(Request.from_message(content), descriptors)

    def _start(self, request: Request, descriptors: list[int]) -> None:
        """Fork a worker."""
        _, _, number, *_ = descriptors
        life = socket.socket(fileno=number)
        user = request.user if way_to(request.user, request)[0] else None
        try:
            folder = scratch.make_scratch(self._base, user)
            process, pids = self._fork(request, descriptors, folder)
        except OSError as error:  # no memory, too many processes
            with suppress(OSError):
                life.sendall(json.dumps({"failed": str(error)}).encode() + b"\n")
            life.close()
            return
        finally:
            for descriptor in set(descriptors) - {number}:
                os.close(descriptor)
        child = _Child(process, life, user, folder, request.limits.folder_size, pids)
        self._children[process] = child
        self._selector.register(life, selectors.EVENT_READ, partial(self._hear_of, child))

    def _fork(self, request: Request, descriptors: list[int], folder: str) -> tuple[int, bool]:
        """Return the worker's process number, and whether it has a namespace of processes."""
        if not request.shut:
            return self._forked(request, descriptors, folder, [], []), False
        grants = self._grants_for(request.hidden)
        with own_pids(leave=PIDS not in request.without) as pids:
            made = [*self._made, pids]
            return self._forked(request, descriptors, folder, grants, made), pids.holds

    def _forked(
        self,
        request: Request,
        descriptors: list[int],
        folder: str,
        grants: list[landlock.Grant],
        made: list[Layer],
    ) -> int:
        process = os.fork()
        if process == 0:
            os.close(self._alive[1])
            view, alive = self._view, self._alive[0]
            become_worker(
                request, descriptors, folder, grants=grants, view=view, alive=alive, made=made
            )
        return process

    def _grants_for(self, hidden: tuple[str, ...]) -> list[landlock.Grant]:
        if hidden not in self._grants:
            trees = readable_trees(list(sys.modules))
            self._grants[hidden] = landlock.open_grants(trees, [Path(path) for path in hidden])
        return self._grants[hidden]

    def _hear_of(self, child: _Child) -> None:
        """End a worker if the grader requests the end or has lost interest."""
        if child.process in self._children:  # the worker may have ended since the selector's call
            self._selector.unregister(child.life)
            self._kill(child)

    def _kill(self, child: _Child) -> None:
        with suppress(ProcessLookupError):  # not reaped yet, so that the number is still its own
            os.kill(child.process, signal.SIGKILL)

    def _reap(self) -> None:
        """Reap and report the workers that have ended."""
        with suppress(BlockingIOError):
            while self._signals.recv(4096):
                pass
        with suppress(ChildProcessError):
            while True:
                process, status, usage = os.wait4(-1, os.WNOHANG)
                if process == 0:
                    return
                if child := self._children.pop(process, None):
                    child.ending = {
                        "code": os.waitstatus_to_exitcode(status),
                        "cpu": usage.ru_utime + usage.ru_stime,
                        "max_rss": usage.ru_maxrss * 1024,
                        "left": self._end_what_is_left(child),
                        "too much written": child.too_much_written,
                    }
                    self._cleaners[_cleaner_of(child.folder)] = child
                elif child := self._cleaners.pop(process, None):
                    self._tell(child)

    def _end_what_is_left(self, child: _Child) -> list[str]:
        """End the processes that a worker may have left; return those that remain."""
        if child.own_pids:  # the kernel has ended all processes of the namespace
            return []
        if child.user is not None:
            users.end_all_of(child.user)
        strays = end_strays({*self._children, *self._cleaners})
        return [f"process {process}" for process in strays]

    def _tell(self, child: _Child) -> None:
        """Report a worker's end and its remains to the grader."""
        left = [f"folder {child.folder}"] if os.path.lexists(child.folder) else []
        ending = {**child.ending, "left": [*child.ending["left"], *left]}
        with suppress(OSError):  # the grader is not interested
            child.life.sendall(json.dumps(ending).encode() + b"\n")
        with suppress(KeyError, ValueError):
            self._selector.unregister(child.life)
        child.life.close()


def _cleaner_of(folder: str) -> int:
    """Start to remove a folder in a separate process, so that a full folder delays no others."""
    process = os.fork()
    if process == 0:
        try:
            calls.prctl(calls.PR_SET_PDEATHSIG, signal.SIGKILL)
            scratch.remove(folder)
        finally:
            os._exit(0)
    return process


def main(descriptor: int) -> None:
    """Be the zygote of the grader at the other end of a socket."""
    # Each neighbour of a hidden file needs a descriptor.
    _, most = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (most, most))
    control = socket.socket(fileno=descriptor)
    setup = json.loads(control.recv(LONGEST))
    base = setup["base"]
    lock = scratch.held(base)
    try:
        try:
            zygote = _prepared(control, setup)
        except BaseException as error:
            traceback.print_exc()
            control.send(json.dumps({"failed": f"{type(error).__name__}: {error}"[:2000]}).encode())
            return
        control.send(json.dumps({"ready": os.getpid()}).encode())
        zygote.serve()
    finally:
        scratch.remove(base)
        os.close(lock)


def _prepared(control: socket.socket, setup: dict[str, object]) -> Zygote:
    shut, base = bool(setup["shut"]), str(setup["base"])
    made = [leave_network(leave=not setup["network"])] if shut else []
    if made and made[0].holds and os.geteuid() != 0:
        be_first(before=control.close)
    calls.prctl(calls.PR_SET_CHILD_SUBREAPER, 1)
    modules, path = setup["modules"], setup["path"]
    assert isinstance(modules, list)
    assert isinstance(path, list)
    sys.path.extend(path)
    for module in modules:
        importlib.import_module(module)
    if (threads := len(os.listdir("/proc/self/task"))) > 1:
        raise RuntimeError(f"{', '.join(modules)} start {threads - 1} threads when imported")
    view = open_view(readable_trees(list(sys.modules)), base) if shut else -1
    if shut:
        calls.prctl(calls.PR_SET_DUMPABLE, 0)
    gc.collect()
    gc.freeze()
    return Zygote(control, base=base, made=made, view=view)
