"""The ending of a worker, in words."""

from __future__ import annotations

import math
import signal
from dataclasses import dataclass

from robsim.teach.isolation.limits import WorkerLimits, as_size

#: Exit codes: the sandbox failed before the report of its layers; no memory was left.
NOT_SHUT_IN, NO_MEMORY = 70, 71
#: Instead of an exit code: killed from outside, or because of its processor time.
KILLED = -getattr(signal, "SIGKILL", 9)


@dataclass(frozen=True)
class Ending:
    """The ending of a worker."""

    text: str  # a sentence without its full stop
    cpu_seconds: float = math.nan  # processor time of all its threads (s); NaN = unknown
    max_rss: int = 0  # its peak of memory (bytes), shared memory included; 0 = unknown
    over: bool = True  # False = it still runs.
    exited: bool = False  # whether it exited, or a signal ended it, within all limits
    left: tuple[str, ...] = ()  # things that cannot be removed; empty if its end is certain


STILL_RUNS = Ending("the worker still runs", over=False)
GRADER_LOST_IT = Ending("the worker was lost: the process that starts workers was killed")


def ending_of(
    code: int,
    cpu_seconds: float,
    max_rss: int,
    *,
    limits: WorkerLimits,
    killed: bool,
    too_much_written: bool,
    left: list[str],
) -> Ending:
    """Return the ending of an exit code, or a negative signal; `killed` = by the grader."""
    by_limit = _by_limit(code, cpu_seconds, limits)
    if too_much_written:
        most = as_size(limits.folder_size)
        by_limit = f"its process wrote more than {most} of files, or folders too deep"
    text = by_limit or _text_of(code, killed)
    if not by_limit and code == NO_MEMORY:  # a submission may end with this code, too
        text += f", or needed more than {as_size(limits.memory)} of memory"
    return Ending(text, cpu_seconds, max_rss, exited=not by_limit, left=tuple(left))


def _by_limit(code: int, cpu_seconds: float, limits: WorkerLimits) -> str:
    """Return the limit that ended a worker; "" = no limit."""
    by_time = {-getattr(signal, "SIGXCPU", 24), KILLED}
    if code in by_time and cpu_seconds >= math.ceil(limits.cpu) - 0.5:
        return f"its process used more than {math.ceil(limits.cpu)} s of processor time"
    return ""


def _text_of(code: int, killed: bool) -> str:
    if code >= 0:
        shown = code if code < 1 << 16 else f"{code:#x}"  # a crash, on Windows
        return f"its process exited (exit code {shown})"
    if killed and code == KILLED:
        return "its process was ended by the grader"
    return f"its process was ended by signal {_name_of(-code)}"


def _name_of(number: int) -> str:
    try:
        return signal.Signals(number).name
    except ValueError:
        return str(number)


class Printed:
    """The first bytes of a worker's output; the rest is counted and dropped."""

    def __init__(self, most: int) -> None:
        self._most = most
        self._kept = bytearray()
        self._dropped = 0

    def add(self, part: bytes) -> None:
        """Add a part of the output."""
        room = self._most - len(self._kept)
        self._kept += part[:room]
        self._dropped += len(part) - len(part[:room])

    @property
    def text(self) -> str:
        """The kept output, unchecked, with a line at the cut if there is one."""
        text = bytes(self._kept).decode("utf-8", "replace")
        return f"{text}\n... cut after {as_size(self._most)}" if self._dropped else text
