"""Workers as plain processes."""

from __future__ import annotations

import importlib
import os
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True, kw_only=True)
class Limits:
    """What a worker may take: a call, the first call, a run (s)."""

    call: float = 1.0
    first_call: float = 10.0
    run: float = 60.0


@dataclass(frozen=True)
class Ending:
    """How a worker ended."""

    text: str
    cpu_seconds: float = 0.0
    max_rss: int = 0


class WorkerProcess:
    """A process."""

    def __init__(self, process: subprocess.Popen[bytes]) -> None:
        self._process = process
        self._output = b""
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self) -> None:
        assert self._process.stdout is not None
        while part := self._process.stdout.read(1):
            self._output += part[: (1 << 16) - len(self._output)]

    @property
    def output(self) -> str:
        return self._output.decode("utf-8", "replace")

    def kill(self) -> None:
        self._process.kill()
        self._process.wait()
        self._reader.join()
        assert self._process.stdout is not None
        self._process.stdout.close()

    def wait(self, timeout: float) -> Ending:
        try:
            code = self._process.wait(timeout)
        except subprocess.TimeoutExpired:
            return Ending("it has closed its connection")
        if code < 0:
            return Ending(f"it was ended by signal {signal.Signals(-code).name}")
        return Ending(f"it ended by itself (exit code {code})")


def start_worker(
    *, entry: str, channel: socket.socket, memory: Sequence[int], limits: Limits, isolation: str
) -> WorkerProcess:
    """Start one."""
    path = str(Path(__file__).parents[2])
    numbers = [channel.fileno(), *memory]
    code = f"import sys; sys.path.insert(0, {path!r}); from robsim.grading._start import _child; "
    process = subprocess.Popen(
        [sys.executable, "-I", "-c", f"{code}_child({entry!r}, {numbers!r})"],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        pass_fds=numbers,
        env={
            name: value
            for name, value in os.environ.items()
            if name.startswith(("OPENBLAS_", "PATH")) or name == "ROBSIM_CPU"
        },
    )
    return WorkerProcess(process)


def _child(entry: str, numbers: list[int]) -> None:
    module, _, function = entry.partition(":")
    work = getattr(importlib.import_module(module), function)
    work(socket.socket(fileno=numbers[0]), numbers[1:])
