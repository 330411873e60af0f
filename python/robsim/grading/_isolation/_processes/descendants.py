"""Processes that an ended worker has left: found, and ended."""

from __future__ import annotations

import os
import signal
import time
from collections import defaultdict
from contextlib import suppress

_PATIENCE = 5.0  # s


def end_strays(innocent: set[int]) -> list[int]:
    """End all descendants of this process but for some children and theirs; return who is left.

    This process adopts what its descendants leave (PR_SET_CHILD_SUBREAPER). They are stopped
    before they are killed, so that none can start others meanwhile.
    """
    deadline = time.monotonic() + _PATIENCE
    while strays := _strays(innocent):
        for number in (signal.SIGSTOP, signal.SIGKILL):
            for process in strays:
                with suppress(ProcessLookupError, PermissionError):
                    os.kill(process, number)
            more = _strays(innocent)
            strays = [*strays, *(set(more) - set(strays))] if number == signal.SIGSTOP else strays
        _reap(strays)
        if time.monotonic() > deadline:
            return _strays(innocent)
    return []


def _reap(processes: list[int]) -> None:
    for process in processes:
        with suppress(ChildProcessError):  # not adopted yet
            os.waitpid(process, os.WNOHANG)


def _strays(innocent: set[int]) -> list[int]:
    children = defaultdict(list)
    for name in os.listdir("/proc"):
        if name.isdigit():
            with suppress(OSError, ValueError, IndexError):
                with open(f"/proc/{name}/stat", "rb") as file:
                    parent = int(file.read().rpartition(b")")[2].split()[1])
                children[parent].append(int(name))
    found, waiting = [], [child for child in children[os.getpid()] if child not in innocent]
    while waiting:
        process = waiting.pop()
        found.append(process)
        waiting += children[process]
    return found
