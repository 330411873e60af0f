"""Workers as fresh processes in job objects: started, watched, ended."""

from __future__ import annotations

import sys

assert sys.platform == "win32"

import base64
import json
import os
import socket
import subprocess
import threading
from collections.abc import Mapping, Sequence
from contextlib import suppress

from robsim.grading._errors import GraderError
from robsim.grading._isolation._ending import KILLED, NO_MEMORY
from robsim.grading._isolation._layers.layer import JOB, LIMITS, Layer, missing_layers
from robsim.grading._isolation._limits import as_size
from robsim.grading._isolation._printed import Printed
from robsim.grading._isolation._process import WorkerLost, WorkerProcess
from robsim.grading._isolation._processes.environment import command_for, environment_for
from robsim.grading._isolation._processes.windows.job import Job, cpu_seconds, memory_of
from robsim.grading._isolation._processes.windows.scratch import Scratch
from robsim.grading._isolation._processes.written import exceeds
from robsim.grading._isolation._request import Request

_LOOK = 0.25  # s between looks at what a worker takes
_ENDED = 0x2052_4F42  # exit code of what is ended here
_QUOTA = (1816, 0xC0000044)  # exit codes of what the system has ended at a limit
_LAST_WORDS = 5.0  # s that may pass between the end of a worker and that of its output
_AT_ONCE = 1 << 16  # bytes


def fresh_worker(
    request: Request,
    channel: socket.socket,
    memory: Sequence[int],
    modules: Sequence[str],
    path: Sequence[str],
) -> WorkerProcess:
    """Start a worker as a process of its own, which imports what it needs.

    It is in its job before it is told what to do.
    """
    if memory:
        raise ValueError("memory must be empty on Windows: pixels go through the channel")
    ours, theirs = socket.socketpair()
    try:
        keeper = _Keeper(request, theirs)
        keeper.tell(
            {
                "request": request.to_message(),
                "modules": list(modules),
                "path": list(path),
                "scratch": keeper.scratch.path,
                "layers": [[layer.name, layer.holds, layer.text] for layer in _layers(request)],
            },
            [channel, theirs],
        )
    except OSError as error:
        ours.close()
        theirs.close()
        raise GraderError(f"a worker could not be started: {error}") from error
    except BaseException:
        ours.close()
        theirs.close()
        raise
    keeper.watch()
    try:
        return WorkerProcess(request, ours, None, printed=keeper.printed)
    except WorkerLost:
        raise GraderError("a worker was killed while it was started") from None


def _layers(request: Request) -> list[Layer]:
    """Return what holds and what is missing, when a worker is in its job."""
    layers = [Layer(JOB, True, "")]
    if request.isolation != "none":
        limits = request.limits
        text = f"memory {as_size(limits.memory)}, processor time {limits.cpu:g} s, one process"
        layers.append(Layer(LIMITS, True, text))
    return [*layers, *(missing_layers("Windows") if request.shut else ())]


class _Keeper:
    """A process in a job, and threads of the grader's that end it and tell how it ended."""

    def __init__(self, request: Request, life: socket.socket) -> None:
        self._request = request
        self._life = life
        self._code: int | None = None  # that it was ended with here
        self._too_much_written = False
        self.printed = Printed(request.limits.output)
        self.scratch = Scratch()
        try:
            self._job = Job(None if request.isolation == "none" else request.limits)
            try:
                self._process = _started(self.scratch.path)
            except BaseException:
                self._job.close()
                raise
        except BaseException:
            self.scratch.remove()
            raise

    def tell(self, message: Mapping[str, object], sockets: Sequence[socket.socket]) -> None:
        """Put the process into its job, and tell it what to do: before, it does nothing."""
        stdin = self._process.stdin
        assert stdin is not None
        try:
            self._job.take(self._process)
            shared = [base64.b64encode(each.share(self._process.pid)).decode() for each in sockets]
            with suppress(BrokenPipeError), stdin:
                stdin.write(json.dumps({**message, "sockets": shared}).encode())
        except BaseException:
            self._process.kill()
            self._clear_up()
            raise

    def watch(self) -> None:
        """Start the threads."""
        self._reader = threading.Thread(target=self._read, name="robsim keeper", daemon=True)
        self._reader.start()
        for work in (self._keep, self._hear):
            threading.Thread(target=work, name="robsim keeper", daemon=True).start()

    def _read(self) -> None:
        """Read what it prints."""
        stdout = self._process.stdout
        assert stdout is not None
        with suppress(OSError):
            while part := os.read(stdout.fileno(), _AT_ONCE):
                self.printed.add(part)

    def _hear(self) -> None:
        """End the worker when the grader asks for it."""
        with suppress(OSError):
            self._life.recv(1)
        self._end(KILLED)

    def _end(self, code: int) -> None:
        if self._code is None:
            self._code = code
        self._job.end(_ENDED)

    def _keep(self) -> None:
        """Watch it, tell how it ended, and remove what is left of it."""
        asked = most = 0
        while True:
            with suppress(subprocess.TimeoutExpired):
                self._process.wait(_LOOK)
            with suppress(OSError):  # it may just have ended
                asked, peak = memory_of(self._process)
                most = max(most, peak)
            if self._process.returncode is not None:
                break
            self._look(asked)
        cpu = cpu_seconds(self._process)
        self._job.end(_ENDED)  # what it has left
        self._reader.join(_LAST_WORDS)
        ending = {
            "code": self._ended_with(self._process.returncode),
            "cpu": cpu,
            "max_rss": most,
            "too much written": self._too_much_written,
            "left": self._clear_up(),
        }
        with suppress(OSError):
            self._life.sendall(json.dumps(ending).encode() + b"\n")
        with suppress(OSError):
            self._life.shutdown(socket.SHUT_RDWR)
        self._life.close()

    def _look(self, memory: int) -> None:
        """End it where it has taken too much; the job keeps the limit of processor time."""
        if self._request.isolation == "none":
            return
        limits = self._request.limits
        if memory > limits.memory:
            self._end(NO_MEMORY)
        elif exceeds(self.scratch.path, limits.folder_size):
            self._too_much_written = True
            self._end(KILLED)

    def _ended_with(self, code: int) -> int:
        """Return what says how it ended, from its exit code."""
        if code == _ENDED:
            return KILLED if self._code is None else self._code
        return KILLED if code in _QUOTA else code

    def _clear_up(self) -> list[str]:
        """End what is left, and remove it; return what cannot be removed."""
        self._job.close()
        self._process.wait()
        if self._process.stdout is not None:
            self._process.stdout.close()
        self.scratch.remove()
        left = os.path.lexists(self.scratch.path)
        return [f"folder {self.scratch.path}"] if left else []


def _started(home: str) -> subprocess.Popen[bytes]:
    return subprocess.Popen(
        command_for("robsim.grading._isolation._processes.windows.be_worker:main"),
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        env=environment_for(home),
        cwd=home,
        creationflags=subprocess.DETACHED_PROCESS,  # a console would be a process of its own
    )
