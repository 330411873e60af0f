"""`run_campaign_bench`: campaigns and loops by hand, timed in turns."""

from __future__ import annotations

import importlib.util
import math
import tempfile
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from bench_campaign.dask_tasks import ASSUMED, dask_task_cost
from bench_campaign.loops import (
    KINDS,
    STEPS,
    bare_loop,
    by_joblib,
    by_pool,
    separate_processes,
)
from bench_campaign.parent import parent_cost
from bench_campaign.result import CampaignBench
from bench_campaign.scaling import scaling_of
from robsim.base.checks import check_float, check_int
from robsim.campaigns import campaign

_PROCESSES = 2
_SLICES = 5  # of a loop, so that other work beside it is seen in few
_SIZES = (100, 1000, 10_000, 100_000)  # runs
_NO_DASK = (
    "Dask is not installed, and its costs are those of another machine: pip install distributed"
)


def run_campaign_bench(
    *,
    rounds: int = 3,
    seconds: float = 0.5,
    sizes: tuple[int, ...] = _SIZES,
    tasks: int = 1000,
) -> CampaignBench:
    """Time campaigns beside the same loops by hand.

    Parameters
    ----------
    rounds : int
        Number of timings of each way, in turns; the shortest counts.
    seconds : float
        Processor time of a bare loop (s); in two processes three times as much.
    sizes : tuple of int
        Numbers of runs whose cost is compared, ascending.
    tasks : int
        Number of empty tasks for Dask, if it is installed.

    Returns
    -------
    CampaignBench
        The times; print it.
    """
    check_int("rounds", rounds, minimum=1, maximum=10**6)
    check_float("seconds", seconds, "s", exclusive_minimum=0)
    growing, memory = _growing(sizes)
    serial = {kind: _serial(kind, rounds, seconds) for kind in KINDS}
    kind = "frames_240"
    runs = _PROCESSES * math.ceil(3 * seconds / serial[kind][0])
    has_joblib = importlib.util.find_spec("joblib") is not None
    has_dask = importlib.util.find_spec("distributed") is not None
    task = dask_task_cost(tasks) if has_dask else ASSUMED
    return CampaignBench(
        serial=serial,
        parallel=_parallel(kind, rounds, runs, has_joblib=has_joblib),
        growing=growing,
        memory=memory,
        scaling=scaling_of(parent_cost(max(sizes)), task),
        left_out=(
            *(() if has_joblib else ("joblib is left out: pip install joblib",)),
            *(() if has_dask else (_NO_DASK,)),
        ),
    )


def _campaign(kind: str, runs: int, **options: Any) -> None:
    scenario, metric = KINDS[kind]
    campaign(
        scenario,
        metrics={"metric": metric},
        runs=runs,
        steps=STEPS,
        seed=1,
        progress=False,
        on_error="raise",
        **options,
    )


def _growing(sizes: tuple[int, ...]) -> tuple[dict[int, float], float | None]:
    """Return the processor time of a run by the number of runs (s), the growth of memory (MB)."""
    _campaign("no_frames", min(sizes))
    times, before = {}, None
    with tempfile.TemporaryDirectory() as folder:
        for runs in sizes:
            before = _memory()
            begin = time.process_time()
            _campaign("no_frames", runs, store=Path(folder, f"{runs}.sqlite"))
            times[runs] = (time.process_time() - begin) / runs
        after = _memory()
    return times, None if before is None or after is None else after - before


def _memory() -> float | None:
    """Return what this process has in memory (MB), None where the system does not say."""
    with suppress(OSError):
        for line in Path("/proc/self/status").read_text().splitlines():
            if line.startswith("VmRSS:"):
                return int(line.split()[1]) / 1024
    return None


def _serial(kind: str, rounds: int, seconds: float) -> tuple[float, float]:
    """Return the processor time of a run (s) in a bare loop and in a campaign."""
    bare_loop(kind, 2)
    begin = time.process_time()
    bare_loop(kind, 10)
    runs = max(10, math.ceil(10 * seconds / _SLICES / (time.process_time() - begin)))
    calls: dict[str, Callable[[], Any]] = {
        "bare": lambda: bare_loop(kind, runs),
        "campaign": lambda: _campaign(kind, runs),
    }
    times = _shortest(calls, _SLICES * rounds, time.process_time)
    return times["bare"] / runs, times["campaign"] / runs


def _parallel(kind: str, rounds: int, runs: int, *, has_joblib: bool) -> dict[str, float]:
    """Return the runs a second of two processes, by who begins them."""
    calls: dict[str, Callable[[], Any]] = {
        "campaign": lambda: _campaign(kind, runs, executor=_PROCESSES),
        "separate": lambda: separate_processes(kind, runs, _PROCESSES),
        "pool": lambda: by_pool(kind, runs, _PROCESSES),
    }
    if has_joblib:
        calls["joblib"] = lambda: by_joblib(kind, runs, _PROCESSES)
    return {name: runs / each for name, each in _shortest(calls, rounds, time.perf_counter).items()}


def _shortest(
    calls: Mapping[str, Callable[[], Any]], rounds: int, clock: Callable[[], float]
) -> dict[str, float]:
    """Return the shortest time of each call (s), of as many rounds."""
    times = dict.fromkeys(calls, math.inf)
    for _ in range(rounds):
        for name, call in calls.items():
            begin = clock()
            call()
            times[name] = min(times[name], clock() - begin)
    return times
