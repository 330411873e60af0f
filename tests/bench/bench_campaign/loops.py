"""The same runs by hand: a bare loop, in processes of their own, by a pool, by joblib."""

from __future__ import annotations

import functools
import importlib
import multiprocessing
from collections.abc import Callable
from typing import Any, NamedTuple

from robsim._core import DriveAround
from robsim.campaigns._metrics import METRICS
from robsim.simulation import Scenario, Simulation
from robsim.trace import Trace
from robsim.vision import GaussianNoise

STEPS = 100
_CHUNKS = 20  # of a pool, for each process


def final_x(trace: Trace) -> float:
    """Return where the robot is at the end (px)."""
    return float(trace.pose_true[-1, 0])


class Kind(NamedTuple):
    """Runs to be timed: what they have in common, and what is computed of each."""

    scenario: Scenario
    metric: Callable[[Trace], Any]


KINDS = {
    "no_frames": Kind(Scenario(control=DriveAround(), robot="lab"), final_x),
    "frames_240": Kind(
        Scenario(
            control=DriveAround(),
            robot="lab",
            resolution=(240, 240),
            noise=GaussianNoise(5),
            measure=True,
        ),
        METRICS["tracking"],
    ),
}


@functools.cache
def _simulation(kind: str) -> Simulation:
    return Simulation(KINDS[kind].scenario)


def numbers(kind: str, seed: int) -> Any:
    """Run once, and return what the metric says."""
    simulation = _simulation(kind)
    simulation.reset(seed=seed)
    return KINDS[kind].metric(simulation.run(STEPS))


def bare_loop(kind: str, runs: int) -> list[Any]:
    """Run in this process."""
    simulation, metric = _simulation(kind), KINDS[kind].metric
    found = []
    for seed in range(runs):
        simulation.reset(seed=seed)
        found.append(metric(simulation.run(STEPS)))
    return found


def separate_processes(kind: str, runs: int, count: int) -> None:
    """Run a bare loop in each of some processes, which know nothing of each other."""
    context = multiprocessing.get_context("spawn")
    processes = [
        context.Process(target=bare_loop, args=(kind, runs // count)) for _ in range(count)
    ]
    for process in processes:
        process.start()
    for process in processes:
        process.join()
        if process.exitcode:
            raise RuntimeError(f"a process of the benchmark ended with {process.exitcode}")


def by_pool(kind: str, runs: int, count: int) -> list[Any]:
    """Run in a pool of the standard library."""
    with multiprocessing.get_context("spawn").Pool(count) as pool:
        chunk = max(1, runs // (_CHUNKS * count))
        return pool.map(functools.partial(numbers, kind), range(runs), chunksize=chunk)


def by_joblib(kind: str, runs: int, count: int) -> list[Any]:
    """Run by joblib, whose processes are begun anew each time.

    Raises
    ------
    ImportError
        If it is not installed.
    """
    joblib = importlib.import_module("joblib")
    loky = importlib.import_module("joblib.externals.loky")
    try:
        job = joblib.delayed(numbers)
        found: list[Any] = joblib.Parallel(n_jobs=count)(job(kind, seed) for seed in range(runs))
        return found
    finally:
        loky.get_reusable_executor().shutdown(wait=True)
