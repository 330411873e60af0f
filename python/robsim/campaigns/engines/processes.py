"""Work in separate processes, which may die, and end with this one."""

from __future__ import annotations

import multiprocessing
import os
import pickle
import signal
import tempfile
import threading
from collections.abc import Callable
from concurrent.futures import BrokenExecutor, CancelledError, Future, ProcessPoolExecutor
from contextlib import suppress
from multiprocessing.connection import wait as wait_for
from typing import Any

from robsim.campaigns.engines.executors import Workers
from robsim.campaigns.engines.work import JobT, RowT, Work

_LOST = (BrokenExecutor, CancelledError)
_STARTS = 5  # of a pool, before there is something else wrong


class Processes(Workers[JobT, RowT]):
    """A pool of processes, replaced after the death of any process breaks it."""

    deaths = 2

    def __init__(self, work: Work[JobT, RowT], count: int) -> None:
        self.work, self._count = work, count
        self._pool: ProcessPoolExecutor | None = None
        # Only what fits into a pipe is sent through one: who sends more waits for the reader, even
        # if that is dead.
        content = pickle.dumps(work)
        descriptor, self._file = tempfile.mkstemp(prefix="robsim-campaign-")
        with open(descriptor, "wb") as stream:
            stream.write(content)

    def close(self) -> None:
        """End permanently."""
        self.end()
        with suppress(OSError):
            os.unlink(self._file)

    def room(self) -> int:
        return self._count + 1

    def is_death(self, error: Exception, /) -> bool:
        return isinstance(error, _LOST)

    def submit(self, jobs: list[JobT], /) -> Future[list[RowT]]:
        """Submit a chunk; a broken pool is replaced."""
        for _ in range(_STARTS):
            try:
                if self._pool is None:
                    self._pool = self._begun()
                return self._pool.submit(_rows, jobs)
            except _LOST:
                self.end()
        raise RuntimeError(
            "executor: the worker processes ended at their start. In a program in a file, call "
            "this below the line `if __name__ == '__main__':`. In any other program, put your own "
            "classes and functions into a module"
        )

    def _begun(self) -> ProcessPoolExecutor:
        pool = ProcessPoolExecutor(
            self._count,
            mp_context=multiprocessing.get_context("spawn"),
            initializer=_begin,
            initargs=(self._file,),
        )
        self._pool = pool
        # All processes start at once; the first job fails if they end as soon as they begin.
        first, *_ = [pool.submit(_rows, []) for _ in range(self._count)]
        first.result()
        return pool

    def end(self) -> None:
        """End the processes, if necessary in the middle of their runs."""
        pool, self._pool = self._pool, None
        if pool is None:
            return
        processes = list((getattr(pool, "_processes", None) or {}).values())
        pool.shutdown(wait=False, cancel_futures=True)
        for process in processes:
            process.terminate()
        pool.shutdown()


def end_copy() -> None:
    """End a worker that would rerun a program without a main guard: its parent raises the error."""
    if getattr(multiprocessing.current_process(), "_inheriting", False):
        os._exit(1)


_doer: Callable[[Any], Any] | None = None  # of this process, if it is one of a pool


def _begin(file: str) -> None:
    """Initialise a worker process: Ctrl-C goes to its parent, and it ends with its parent."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, args=(file,), daemon=True).start()
    global _doer
    with open(file, "rb") as stream:
        work: Work[Any, Any] = pickle.load(stream)
    _doer = work.doer()


def _rows(jobs: list[Any]) -> list[Any]:
    assert _doer is not None
    return list(map(_doer, jobs))


def _end_with_parent(file: str) -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        wait_for([parent.sentinel])
        with suppress(OSError):
            os.unlink(file)
        os._exit(1)
