"""What Dask takes for a task that does nothing: in the calling process, and in its scheduler."""

from __future__ import annotations

import contextlib
import importlib
import operator
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from concurrent.futures import FIRST_COMPLETED, Future, wait
from pathlib import Path
from typing import Any, NamedTuple

_FLYING = 128  # tasks at a time
_WORKERS = 2
_PATIENCE = 60.0  # s for scheduler and workers to begin
_ALONE = ("--host", "127.0.0.1", "--no-dashboard")


class TaskCost(NamedTuple):
    """Processor time for a task (s): of the client, in the calling process, and the scheduler."""

    client: float
    scheduler: float


#: What was measured on a machine of two cores beside other work, with Dask 2026.8.
ASSUMED = TaskCost(client=1.4e-3, scheduler=1.8e-3)


def dask_task_cost(tasks: int) -> TaskCost:
    """Return what Dask takes for each of so many empty tasks.

    Scheduler and workers are processes of their own on this machine, begun and ended here.

    Raises
    ------
    ImportError
        If it is not installed.
    """
    distributed = importlib.import_module("distributed")
    psutil = importlib.import_module("psutil")
    with _scheduler() as (file, process):
        client = distributed.Client(scheduler_file=str(file), set_as_default=False)
        with client, client.get_executor(pure=False) as executor:
            client.wait_for_workers(_WORKERS, timeout=_PATIENCE)
            scheduler = psutil.Process(process.pid)
            _run(executor, _FLYING)
            before = time.process_time(), _processor_time(scheduler)
            _run(executor, tasks)
            after = time.process_time(), _processor_time(scheduler)
    return TaskCost(*((b - a) / tasks for a, b in zip(before, after, strict=True)))


def _run(executor: Any, tasks: int) -> None:
    left, flying = tasks, set[Future[Any]]()
    while left or flying:
        while left and len(flying) < _FLYING:
            flying.add(executor.submit(operator.index, left))
            left -= 1
        _, flying = wait(flying, return_when=FIRST_COMPLETED)


def _processor_time(process: Any) -> float:
    times = process.cpu_times()
    return float(times.user + times.system)


@contextlib.contextmanager
def _scheduler() -> Iterator[tuple[Path, subprocess.Popen[bytes]]]:
    """Give the file that says where the scheduler is, and its process."""
    with tempfile.TemporaryDirectory() as folder, contextlib.ExitStack() as begun:
        file = Path(folder, "scheduler.json")
        common = (*_ALONE, "--scheduler-file", str(file))
        process = _begin(begun, "dask_scheduler", *common, "--port", "0")
        for _ in range(_WORKERS):
            options = ("--no-nanny", "--nthreads", "1", "--local-directory", folder)
            _begin(begun, "dask_worker", *common, *options)
        yield file, process


def _begin(begun: contextlib.ExitStack, module: str, *options: str) -> subprocess.Popen[bytes]:
    process = subprocess.Popen(
        [sys.executable, "-m", f"distributed.cli.{module}", *options],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    begun.callback(process.wait)
    begun.callback(process.terminate)
    return process
