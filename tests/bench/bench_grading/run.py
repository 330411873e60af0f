"""`run_grading_bench`: steps with and without a worker, timed in turns."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass

from bench_grading.result import GradingBench
from robsim._core import DriveAround
from robsim.base.checks import check_float, check_int
from robsim.simulation import Scenario, Simulation
from robsim.teach.grading.graded_run import all_here, asking, graded_run, started
from robsim.teach.grading.keys import RunSeeds
from robsim.teach.grading.task import Task
from robsim.teach.isolation import Isolation, WorkerLimits
from robsim.teach.submissions import Rules, SubmissionFiles
from robsim.vision.imaging.noise import GaussianNoise

_WARM_UP = 20  # steps
_PATIENT = WorkerLimits(call=60, first_call=60, run=1e6, cpu=1e6)

_MEASURE = """
import robsim

def measure(step):
    return robsim.locate(step.blobs, step.markers, plane_map=step.frame.plane_map)
"""

_ESTIMATE = """
import numpy as np
import robsim

pose, P = np.array([600.0, 600.0, 0.0]), 100 * np.eye(3)

def estimate_state(step):
    global pose, P
    P = P + np.eye(3)
    if step.measurement is not None:
        gain = P @ np.linalg.inv(P + 4 * np.eye(3))
        pose = pose + gain @ (step.measurement.pose - pose)
        P = (np.eye(3) - gain) @ P
    return robsim.Estimate(pose, (P + P.T) / 2)
"""

_CONTROL = """
def control(step):
    return 0.3, 0.3 - 0.1 * (step.k % 20 > 10)
"""


@dataclass(frozen=True)
class _Kind:
    """A kind of runs: the slot of the submission, what fills it, and the world."""

    slot: str
    code: str
    size: int = 480
    noise: float = 0
    measure: bool = True

    def scenario(self) -> Scenario:
        return Scenario(
            resolution=(self.size, self.size),
            noise=GaussianNoise(self.noise) if self.noise else None,
            measure=self.measure,
            control=DriveAround(),
        )

    def task(self, isolation: Isolation) -> Task:
        source = {f"{self.slot}.py": self.code.encode()}
        files = SubmissionFiles("bench", "folder", "", source, (self.slot,))
        rules = Rules(slots=(self.slot,))
        return Task(submission=files, rules=rules, limits=_PATIENT, isolation=isolation)


KINDS = {
    "1200_gaussian_10": _Kind("measure", _MEASURE, 1200, 10),
    "1200_clean": _Kind("measure", _MEASURE, 1200),
    "480_gaussian_10": _Kind("measure", _MEASURE, 480, 10),
    "480_clean": _Kind("measure", _MEASURE, 480),
    "poses": _Kind("estimate_state", _ESTIMATE, 480, 10),
    "inputs": _Kind("control", _CONTROL, measure=False),
}


def run_grading_bench(
    *, rounds: int = 25, seconds: float = 0.1, isolation: Isolation = "auto"
) -> GradingBench:
    """Time steps with the robot half in a worker, beside those of one process.

    Parameters
    ----------
    rounds : int
        Number of timings of each way, in turns; the shortest counts.
    seconds : float
        How long a timing takes (s).
    isolation : str
        How the workers are shut in.

    Returns
    -------
    GradingBench
        The times; print it.
    """
    check_int("rounds", rounds, minimum=1, maximum=10**6)
    check_float("seconds", seconds, "s", exclusive_minimum=0)
    steps = {name: _timed(kind, isolation, rounds, seconds) for name, kind in KINDS.items()}
    kind = KINDS["inputs"]
    start, line = math.inf, ""
    for _ in range(min(rounds, 5)):
        begin = time.perf_counter()
        line = graded_run(kind.task(isolation), kind.scenario(), 1, RunSeeds.of(1)).layers
        start = min(start, time.perf_counter() - begin)
    return GradingBench(steps=steps, start=start, isolation=line)


def _timed(kind: _Kind, isolation: Isolation, rounds: int, seconds: float) -> tuple[float, float]:
    """Return the time of a step (s) in one process and with a worker: the shortest of each."""
    task, scenario, seeds = kind.task(isolation), kind.scenario(), RunSeeds.of(1)
    with all_here(task, scenario, seeds) as here, started(task, scenario, seeds) as worker:
        there = asking(worker, task, scenario, seeds)
        _run(here, _WARM_UP)
        n_steps = math.ceil(seconds / max(_run(there, _WARM_UP), 1e-6))
        best = [math.inf, math.inf]
        for _ in range(rounds):
            for i, simulation in enumerate((here, there)):
                best[i] = min(best[i], _run(simulation, n_steps))
    return best[0], best[1]


def _run(simulation: Simulation, steps: int) -> float:
    """Return the time of a step (s)."""
    begin = time.perf_counter()
    simulation.run(steps)
    return (time.perf_counter() - begin) / steps
