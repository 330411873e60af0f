"""Chunks in flight, and those whose worker dies under them."""

from __future__ import annotations

from collections.abc import Generator
from concurrent.futures import FIRST_COMPLETED, Future, wait
from typing import Protocol

from robsim.campaigns.engines.work import JobT, RowT, Supply

#: The error of a run whose process dies.
DIED = "WorkerDied: the worker process ended in this run, whenever it was tried"


class Workers(Protocol[JobT, RowT]):
    """Those who do chunks.

    Attributes
    ----------
    deaths : int
        Those of a run that is tried alone, before it counts as failed.
    """

    deaths: int

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

    A worker that dies takes chunks with it that are not to blame. All that are in flight are few;
    the runs of those that are lost are done again one by one, alone. Not by halves: the chunk of a
    run that kills would cost a worker each time.
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
