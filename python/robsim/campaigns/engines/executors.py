"""Runs in the executor of somebody else, or in the cluster of a Dask client."""

from __future__ import annotations

import pickle
import time
from concurrent.futures import Executor, Future
from typing import Any, Generic, Protocol, TypeGuard

from robsim.campaigns.engines.chunks import SECONDS
from robsim.campaigns.engines.work import JobT, RowT, Work, rows_of

_WORKERS_OF_UNKNOWN = 64  # of an executor that does not say how many it has
_EACH = 2  # chunks of a worker, so that the next one waits for it
#: s that a chunk may take, for each worker there is: a chunk takes a client of Dask about a
#: millisecond, and its scheduler as much, and they are to be busy for a tenth of their time.
SECONDS_OF_WORKER = 0.025
_PATIENCE = 1.0  # s for which a cluster is taken to stay as large as it is


class DaskClient(Protocol):
    """What is needed of a `distributed.Client`; Dask itself is not imported."""

    def get_executor(self, *, pure: bool) -> Executor:
        """Return what gives futures of the standard library."""

    def submit(self, function: Any, /, *args: Any, pure: bool) -> Any:
        """Return a future of Dask, which may be an argument of others."""

    def nthreads(self) -> dict[str, int]:
        """Return the number of threads of each worker."""


class ExecutorWorkers(Generic[JobT, RowT]):
    """The workers of an executor; they receive the work, or its form `sent`, with each chunk."""

    deaths = 1  # Dask itself has tried a run four times by then: its allowed-failures

    def __init__(self, work: Work[JobT, RowT], executor: Executor, sent: Any = None) -> None:
        self._work, self._executor = work, executor
        self._sent: Any = work if sent is None else sent

    def room(self) -> int:
        return _EACH * int(getattr(self._executor, "_max_workers", None) or _WORKERS_OF_UNKNOWN)

    def seconds(self) -> float:
        return SECONDS

    def lost(self, job: JobT, /) -> RowT:
        return self._work.lost(job)

    def submit(self, jobs: list[JobT], /) -> Future[list[RowT]]:
        return self._executor.submit(rows_of, self._sent, jobs)

    def is_death(self, error: Exception, /) -> bool:
        """Whether Dask gave a chunk up; an executor that is broken stays so."""
        if not any(kind.__name__ == "KilledWorker" for kind in type(error).__mro__):
            return False
        # Without what all chunks need, none of them is to blame.
        return getattr(error, "task", None) != getattr(self._sent, "key", "")


class DaskWorkers(ExecutorWorkers[JobT, RowT]):
    """The workers of a Dask client, which may come and go."""

    def __init__(self, work: Work[JobT, RowT], client: DaskClient) -> None:
        # A result that the workers hand on to each other, and make again where it is lost: the
        # scheduler is sent it once, and not with each chunk.
        sent = client.submit(_same, work, pure=False)
        super().__init__(work, client.get_executor(pure=False), sent)
        self._client = client
        self._count, self._asked = 0, -_PATIENCE

    def submit(self, jobs: list[JobT], /) -> Future[list[RowT]]:
        """Hand over a chunk: as bytes, for Dask looks into each tuple of a list for its futures."""
        return self._executor.submit(_rows_of, self._sent, pickle.dumps(jobs))

    def room(self) -> int:
        """Return how many chunks they may have at a time."""
        if (now := time.monotonic()) >= self._asked + _PATIENCE:
            self._count, self._asked = sum(self._client.nthreads().values()), now
        return _EACH * max(self._count, 1)

    def seconds(self) -> float:
        """Return how long a chunk may take (s): longer, where there are more workers."""
        return seconds_of_chunk(self._count)


def seconds_of_chunk(workers: int) -> float:
    """Return how long a chunk may take (s) that Dask hands to one of so many workers."""
    return max(SECONDS, SECONDS_OF_WORKER * workers)


def is_dask_client(value: Any) -> TypeGuard[DaskClient]:
    """Whether a value is a Dask client, told by what it can do."""
    names = ("get_executor", "submit", "nthreads")
    return not isinstance(value, type) and all(callable(getattr(value, n, None)) for n in names)


def check_dask_client(client: DaskClient) -> None:
    """Raise ValueError for a client that cannot be waited for."""
    if getattr(client, "asynchronous", False):
        raise ValueError(
            "executor is a Dask client with asynchronous=True, whose event loop would wait for "
            "itself: give one without"
        )
    if (status := getattr(client, "status", "running")) != "running":
        raise ValueError(f"executor is a Dask client that is {status}: give one that is connected")


def _rows_of(work: Work[Any, RowT], jobs: bytes) -> list[RowT]:
    return rows_of(work, pickle.loads(jobs))


def _same(work: Work[JobT, RowT]) -> Work[JobT, RowT]:
    return work
