"""The limits of a worker."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict, dataclass
from typing import Any, Literal

from robsim.base.checks import check_float, check_int

_MI = 1 << 20
#: Minimum count of each file (bytes), because some disks take milliseconds to remove a folder.
BLOCK = 1 << 16


@dataclass(frozen=True, kw_only=True)
class WorkerLimits:
    """The limits of a submission's size and of one run: time, memory, output, files, threads.

    Parameters
    ----------
    call : float, default: 1.0
        One callback (s): processor time on Linux, with a limit of ten times as long by the
        grader's clock; on other systems this clock alone.
    first_call : float, default: 10.0
        Loading the submission, and the first call (s).
    run : float, default: 60.0
        The whole run (s).
    cpu : float, default: 60.0
        Processor time of all threads together (s); counted in whole seconds, rounded up.
    memory : int, default: 1 GiB
        Address space (bytes). Python, numpy and robsim need about 0.13 GiB of this memory; pandas
        and matplotlib need another 0.3 GiB, and each thread 10 MiB.
    output : int, default: 64 KiB
        The kept part of the printed text (bytes); the rest is read and dropped.
    file_size : int, default: 1 MiB
        The largest file that it may write (bytes) in its scratch folder, or the largest
        submitted file.
    folder_size : int, default: 64 MiB
        All its files together (bytes), each counted with at least 64 KiB. Submitted files count,
        too, but the limit is at least twice their size. Folders may be nested 100 deep. The grader
        checks the size four times a second, so the folder may exceed the limit for a moment.
    open_files : int, default: 64
        Open files, with the few initial ones.
    threads : int, default: 32
        Threads with the main thread. This limit requires a separate user for the worker.
    submission_files : int, default: 100
        Number of submitted files.
    submission_size : int, default: 5 MiB
        All submitted files together (bytes), unpacked; of a notebook, with its outputs.
    submission_file_size : int, default: 1 MiB
        Each submitted file (bytes); of a notebook, without its outputs. The scratch folder has
        these files, regardless of `file_size`. Reports such as PDF files count as empty.
    """

    call: float = 1.0
    first_call: float = 10.0
    run: float = 60.0
    cpu: float = 60.0
    memory: int = 1024 * _MI
    output: int = 64 << 10
    file_size: int = _MI
    folder_size: int = 64 * _MI
    open_files: int = 64
    threads: int = 32
    submission_files: int = 100
    submission_size: int = 5 * _MI
    submission_file_size: int = _MI

    def __post_init__(self) -> None:
        for name in ("call", "first_call", "run", "cpu"):
            check_float(name, getattr(self, name), "s", exclusive_minimum=0, maximum=1e6)
        check_int("memory", self.memory, minimum=64 * _MI, maximum=1 << 46)
        check_int("output", self.output, minimum=0, maximum=1 << 30)
        check_int("file_size", self.file_size, minimum=0, maximum=1 << 40)
        check_int("folder_size", self.folder_size, minimum=0, maximum=1 << 40)
        check_int("open_files", self.open_files, minimum=16, maximum=1 << 16)
        check_int("threads", self.threads, minimum=1, maximum=1 << 12)
        check_int("submission_files", self.submission_files, minimum=1, maximum=10_000)
        for name in ("submission_size", "submission_file_size"):
            check_int(name, getattr(self, name), minimum=1, maximum=128 * _MI)


def as_size(count: int) -> str:
    """Return a number of bytes in a readable unit: ``"1 GiB"``."""
    for unit, size in (("GiB", 1 << 30), ("MiB", _MI), ("KiB", 1 << 10)):
        if count >= size:
            return f"{count / size:.4g} {unit}"
    return f"{count} bytes"


def room_for(sizes: Iterable[int]) -> int:
    """Return the maximum count of files of these sizes (bytes)."""
    return sum(size + BLOCK for size in sizes)


Isolation = Literal["auto", "none", "process", "strict"]
LEVELS: tuple[Isolation, ...] = ("auto", "none", "process", "strict")


@dataclass(frozen=True, kw_only=True)
class Request:
    """The order for a worker."""

    entry: str  # ``"module:function"``: trusted code, called as ``function(channel, memory)``
    limits: WorkerLimits
    isolation: Isolation  # one of `LEVELS`
    hidden: tuple[str, ...] = ()  # folders and files that it must not read
    user: int | None = None  # the number of its user
    without: tuple[str, ...] = ()  # names of layers to leave out

    @property
    def shut(self) -> bool:
        """Whether the worker gets all available layers of the sandbox."""
        return self.isolation in ("auto", "strict")

    def to_message(self) -> dict[str, Any]:
        return asdict(self)

    @classmethod
    def from_message(cls, message: dict[str, Any]) -> Request:
        return cls(
            **{
                **message,
                "limits": WorkerLimits(**message["limits"]),
                "hidden": tuple(message["hidden"]),
                "without": tuple(message["without"]),
            }
        )
