"""`calibrate_task`: limits of a task from runs of right solutions."""

from __future__ import annotations

import time
from collections.abc import Iterable, Sequence
from concurrent.futures import Executor
from functools import partial
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from robsim.base.checks import check_bool, check_float, check_int, check_kinds
from robsim.base.files import as_path
from robsim.base.files.codec import plain
from robsim.base.text import listed, quoted
from robsim.campaigns.engines.engine import engine_value
from robsim.campaigns.engines.executors import DaskClient
from robsim.campaigns.spec import surroundings
from robsim.teach.tasks.definition import Task, check_task
from robsim.teach.tasks.marks.calibration import (
    SolutionMarks,
    TaskCalibration,
    solutions_digest,
    task_digest,
)
from robsim.teach.tasks.marks.limits import bound_rank, fewest_values, limits_from
from robsim.teach.tasks.marks.sets import Sets, runs_of, sets_of
from robsim.teach.tasks.score import ScoreLimit
from robsim.teach.tasks.solutions import NAIVE, REFERENCE, Solution

#: Tests from which the shape of the limits comes, and tests of each wrong solution.
PILOT_TESTS, WRONG_TESTS = 60, 60


def calibrate_task(
    task: Task,
    solutions: Iterable[Solution] | None = None,
    *,
    false_fail: float = 0.01,
    confidence: float = 0.95,
    tests: int | None = None,
    seed: int = 0,
    executor: int | str | Executor | DaskClient | None = None,
    store: str | PathLike[str] | None = None,
    progress: bool = True,
) -> TaskCalibration:
    """Return limits for a task that a right solution hardly ever misses, from runs of right ones.

    Parameters
    ----------
    task : Task
        The task.
    solutions : iterable of Solution, optional
        Right ones, the first of them the reference, one at least of another kind; and wrong ones,
        among them ``naive``. Default: those that ship with robsim.
    false_fail : float
        The probability with which a solution as right as these has less than full points in a
        test, all its scores together, at most.
    confidence : float
        The probability that it is not more often.
    tests : int, optional
        Number of tests of each right solution; more make narrower limits. Default: the fewest
        that it takes: 299 for 1 %.
    seed : int
        What all seeds of the runs come from: no student should know it.
    executor : int, "threads", concurrent.futures.Executor or Dask Client, optional
        What runs, as for `robsim.campaign`.
    store : path, optional
        Folder for the runs: the same call goes on where one was ended.
    progress : bool
        Show progress bars.

    Returns
    -------
    TaskCalibration
        The limits, and what each solution comes to by them.

    Raises
    ------
    TypeError, ValueError
        If an argument has the wrong type or is out of range; if a run of a right solution fails.

    Notes
    -----
    A test is M runs, as many as the task has. See `limits_from` for how limits come from tests.
    They are tolerance bounds, which hold whatever the distribution of the scores is: `bound_rank`.
    """
    chosen = _chosen(task, solutions)
    count, rank = _count_and_rank(false_fail, confidence, tests)
    check_int("seed", seed, minimum=0, maximum=2**128 - 1)
    check_bool("progress", progress)
    engine_value(executor)
    folder = None if store is None else as_path(store, "store")

    right = [one for one in chosen if one.is_right]
    wrong = [one for one in chosen if not one.is_right]
    play = partial(runs_of, task, seed=seed, executor=executor, progress=progress)
    runs = play(right, PILOT_TESTS + count, store=_file(folder, "right"))
    for name, one in runs.items():
        if one.failed.any():
            raise ValueError(
                f"the right solution {quoted(name)} must not fail, but so it did: {one.first_error}"
            )
    runs |= play(wrong, WRONG_TESTS, store=_file(folder, "wrong"))
    reference = runs[REFERENCE]
    known = reference.first(WRONG_TESTS * task.runs)
    sets = {one.name: sets_of(task, runs[one.name], reference) for one in right}
    wrong_sets = {one.name: sets_of(task, runs[one.name], known) for one in wrong}
    limits = limits_from(task, list(sets.values()), list(wrong_sets.values()), PILOT_TESTS, rank)
    begin = PILOT_TESTS
    after = {name: Sets(one.statistics[begin:], one.through[begin:]) for name, one in sets.items()}
    return TaskCalibration(
        task=task.name,
        parameters={name: plain(value) for name, value in task.parameters.items()},
        limits=limits,
        false_fail=false_fail,
        confidence=confidence,
        tests=count,
        pilot_tests=PILOT_TESTS,
        rank=rank,
        seed=seed,
        task_digest=task_digest(task),
        solutions_digest=solutions_digest(chosen),
        versions=surroundings(),
        solutions=tuple(
            marks_of(task, one, (after if one.is_right else wrong_sets)[one.name], limits)
            for one in chosen
        ),
    )


