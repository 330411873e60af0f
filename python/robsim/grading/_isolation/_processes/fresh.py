"""Workers as fresh processes, where there is no zygote: slower to start, with fewer layers."""

from __future__ import annotations

import sys

assert sys.platform != "win32"

import importlib
import json
import os
import signal
import socket
import subprocess
import threading
from collections.abc import Mapping, Sequence
from contextlib import suppress
from typing import NoReturn

from robsim.grading._errors import GraderError
from robsim.grading._isolation._process import WorkerLost, WorkerProcess
from robsim.grading._isolation._processes import scratch
from robsim.grading._isolation._processes.environment import command_for, environment_for
from robsim.grading._isolation._processes.zombies import wait_for_end
from robsim.grading._isolation._request import Request


def fresh_worker(
    request: Request,
    channel: socket.socket,
    memory: Sequence[int],
    modules: Sequence[str],
    path: Sequence[str],
) -> WorkerProcess:
    """Start a worker as a process of its own, which imports what it needs."""
    base = scratch.Base()
    ours, theirs = socket.socketpair()
    reading, writing = os.pipe()
    try:
        folder = scratch.make_scratch(base.path, None)
        given = [channel.fileno(), writing, theirs.fileno(), *memory]
        message = {
            "request": request.to_message(),
            "modules": list(modules),
            "path": list(path),
            "descriptors": given,
            "scratch": folder,
        }
        process = _started(message, given, base.path)
    except BaseException:
        ours.close()
        theirs.close()
        os.close(reading)
        base.remove()
        raise
    finally:
        os.close(writing)
    _Keeper(process, theirs, base)
    try:
        return WorkerProcess(request, ours, reading)
    except WorkerLost:
        raise GraderError("a worker was killed while it was started") from None


def _started(
    message: Mapping[str, object], descriptors: list[int], base: str
) -> subprocess.Popen[bytes]:
    process = subprocess.Popen(
        command_for(f"{__name__}:main"),
        stdin=subprocess.PIPE,
        stdout=descriptors[1],
        stderr=descriptors[1],
        pass_fds=descriptors,
        env=environment_for(base),
        cwd="/",
        start_new_session=True,
    )
    assert process.stdin is not None
    with process.stdin, suppress(BrokenPipeError):
        process.stdin.write(json.dumps(message).encode())
    return process


class _Keeper:
    """Two threads of the grader's that are to one worker what a zygote is to all."""

    def __init__(
        self, process: subprocess.Popen[bytes], life: socket.socket, base: scratch.Base
    ) -> None:
        self._process = process
        self._life = life
        self._base = base
        self._over = False
        self._lock = threading.Lock()
        for work in (self._wait, self._hear):
            threading.Thread(target=work, name="robsim keeper", daemon=True).start()

    def _hear(self) -> None:
        """End the worker when the grader asks for it."""
        with suppress(OSError):
            self._life.recv(1)
        self._kill()

    def _kill(self) -> None:
        with self._lock:
            if not self._over:  # else the number may be another's
                with suppress(ProcessLookupError, PermissionError):
                    os.killpg(self._process.pid, signal.SIGKILL)

    def _wait(self) -> None:
        """Tell how it ended, and remove what is left of it."""
        wait_for_end(self._process.pid)
        self._kill()  # what it has left in its session
        with self._lock:
            _, status, usage = os.wait4(self._process.pid, 0)
            self._over = True
        self._process.returncode = os.waitstatus_to_exitcode(status)
        self._base.remove()
        ending = {
            "code": self._process.returncode,
            "cpu": usage.ru_utime + usage.ru_stime,
            "max_rss": usage.ru_maxrss * (1 if sys.platform == "darwin" else 1024),
            "left": [f"folder {self._base.path}"] if os.path.lexists(self._base.path) else [],
        }
        with suppress(OSError):
            self._life.sendall(json.dumps(ending).encode() + b"\n")
        with suppress(OSError):
            self._life.shutdown(socket.SHUT_RDWR)
        self._life.close()


def main() -> NoReturn:
    """Become the worker that standard input tells of."""
    from robsim.grading._isolation._processes.become_worker import become_worker

    message = json.loads(sys.stdin.buffer.read())
    sys.path.extend(message["path"])
    for module in message["modules"]:
        importlib.import_module(module)
    request = Request.from_message(message["request"])
    become_worker(request, message["descriptors"], scratch=message["scratch"])
