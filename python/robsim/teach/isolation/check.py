"""A check of the isolation on this machine: a worker tries to leave its sandbox."""

from __future__ import annotations

import ctypes
import json
import os
import socket
import sys
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from robsim.base.report import Quantity, Report
from robsim.teach.errors import GraderError
from robsim.teach.isolation._layers.layer import MOUNTS
from robsim.teach.isolation.limits import Isolation
from robsim.teach.isolation.start import start_worker

_ENTRY = "robsim.teach.isolation._attempts:run"
_PATIENCE = 30.0  # s

#: The gaps of all layers, in words for users.
NOT_PROTECTED = (
    "Faults of the kernel and of the processor (side channels) are not covered: for code of "
    "strangers use a machine or a container without other data.",
    "A submission may find out that files exist, unless it has own mounts, and slow other "
    "processes down by processor time and memory within its limits.",
    "A submission sees its frames, its code, Python, and every installed package except hidden "
    "ones: the assignment decides this, not the isolation.",
)


@dataclass(frozen=True, kw_only=True)
class IsolationReport(Report):
    """The isolation of submissions here, with all attempts to escape. ``bool(report)`` is `strict`.

    Attributes
    ----------
    isolation : str
        The requested isolation.
    layers : tuple of tuple
        Name, whether it holds, and the method or the reason of its failure, for each layer.
    attempts : mapping of str to tuple
        For each attempt, whether it was refused, and the message.
    closed : mapping of str to bool
        Whether a submission has no access, by area: files, processes, network, grader's memory.
    isolation_line : str
        The layers that hold and the layers that fail, in one line.
    certain_end : bool
        Whether no process of a submission can outlive its run.

    Examples
    --------
    >>> report = robsim.teach.check_isolation(isolation="none")
    >>> report.closed["files"]
    False
    """

    isolation: str
    layers: tuple[tuple[str, bool, str], ...]
    attempts: Mapping[str, tuple[bool, str]]
    closed: Mapping[str, bool]
    isolation_line: str
    certain_end: bool

    def __bool__(self) -> bool:
        return self.strict

    @property
    def strict(self) -> bool:
        """Whether ``isolation="strict"`` is available: all areas are closed, all attempts fail."""
        return all(self.closed.values()) and all(held for held, _ in self.attempts.values())

    @property
    def title(self) -> str:
        """The title of the report."""
        return "Isolation of submissions"

    @property
    def verdict(self) -> str:
        """The open areas in a few words."""
        opened = [what for what, closed in self.closed.items() if not closed]
        got_through = [name for name, (held, _) in self.attempts.items() if not held]
        if not opened and not got_through:
            return "closed"
        return f"open: {', '.join(opened or got_through)}"

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """The number of attempts, and the number of refused attempts."""
        refused = sum(held for held, _ in self.attempts.values())
        return (
            Quantity("attempts", "attempts to get out", len(self.attempts)),
            Quantity("refused", "refused", refused),
        )

    @property
    def remarks(self) -> tuple[str, ...]:
        """The effective layers, successful attempts, missing layers with reasons, and gaps."""
        remarks = [self.isolation_line]
        remarks += [
            f"It {text} ({name})" for name, (held, text) in self.attempts.items() if not held
        ]
        remarks += [f"Missing: {name}: {text}" for name, holds, text in self.layers if not holds]
        return (*remarks, self._end, *NOT_PROTECTED)

    @property
    def _end(self) -> str:
        if self.certain_end:
            return "The end of a worker is certain: all its processes end, too."
        return (
            "A worker may leave a process that outlives it: the grader searches and ends it, but "
            "may not find a process that flees faster."
        )


def check_isolation(*, isolation: Isolation = "auto") -> IsolationReport:
    """Let a worker try all known ways out of its sandbox, and return a report.

    Parameters
    ----------
    isolation : {"auto", "none", "process", "strict"}
        The isolation, as in grading.

    Raises
    ------
    IsolationError
        If ``"strict"`` is unavailable.
    GraderError
        If no worker can be started, or it does not answer.

    Examples
    --------
    >>> robsim.teach.check_isolation(isolation="none").strict
    False
    """
    ours, theirs = socket.socketpair()
    with ours, _targets() as target:
        with theirs:
            worker = start_worker(
                entry=_ENTRY, channel=theirs, isolation=isolation, hidden=[target["hidden"]]
            )
        with worker:
            attempts = _answers(ours, target)
            if attempts is None:
                worker.kill()
                said = worker.output.strip()[-500:]
                raise GraderError(f"the trial worker gave no answer: {worker.wait().text} {said}")
        layers = worker.layers
        if not layers.holds(MOUNTS):  # no other layer closes names
            attempts.pop("find a file", None)
        return IsolationReport(
            isolation=isolation,
            layers=tuple((layer.name, layer.holds, layer.text) for layer in layers.layers),
            attempts=attempts,
            closed=dict(layers.closed),
            isolation_line=layers.line,
            certain_end=layers.certain_end,
        )


def _answers(channel: socket.socket, target: dict[str, Any]) -> dict[str, tuple[bool, str]] | None:
    channel.settimeout(_PATIENCE)
    try:
        channel.sendall(json.dumps(target).encode())
        with channel.makefile("rb") as lines:
            answers = json.loads(lines.readline() or b"null")
    except (OSError, ValueError):
        return None
    return answers and {name: (held, text) for name, (held, text) in answers.items()}


@contextmanager
def _targets() -> Iterator[dict[str, Any]]:
    """Yield the targets of the attempts: a file, a folder, a server and memory of the grader."""
    secret = ctypes.create_string_buffer(b"robsim!")
    package = Path(sys.modules["robsim"].__file__ or "").parent
    with tempfile.TemporaryDirectory() as folder, socket.create_server(("127.0.0.1", 0)) as server:
        os.chmod(folder, 0o777)
        file = Path(folder, "file")
        file.write_text("secret")
        os.chmod(file, 0o666)
        yield {
            "file": str(file),
            "folder": folder,
            "hidden": str(package / "estimation/reference/__init__.py"),  # unused by the worker
            "process": os.getpid(),
            "address": ctypes.addressof(secret),
            "port": server.getsockname()[1],
        }
