"""Workers as fresh processes, without a zygote: slower to start, with fewer layers.

On Windows only the grader's clock limits them.
"""

from __future__ import annotations

import base64
import importlib
import json
import os
import select
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import traceback
from collections.abc import Mapping, Sequence
from contextlib import closing, suppress
from typing import Any, NoReturn

from robsim.teach.errors import GraderError
from robsim.teach.isolation._layers.layer import PROCESS, Layer, Layers, missing_layers
from robsim.teach.isolation._process import WorkerLost, WorkerProcess
from robsim.teach.isolation._processes.environment import command_for, environment_for
from robsim.teach.isolation._processes.working import settle, tell, work
from robsim.teach.isolation.ending import KILLED, NOT_SHUT_IN, Printed
from robsim.teach.isolation.limits import Request

if sys.platform == "win32":
    import shutil

    def remove(folder: str) -> None:
        shutil.rmtree(folder, ignore_errors=True)
else:
    from robsim.teach.isolation._processes.become_worker import become_worker
    from robsim.teach.isolation._processes.scratch import remove

    def _wait_for_end(process: int) -> None:
        """Wait until a child has ended; its number stays reserved until it is reaped."""
        if sys.platform == "darwin":  # only newer versions of Python have waitid there
            event = select.kevent(
                process,
                select.KQ_FILTER_PROC,
                select.KQ_EV_ADD | select.KQ_EV_ONESHOT,
                select.KQ_NOTE_EXIT,
            )
            with closing(select.kqueue()) as queue, suppress(ProcessLookupError):  # it has ended
                queue.control([event], 1)
        else:
            os.waitid(os.P_PID, process, os.WEXITED | os.WNOWAIT)


_LAST_WORDS = 5.0  # s, maximum between the end of a worker and the end of its output
_AT_ONCE = 1 << 16  # bytes


def fresh_worker(
    request: Request,
    channel: socket.socket,
    memory: Sequence[int],
    modules: Sequence[str],
    path: Sequence[str],
) -> WorkerProcess:
    ours, theirs = socket.socketpair()
    try:
        keeper = _Keeper(request, theirs, [channel.fileno(), theirs.fileno(), *memory])
        message = {
            "request": request.to_message(),
            "modules": list(modules),
            "path": list(path),
            "scratch": keeper.folder,
        }
        keeper.watch(message, channel)
    except OSError as error:
        ours.close()
        theirs.close()
        raise GraderError(f"a worker failed to start: {error}") from error
    try:
        return WorkerProcess(request, ours, None, printed=keeper.printed)
    except WorkerLost:
        raise GraderError("a worker was killed during its start") from None


class _Keeper:
    """A worker, with threads of the grader that replace its zygote."""

    def __init__(self, request: Request, life: socket.socket, given: Sequence[int]) -> None:
        self.printed = Printed(request.limits.output)
        self.folder = tempfile.mkdtemp(prefix="robsim-worker-")
        self._life = life
        self._given = given
        self._killed = self._over = False
        self._lock = threading.Lock()
        try:
            self._process = _started(self.folder, given)
        except BaseException:
            remove(self.folder)
            raise

    def watch(self, message: Mapping[str, Any], channel: socket.socket) -> None:
        self._reader = threading.Thread(target=self._read, name="robsim keeper", daemon=True)
        self._reader.start()
        for act in (self._wait, self._hear):
            threading.Thread(target=act, name="robsim keeper", daemon=True).start()
        given: Sequence[int | str] = self._given
        if sys.platform == "win32":  # only a running process can get a handle
            shared = (one.share(self._process.pid) for one in (channel, self._life))
            given = [base64.b64encode(one).decode() for one in shared]
        assert self._process.stdin is not None
        with suppress(BrokenPipeError), self._process.stdin as stdin:
            stdin.write(json.dumps({**message, "given": given}).encode())

    def _read(self) -> None:
        assert self._process.stdout is not None
        with suppress(OSError), self._process.stdout as stdout:
            while part := os.read(stdout.fileno(), _AT_ONCE):
                self.printed.add(part)

    def _hear(self) -> None:
        with suppress(OSError):
            self._life.recv(1)
        with self._lock:
            if not self._over:
                self._killed = True
                self._kill()

    def _kill(self) -> None:
        with suppress(ProcessLookupError, PermissionError):
            if sys.platform == "win32":
                self._process.kill()
            else:
                os.killpg(self._process.pid, signal.SIGKILL)

    def _wait(self) -> None:
        """Report its ending, and remove its remains."""
        code, cpu, most = self._ended()
        self._reader.join(_LAST_WORDS)
        remove(self.folder)
        ending = {
            "code": KILLED if sys.platform == "win32" and self._killed else code,
            "cpu": cpu,
            "max_rss": most,
            "left": [f"folder {self.folder}"] if os.path.lexists(self.folder) else [],
        }
        with suppress(OSError):
            self._life.sendall(json.dumps(ending).encode() + b"\n")
        with suppress(OSError):
            self._life.shutdown(socket.SHUT_RDWR)
        self._life.close()

    def _ended(self) -> tuple[int, float, int]:
        """Wait for its end; return exit code, processor time (s), and peak memory (bytes)."""
        if sys.platform == "win32":
            code = self._process.wait()
            with self._lock:
                self._over = True
            return code, 0.0, 0
        else:  # noqa: RET505  # mypy follows nothing but this
            _wait_for_end(self._process.pid)
            with self._lock:
                self._kill()  # the other processes of its session
                _, status, usage = os.wait4(self._process.pid, 0)
                self._over = True  # from now on another process may have the number
            self._process.returncode = os.waitstatus_to_exitcode(status)
            kibi = 1 if sys.platform == "darwin" else 1024
            cpu = usage.ru_utime + usage.ru_stime
            return self._process.returncode, cpu, kibi * usage.ru_maxrss


def _started(folder: str, descriptors: Sequence[int]) -> subprocess.Popen[bytes]:
    options: dict[str, Any] = {"pass_fds": descriptors, "start_new_session": True}
    if sys.platform == "win32":
        options = {"creationflags": subprocess.DETACHED_PROCESS}  # else it gets a console
    return subprocess.Popen(
        command_for(f"{__name__}:main"),
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        env=environment_for(folder),
        cwd=folder,
        **options,
    )


def main() -> NoReturn:
    message = json.loads(sys.stdin.buffer.read())
    sys.path.extend(message["path"])
    for module in message["modules"]:
        importlib.import_module(module)
    request = Request.from_message(message["request"])
    if sys.platform == "win32":
        _work_on_windows(request, message["given"], message["scratch"])
    else:
        channel, life, *memory = message["given"]
        become_worker(request, [channel, 1, life, *memory], scratch=message["scratch"])


if sys.platform == "win32":

    def _work_on_windows(request: Request, given: Sequence[str], scratch: str) -> NoReturn:
        code = NOT_SHUT_IN
        try:
            channel, life = (socket.fromshare(base64.b64decode(one)) for one in given)
            settle(scratch)
            missing = missing_layers(sys.platform) if request.shut else []
            layers = Layers((Layer(PROCESS, True, ""), *missing))
            with life:
                tell(layers, life)
            with channel:
                code = work(request, layers, channel)
        except BaseException:
            traceback.print_exc()
        finally:
            os._exit(code)
