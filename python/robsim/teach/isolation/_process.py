"""A worker from the grader's side: its output and its end."""

from __future__ import annotations

import json
import math
import os
import selectors
import socket
import struct
import sys
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from typing import Any, Self

from robsim.teach.errors import GraderError
from robsim.teach.isolation._layers.layer import Layers
from robsim.teach.isolation.ending import GRADER_LOST_IT, STILL_RUNS, Ending, Printed, ending_of
from robsim.teach.isolation.limits import Request

_START = 60.0  # s, maximum for a fresh worker's imports and sandbox.
_END = 60.0  # s, maximum for its end and all its processes
_AT_ONCE = 1 << 16  # bytes


class WorkerLost(Exception):
    """A worker, or the process that starts workers, was killed before the sandbox was complete."""


class WorkerProcess:
    """A worker that runs or has run. All threads may call its methods.

    A context manager, which ends the worker. `start_worker` makes it. `layers` make its sandbox.
    """

    def __init__(
        self,
        request: Request,
        life: socket.socket,
        pipe: int | None,
        *,
        printed: Printed | None = None,
        on_end: Callable[[Ending], None] = lambda ending: None,
        on_hang: Callable[[], None] = lambda: None,
    ) -> None:
        self._request = request
        self._life = life
        self._lines = life.makefile("rb")
        self._pipe = pipe
        self._printed = printed or Printed(request.limits.output)
        self._killed = False
        self._number = 0  # of its process; 0 = unknown
        self._ending: Ending | None = None
        self._over = threading.Event()
        self._on_end = on_end
        self._on_hang = on_hang
        self._sending = threading.Lock()
        try:
            self.layers = self._first_report()
        except BaseException:
            self._close()
            raise
        self._watcher = threading.Thread(target=self._watch, name="robsim worker", daemon=True)
        self._watcher.start()

    def _first_report(self) -> Layers:
        self._life.settimeout(_START)
        try:
            if sys.platform == "linux":
                sender = self._life.recvmsg(1, 64, socket.MSG_PEEK)[1]  # process, user, group
                self._number = struct.unpack("3i", sender[0][2])[0] if sender else 0
            report = self._lines.readline()
        except TimeoutError:
            self._on_hang()
            message = f"a worker did not complete its sandbox within {_START:g} s"
            raise GraderError(message) from None
        except OSError:
            report = b""
        self._life.settimeout(None)
        if not report:
            raise WorkerLost
        content = json.loads(report)
        if content.get("code", 0) < 0:
            raise WorkerLost
        if "layers" not in content:
            raise GraderError(f"a worker failed to start: {self._failure(content)}")
        return Layers.from_message(content["layers"])

    def _failure(self, content: dict[str, Any]) -> str:
        if "failed" in content:
            return str(content["failed"])
        self._read_what_is_there()
        return self.output.strip().rpartition("\n")[2] or "it exited without a message"

    def _watch(self) -> None:
        with selectors.DefaultSelector() as selector:
            selector.register(self._life, selectors.EVENT_READ)
            pipe = self._pipe
            if pipe is not None:
                selector.register(pipe, selectors.EVENT_READ)
            ready: list[object] = []
            while self._life not in ready:
                ready = [key.fileobj for key, _ in selector.select()]
                if pipe is not None and pipe in ready and not self._read(pipe):
                    selector.unregister(pipe)
        ending = self._last_report()
        self._read_what_is_there()
        self._close()
        self._ending = ending
        try:
            self._on_end(ending)
        finally:
            self._over.set()

    def _close(self) -> None:
        if self._pipe is not None:
            os.close(self._pipe)
        with self._sending:
            self._lines.close()
            self._life.close()

    def _read(self, pipe: int) -> bool:
        """Read some of the output; return False at its end."""
        part = os.read(pipe, _AT_ONCE)
        self._printed.add(part)
        return bool(part)

    def _read_what_is_there(self) -> None:
        """Read the content of the pipe, which a remaining process may keep open."""
        if sys.platform == "win32" or self._pipe is None:
            return
        os.set_blocking(self._pipe, False)
        with suppress(BlockingIOError):
            for _ in range(64):
                if not self._read(self._pipe):
                    return

    def _last_report(self) -> Ending:
        try:
            report = self._lines.readline()
        except OSError:
            report = b""
        if not report:
            return GRADER_LOST_IT
        told = json.loads(report)
        return ending_of(
            *(told["code"], told["cpu"], told["max_rss"]),
            limits=self._request.limits,
            killed=self._killed,
            too_much_written=told.get("too much written", False),
            left=told["left"],
        )

    @property
    def cpu_seconds(self) -> float:
        """Processor time of all its threads until now (s); NaN = unknown."""
        if sys.platform == "linux" and self._number:
            with suppress(OSError):  # it has ended
                return time.clock_gettime(~self._number << 3 | 2)  # as clock_getcpuclockid()
        return math.nan

    @property
    def output(self) -> str:
        """Its printed output, unchecked, with a line at the cut if there is one."""
        return self._printed.text

    def kill(self) -> None:
        """Kill the worker and all its processes; return when none is left."""
        self._killed = True
        with self._sending, suppress(OSError):  # it has ended
            self._life.shutdown(socket.SHUT_WR)
        if not self._over.wait(_END):  # even its zygote hangs
            self._on_hang()
            self._over.wait()

    def wait(self, timeout: float | None = None) -> Ending:
        """Return its ending, or, after the timeout (s), `STILL_RUNS`."""
        self._over.wait(timeout)
        return self._ending or STILL_RUNS

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.kill()
