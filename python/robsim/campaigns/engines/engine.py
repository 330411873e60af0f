"""The engine of a campaign: the values of `executor`, and their ways to do the runs."""

from __future__ import annotations

import os
from collections.abc import Generator
from concurrent.futures import Executor, ThreadPoolExecutor
from contextlib import closing
from typing import Any

from robsim.base.checks import check_int, is_int
from robsim.base.in_browser import check_has_threads
from robsim.base.text import quoted
from robsim.campaigns.engines.executors import (
    DaskClient,
    DaskWorkers,
    Workers,
    is_dask_client,
    rows_of_workers,
)
from robsim.campaigns.engines.processes import Processes
from robsim.campaigns.engines.work import JobT, RowT, Supply, Work

#: A number of processes, "threads", an executor, a Dask client; None = here.
Engine = int | str | Executor | DaskClient | None

_MOST_WORKERS = 1024


def engine_value(executor: Any) -> Engine:
    """Return the option ``executor``; else raise TypeError or ValueError."""
    if executor is None or isinstance(executor, Executor) or is_dask_client(executor):
        return executor
    if is_int(executor):
        return check_int("executor", executor, minimum=1, maximum=_MOST_WORKERS)
    if isinstance(executor, str) and executor == "threads":
        return executor
    expected = (
        "executor must be None, a number of processes, 'threads', a concurrent.futures.Executor or "
        f"a Dask Client, got {quoted(executor)}"
    )
    if callable(getattr(executor, "get_client", None)):
        expected += ": use its client, from get_client()"
    raise ValueError(expected) if isinstance(executor, str) else TypeError(expected)


def rows_by(
    engine: Engine, work: Work[JobT, RowT], chunks: Supply[JobT, RowT]
) -> Generator[list[RowT], None, None]:
    """Yield the rows of all jobs, in their order of completion."""
    if engine is None:
        yield from _rows_here(work, chunks)
        return
    check_has_threads("A campaign with an executor")
    if isinstance(engine, int):
        with closing(Processes(work, engine)) as processes:
            yield from rows_of_workers(processes, chunks)
    elif isinstance(engine, str):
        with ThreadPoolExecutor(processors()) as pool:
            yield from rows_of_workers(Workers(work, pool), chunks)
    elif isinstance(engine, Executor):
        yield from rows_of_workers(Workers(work, engine), chunks)
    else:
        yield from rows_of_workers(DaskWorkers(work, engine), chunks)


def _rows_here(
    work: Work[JobT, RowT], chunks: Supply[JobT, RowT]
) -> Generator[list[RowT], None, None]:
    doer = work.doer()
    while chunk := chunks.take():
        rows = list(map(doer, chunk))
        chunks.note(rows)
        yield rows


def processors() -> int:
    """Return the number of cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