def _count_and_rank(false_fail: float, confidence: float, tests: int | None) -> tuple[int, int]:
    """Return the number of tests of each right solution, and the rank of the bound in them."""
    check_float("false_fail", false_fail, minimum=1e-4, maximum=0.5)
    check_float("confidence", confidence, minimum=0.5, maximum=0.9999)
    fewest = fewest_values(false_fail, confidence)
    count = fewest if tests is None else check_int("tests", tests, minimum=fewest, maximum=10**6)
    return count, bound_rank(count, false_fail, confidence)


def _chosen(task: Any, solutions: Any) -> tuple[Solution, ...]:
    check_task(task)
    chosen = check_kinds("solutions", task.solutions if solutions is None else solutions, Solution)
    for one in chosen:
        if not one.files.keys() & set(task.slots):
            raise ValueError(
                f"solutions must fill {' or '.join(task.slots)}, but {quoted(one.name)} has "
                f"{listed(one.files)}"
            )
    check_solutions(chosen)
    return chosen


def check_solutions(chosen: Sequence[Solution]) -> None:
    right = [one.name for one in chosen if one.is_right]
    if len(right) < 2 or right[0] != REFERENCE:
        raise ValueError(
            f"solutions must have right ones: first {REFERENCE!r}, and another that is as good but "
            f"made otherwise, since nobody is as good as a reference on its own runs; "
            f"got {quoted(right)}"
        )
    wrong = [one.name for one in chosen if not one.is_right]
    if NAIVE not in wrong:
        raise ValueError(
            f"solutions must have a wrong one {NAIVE!r}, which has no points; got {quoted(wrong)}"
        )


def _file(folder: Path | None, name: str) -> Path | None:
    if folder is None:
        return None
    folder.mkdir(parents=True, exist_ok=True)
    return folder / f"{name}.sqlite"


def marks_of(
    task: Task, solution: Solution, sets: Sets, limits: dict[str, ScoreLimit]
) -> SolutionMarks:
    points = sets.points(task.scores, limits)
    known = sets.through > 0
    medians = np.median(sets.statistics[known], axis=0) if known.any() else None
    return SolutionMarks(
        name=solution.name,
        is_right=solution.is_right,
        tests=len(points),
        failing=int(np.count_nonzero(points < 1 - 1e-9)),
        points=float(np.median(points)),
        statistics={
            score.name: None if medians is None else float(medians[index])
            for index, score in enumerate(task.scores)
        },
    )


def calibration_seconds(
    task: Task,
    solutions: Iterable[Solution] | None = None,
    *,
    false_fail: float = 0.01,
    confidence: float = 0.95,
    tests: int | None = None,
    processes: int = 1,
) -> float:
    """Return the estimated duration of `calibrate_task` (s), from a test of each solution."""
    chosen = _chosen(task, solutions)
    count, _ = _count_and_rank(false_fail, confidence, tests)
    check_int("processes", processes, minimum=1, maximum=10**4)
    seconds = 0.0
    for one in chosen:
        begin = time.perf_counter()
        runs_of(task, [one], 1, seed=0)
        tests_of_it = PILOT_TESTS + count if one.is_right else WRONG_TESTS
        seconds += tests_of_it * (time.perf_counter() - begin)
    return seconds / processes
