"""The search for an ended worker's processes, and their end."""

from __future__ import annotations

import os
import signal
import sys
import time
from collections import defaultdict
from contextlib import suppress

assert sys.platform == "linux"
_PATIENCE = 5.0  # s


def end_strays(innocent: set[int]) -> list[int]:
    """End all descendants of this process but some children and theirs; return the survivors.

    This process adopts orphans of its descendants (PR_SET_CHILD_SUBREAPER). It stops them
    before it kills them, so that they cannot start others meanwhile.
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
    own = int(os.readlink("/proc/self"))
    depth = len(_numbers(own)) - 1
    found, waiting = [], list(children[own])
    while waiting:
        process = waiting.pop()
        numbers = _numbers(process)
        if len(numbers) > depth and numbers[depth] not in innocent:
            found.append(numbers[depth])
            waiting += children[process]
    return found


def _numbers(process: int) -> list[int]:
    with suppress(OSError), open(f"/proc/{process}/status") as file:
        for line in file:
            if line.startswith("NSpid:"):
                return [int(number) for number in line.split()[1:]]
    return []
