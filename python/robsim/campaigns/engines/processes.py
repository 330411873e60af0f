"""Runs in separate processes, which may die, and the chunks in flight at that moment."""

from __future__ import annotations

import multiprocessing
import os
import pickle
import signal
import tempfile
import threading
from collections.abc import Generator
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    CancelledError,
    Future,
    ProcessPoolExecutor,
    wait,
)
from contextlib import suppress
from multiprocessing.connection import wait as wait_for
from typing import Any, Generic, Protocol

from robsim.campaigns.engines.chunks import SECONDS
from robsim.campaigns.engines.work import Doer, JobT, RowT, Supply, Work

_LOST = (BrokenExecutor, CancelledError)
_STARTS = 5  # of a pool, before there is something else wrong


class Processes(Generic[JobT, RowT]):
    """A pool of processes, replaced if one of them dies; TypeError for code that cannot be sent."""

    deaths = 2

    def __init__(self, work: Work[JobT, RowT], count: int) -> None:
        work.check_can_be_sent()
        self._work = work
        self._count = count
        self._pool: ProcessPoolExecutor | None = None
        # Only what fits into a pipe is sent through one: who sends more waits for the reader, even
        # if that is dead.
        content = pickle.dumps(work)
        descriptor, self._file = tempfile.mkstemp(prefix="robsim-campaign-")
        with open(descriptor, "wb") as stream:
            stream.write(content)

    def close(self) -> None:
        """End for good."""
        self.end()
        with suppress(OSError):
            os.unlink(self._file)

    def room(self) -> int:
        return self._count + 1

    def seconds(self) -> float:
        return SECONDS

    def is_death(self, error: Exception, /) -> bool:
        return isinstance(error, _LOST)

    def lost(self, job: JobT, /) -> RowT:
        return self._work.lost(job)

    def submit(self, jobs: list[JobT], /) -> Future[list[RowT]]:
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
            "must call this below the line `if __name__ == '__main__':`, and what other "
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


_doer: Doer[Any, Any] | None = None  # of this process, if it is one of a pool


def _begin(file: str) -> None:
    """Begin a worker process: Ctrl-C is for its parent, and it ends with that."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, args=(file,), daemon=True).start()
    global _doer
    with open(file, "rb") as stream:
        work: Work[Any, Any] = pickle.load(stream)
    _doer = work.doer()


def _rows(jobs: list[Any]) -> list[Any]:
    assert _doer is not None
    return _doer.rows(jobs)


def _end_with_parent(file: str) -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        wait_for([parent.sentinel])
        with suppress(OSError):
            os.unlink(file)
        os._exit(1)


#: The error of a run whose process dies.
DIED = "WorkerDied: the worker process ended in this run, whenever it was tried"


class Workers(Protocol[JobT, RowT]):
    """Workers that run chunks."""

    deaths: int  # so many of a run alone make it count as failed

    def room(self) -> int:
        """Return how many chunks they may have at a time."""

    def seconds(self) -> float:
        """Return how long a chunk may take (s)."""

    def submit(self, jobs: list[JobT], /) -> Future[list[RowT]]:
        """Hand over a chunk."""

    def lost(self, job: JobT, /) -> RowT:
        """Return the row of a job whose worker dies, whenever it is tried."""

    def is_death(self, error: Exception, /) -> bool:
        """Whether a chunk was lost with its worker, and others go on."""


def rows_of_workers(
    workers: Workers[JobT, RowT], chunks: Supply[JobT, RowT]
) -> Generator[list[RowT], None, None]:
    """Yield the rows of all chunks.

    A worker that dies takes the few chunks in flight, too. The lost runs are done again one by one.
    By halves, the chunk of a run that kills would cost a worker each time.
    """
    while lost := (yield from _together(workers, chunks)):
        yield from _alone(workers, lost)


def _together(
    workers: Workers[JobT, RowT], chunks: Supply[JobT, RowT]
) -> Generator[list[RowT], None, list[list[JobT]]]:
    """Run all chunks until a worker dies; return the chunks that are lost then."""
    flying: dict[Future[list[RowT]], list[JobT]] = {}
    lost: list[list[JobT]] = []
    try:
        while True:
            room, seconds = workers.room(), workers.seconds()
            while not lost and len(flying) < room and (chunk := chunks.take(seconds, room)):
                flying[workers.submit(chunk)] = chunk
            if not flying:
                return lost
            done, _ = wait(flying, return_when=FIRST_COMPLETED)
            for future in done:
                chunk = flying.pop(future)
                rows = _rows_unless_lost(workers, future)
                if rows is None:
                    lost.append(chunk)
                else:
                    chunks.note(rows)
                    yield rows
    finally:
        for future in flying:
            future.cancel()


def _alone(
    workers: Workers[JobT, RowT], lost: list[list[JobT]]
) -> Generator[list[RowT], None, None]:
    """Do one job after the other; one that kills its worker gets a row that says so."""
    for job in (job for chunk in lost for job in chunk):
        for _ in range(workers.deaths):
            future = workers.submit([job])
            try:
                rows = _rows_unless_lost(workers, future)
            finally:
                future.cancel()
            if rows is not None:
                break
        yield [workers.lost(job)] if rows is None else rows


def _rows_unless_lost(
    workers: Workers[JobT, RowT], future: Future[list[RowT]]
) -> list[RowT] | None:
    try:
        return future.result()
    except Exception as error:
        if workers.is_death(error):
            return None
        raise
