"""Work in an executor or in the cluster of a Dask client, whose workers may die."""

from __future__ import annotations

import pickle
import time
from collections.abc import Generator
from concurrent.futures import FIRST_COMPLETED, Executor, Future, wait
from typing import Any, Generic, Protocol, TypeGuard

from robsim.campaigns.engines.work import JobT, RowT, Supply, Work

_WORKERS_OF_UNKNOWN = 64  # of an executor with an unknown number of workers.
_EACH = 2  # chunks of a worker, so that the next one waits for it.
_PATIENCE = 1.0  # s for which the size of a cluster counts as constant


class DaskClient(Protocol):
    """The required part of a `distributed.Client`; Dask itself is not imported."""

    def get_executor(self, *, pure: bool) -> Executor:
        """Return an executor with futures of the standard library."""

    def submit(self, function: Any, /, *args: Any, pure: bool) -> Any:
        """Return a future of Dask, which may be an argument of others."""

    def nthreads(self) -> dict[str, int]:
        """Return the number of threads of each worker."""


class Workers(Generic[JobT, RowT]):
    """The workers of an executor; each chunk brings them the work, or `sent`, its other form."""

    deaths = 1  # of a run alone make it count as failed; Dask itself has tried it four times

    def __init__(self, work: Work[JobT, RowT], executor: Executor, sent: Any = None) -> None:
        self.work, self._executor = work, executor
        self._sent: Any = work if sent is None else sent

    def room(self) -> int:
        """Return the maximum number of simultaneous chunks."""
        return _EACH * int(getattr(self._executor, "_max_workers", None) or _WORKERS_OF_UNKNOWN)

    def submit(self, jobs: list[JobT], /) -> Future[list[RowT]]:
        """Submit a chunk as bytes, because Dask searches the tuples of a list for its futures."""
        return self._executor.submit(_rows_of, self._sent, pickle.dumps(jobs))

    def is_death(self, error: Exception, /) -> bool:
        """Whether Dask dropped a chunk; a broken executor stays broken."""
        if not any(kind.__name__ == "KilledWorker" for kind in type(error).__mro__):
            return False
        # Without what all chunks need, none of them is to blame.
        return getattr(error, "task", None) != getattr(self._sent, "key", "")


class DaskWorkers(Workers[JobT, RowT]):
    """The workers of a Dask client, which may come and go."""

    def __init__(self, work: Work[JobT, RowT], client: DaskClient) -> None:
        # A result that the workers hand on to each other, and make again where it is lost: the
        # scheduler is sent it once, and not with each chunk.
        sent = client.submit(_same, work, pure=False)
        super().__init__(work, client.get_executor(pure=False), sent)
        self._client = client
        self._count, self._asked = 0, -_PATIENCE

    def room(self) -> int:
        if (now := time.monotonic()) >= self._asked + _PATIENCE:
            self._count, self._asked = sum(self._client.nthreads().values()), now
        return _EACH * max(self._count, 1)


def _same(work: Work[JobT, RowT]) -> Work[JobT, RowT]:
    return work


def _rows_of(work: Work[Any, RowT], jobs: bytes) -> list[RowT]:
    return list(map(work.doer(), pickle.loads(jobs)))


def rows_of_workers(
    workers: Workers[JobT, RowT], chunks: Supply[JobT, RowT]
) -> Generator[list[RowT], None, None]:
    """Yield the rows of all chunks.

    A dying worker loses chunks, also innocent ones. Few chunks are in flight, and the runs of lost
    chunks are repeated one by one, alone. Bisection would be worse: the chunk of a killing run
    would cost a worker each time.
    """
    flying: dict[Future[list[RowT]], list[JobT]] = {}
    lost: list[JobT] = []
    try:
        while True:
            while not lost and len(flying) < workers.room() and (chunk := chunks.take()):
                flying[workers.submit(chunk)] = chunk
            if not flying and not lost:
                return
            for future in wait(flying, return_when=FIRST_COMPLETED).done:
                chunk = flying.pop(future)
                if (rows := _rows_unless_lost(workers, future)) is None:
                    lost += chunk
                else:
                    chunks.note(rows)
                    yield rows
            if lost and not flying:
                for job in lost:
                    yield _alone(workers, job)
                lost = []
    finally:
        for future in flying:
            future.cancel()


def _alone(workers: Workers[JobT, RowT], job: JobT) -> list[RowT]:
    """Do one job, and return its row, also for a job that kills its worker."""
    for _ in range(workers.deaths):
        future = workers.submit([job])
        try:
            rows = _rows_unless_lost(workers, future)
        finally:
            future.cancel()
        if rows is not None:
            return rows
    return [workers.work.lost(job)]


def _rows_unless_lost(
    workers: Workers[JobT, RowT], future: Future[list[RowT]]
) -> list[RowT] | None:
    try:
        return future.result()
    except Exception as error:
        if workers.is_death(error):
            return None
        raise


def is_dask_client(value: Any) -> TypeGuard[DaskClient]:
    """Whether a value is a Dask client, by its methods; raise for an unusable one."""
    names = ("get_executor", "submit", "nthreads")
    if isinstance(value, type) or not all(callable(getattr(value, n, None)) for n in names):
        return False
    if getattr(value, "asynchronous", False):
        raise ValueError(
            "executor must be a Dask client with asynchronous=False, got asynchronous=True, which "
            "would deadlock"
        )
    if (status := getattr(value, "status", "running")) != "running":
        raise ValueError(f"executor must be a connected Dask client, got a client that is {status}")
    return True
