"""The engine of a campaign: what `executor` may be, and how each does the runs."""

from __future__ import annotations

import os
from collections.abc import Generator, Iterable
from concurrent.futures import FIRST_COMPLETED, Executor, Future, ThreadPoolExecutor, wait
from typing import Any

from robsim._base.checks import check_int, is_int
from robsim._base.text import quoted
from robsim.campaigns._engines.chunks import Chunks
from robsim.campaigns._engines.processes import rows_in_processes
from robsim.campaigns._runs import Job, Row, Worker, rows_of
from robsim.campaigns._spec import CampaignSpec

Engine = int | str | Executor | None

_MOST_WORKERS = 1024
_WORKERS_OF_UNKNOWN = 64  # of an executor that does not say how many it has


def engine_value(executor: Any) -> Engine:
    """Return the option ``executor``; else raise TypeError or ValueError."""
    if executor is None or isinstance(executor, Executor):
        return executor
    if is_int(executor):
        return check_int("executor", executor, minimum=1, maximum=_MOST_WORKERS)
    if isinstance(executor, str) and executor == "threads":
        return executor
    expected = (
        "executor must be None, a number of processes, 'threads' or a concurrent.futures.Executor, "
        f"got {quoted(executor)}"
    )
    raise ValueError(expected) if isinstance(executor, str) else TypeError(expected)


def rows_by(
    engine: Engine, spec: CampaignSpec, jobs: Iterable[Job]
) -> Generator[list[Row], None, None]:
    """Yield the rows of all jobs, in the order in which they are done."""
    if engine is None:
        return _rows_here(spec, jobs)
    if isinstance(engine, int):
        return rows_in_processes(spec, jobs, engine)
    if isinstance(engine, str):
        return _rows_in_threads(spec, jobs)
    return _rows_in_executor(spec, jobs, engine)


def _rows_here(spec: CampaignSpec, jobs: Iterable[Job]) -> Generator[list[Row], None, None]:
    worker, chunks = Worker(spec), Chunks(jobs)
    while chunk := chunks.take():
        rows = worker.rows(chunk)
        chunks.note(rows)
        yield rows


def _rows_in_threads(spec: CampaignSpec, jobs: Iterable[Job]) -> Generator[list[Row], None, None]:
    workers = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    pool = ThreadPoolExecutor(workers)
    try:
        yield from _rows_in_executor(spec, jobs, pool)
    finally:
        pool.shutdown(cancel_futures=True)


def _rows_in_executor(
    spec: CampaignSpec, jobs: Iterable[Job], executor: Executor
) -> Generator[list[Row], None, None]:
    chunks = Chunks(jobs)
    window = 2 * int(getattr(executor, "_max_workers", None) or _WORKERS_OF_UNKNOWN)
    flying: set[Future[list[Row]]] = set()
    try:
        while True:
            while len(flying) < window and (chunk := chunks.take()):
                flying.add(executor.submit(rows_of, spec, chunk))
            if not flying:
                return
            done, flying = wait(flying, return_when=FIRST_COMPLETED)
            for future in done:
                rows = future.result()
                chunks.note(rows)
                yield rows
    finally:
        for future in flying:
            future.cancel()
