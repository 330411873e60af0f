"""Runs in processes of their own, which may die."""

from __future__ import annotations

import multiprocessing
import os
import pickle
import signal
import sys
import tempfile
import threading
from concurrent.futures import BrokenExecutor, CancelledError, Future, ProcessPoolExecutor
from contextlib import suppress
from multiprocessing.connection import wait as wait_for

from robsim._base.text import quoted, said_by
from robsim.campaigns._choices import Callback, Data, Factory, Folder
from robsim.campaigns._engines.chunks import SECONDS
from robsim.campaigns._runs import Job, Row, Worker
from robsim.campaigns._spec import CampaignSpec

_LOST = (BrokenExecutor, CancelledError)
_STARTS = 5  # of a pool, before there is something else wrong


class Processes:
    """A pool of processes that is made anew when it is broken, as it is by any that dies.

    Raises TypeError for code that other processes cannot be sent.
    """

    deaths = 2

    def __init__(self, spec: CampaignSpec, count: int) -> None:
        _check_can_be_sent(spec)
        self._count = count
        self._pool: ProcessPoolExecutor | None = None
        # Only what fits into a pipe is sent through one: who sends more waits for the reader, even
        # if that is dead.
        content = pickle.dumps(spec)
        descriptor, self._file = tempfile.mkstemp(prefix="robsim-campaign-")
        with open(descriptor, "wb") as stream:
            stream.write(content)

    def close(self) -> None:
        """End for good."""
        self.end()
        with suppress(OSError):
            os.unlink(self._file)

    def room(self) -> int:
        """Return how many chunks they may have at a time."""
        return self._count + 1

    def seconds(self) -> float:
        """Return how long a chunk may take (s)."""
        return SECONDS

    def is_death(self, error: Exception, /) -> bool:
        """Whether a chunk was lost with its process."""
        return isinstance(error, _LOST)

    def submit(self, jobs: list[Job], /) -> Future[list[Row]]:
        """Hand over a chunk; a broken pool is replaced."""
        for _ in range(_STARTS):
            try:
                if self._pool is None:
                    self._pool = self._begun()
                return self._pool.submit(_rows, jobs)
            except _LOST:
                self.end()
        raise RuntimeError(
            "executor: the worker processes end as soon as they begin; a program that is a file "
            "must call campaign below the line `if __name__ == '__main__':`, and what other "
            "programs define as they run must lie in a module"
        )

    def _begun(self) -> ProcessPoolExecutor:
        pool = ProcessPoolExecutor(
            self._count,
            mp_context=multiprocessing.get_context("spawn"),
            initializer=_begin,
            initargs=(self._file,),
        )
        self._pool = pool
        pool.submit(_rows, []).result()
        return pool

    def end(self) -> None:
        """End the processes, in the middle of their runs if need be."""
        pool, self._pool = self._pool, None
        if pool is None:
            return
        processes = list((getattr(pool, "_processes", None) or {}).values())
        pool.shutdown(wait=False, cancel_futures=True)
        for process in processes:
            process.terminate()
        pool.shutdown()


_worker: Worker | None = None  # of this process, if it is one of a pool


def _begin(file: str) -> None:
    """Begin a worker process: Ctrl-C is for its parent, and it ends with that."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, args=(file,), daemon=True).start()
    global _worker
    with open(file, "rb") as stream:
        _worker = Worker(pickle.load(stream))


def _rows(jobs: list[Job]) -> list[Row]:
    assert _worker is not None
    return _worker.rows(jobs)


def _end_with_parent(file: str) -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        wait_for([parent.sentinel])
        with suppress(OSError):
            os.unlink(file)
        os._exit(1)


def _check_can_be_sent(spec: CampaignSpec) -> None:
    """Raise TypeError for code that other processes cannot be sent."""
    parts: list[tuple[str, object]] = [
        (f"vary: {name} {label!r}", _content(choice))
        for name, choices in spec.vary.items()
        for label, choice in choices.items()
    ]
    parts += [(f"metrics: {name!r}", metric) for name, metric in spec._functions.items()]
    for what, value in parts:
        remedy = f"define it in a module, or give executor='threads'; got {quoted(value)}"
        try:
            content = pickle.dumps(value)
        except Exception as error:
            raise TypeError(
                f"{what} cannot be sent to other processes ({said_by(error)}): {remedy}"
            ) from error
        if b"__main__" in content and not hasattr(sys.modules["__main__"], "__file__"):
            raise TypeError(f"{what} of a notebook or a prompt cannot be sent to others: {remedy}")


def _content(choice: object) -> object:
    match choice:
        case Data(value=content) | Callback(function=content) | Factory(make=content):
            return content
        case Folder(sources=content):
            return content
    return choice
