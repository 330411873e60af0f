"""`calibrate_task`: limits of a task from runs of right solutions."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
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
    FEW_TESTS,
    SolutionMarks,
    TaskCalibration,
    solutions_digest,
    task_digest,
)
from robsim.teach.tasks.marks.limits import bound_rank, fewest_values, limits_from
from robsim.teach.tasks.marks.sets import Runs, Sets, runs_of, sets_of, with_drawn
from robsim.teach.tasks.score import ScoreLimit
from robsim.teach.tasks.solutions import NAIVE, REFERENCE, Solution

#: Tests that determine the shape of the limits, and tests of each wrong solution.
PILOT_TESTS, WRONG_TESTS = 60, 60
_ALL = 1 - 1e-9
#: Provisional limits: tests of each right solution.
RIGHT_TESTS = 40
#: Provisional limits: stages for wrong solutions. Each has a number of tests, for solutions with
#: more than so much of the points, 0..1, in a test before, or that determine the zero of a score.
#: A wrong solution that passes in a share p of the tests, and has half the points in one of the
#: first three, is given up with the probability (1 - p)^6: 26 % for p = 20 %.
STAGES = ((3, 0.0), (6, 0.5), (40, _ALL))
#: Runs in the tests that are drawn for provisional limits; more would need too much memory.
DRAWN = 300_000


def calibrate_task(
    task: Task,
    solutions: Iterable[Solution] | None = None,
    *,
    false_fail: float = 0.01,
    confidence: float = 0.95,
    tests: int | None = None,
    provisional: bool = False,
    seed: int = 0,
    executor: int | str | Executor | DaskClient | None = None,
    store: str | PathLike[str] | None = None,
    progress: bool = True,
) -> TaskCalibration:
    """Return limits for a task that a right solution hardly ever misses.

    Parameters
    ----------
    task : Task
        The task.
    solutions : iterable of Solution, optional
        Right solutions, first the reference, and at least one of another kind; and wrong
        solutions with ``naive`` among them. Default: robsim's own.
    false_fail : float
        The maximum probability with which a solution as right as these has less than full points
        in a test, all its scores together.
    confidence : float
        The probability that `false_fail` holds.
    tests : int, optional
        Number of tests of each right solution; more tests give narrower limits. Default: the
        minimum, which is 299 for a `false_fail` of 1 %.
    provisional : bool
        Estimate limits from 40 tests of right solutions and a few of wrong ones, in a tenth
        to a quarter of the time.
    seed : int
        The seed from which all seeds of the runs are derived: keep it secret from students.
    executor : int, "threads", concurrent.futures.Executor or Dask Client, optional
        The executor of the runs, as for `robsim.campaign`.
    store : path, optional
        Folder for the runs: the same call continues a cancelled calibration. Exact limits reuse the
        runs of provisional limits.
    progress : bool
        Show progress bars.

    Returns
    -------
    TaskCalibration
        The limits, and the marks of each solution by these limits.

    Raises
    ------
    TypeError, ValueError
        If an argument has the wrong type or is out of range, or if a run of a right solution fails.

    Notes
    -----
    A test has M runs, the number of runs of the task. `limits_from` computes the limits from the
    tests. The limits are tolerance bounds, which are valid for any distribution of the scores; see
    `bound_rank`. Provisional limits are an estimate: their tests are drawn with replacement from a
    few runs. The estimate does not include events that are rarer than these runs.

    Examples
    --------
    >>> task = robsim.teach.MeasureTask(runs=1, steps=2)
    >>> few = [one for one in task.solutions if one.name in ("reference", "centroids", "naive")]
    >>> found = robsim.teach.calibrate_task(task, few, provisional=True, progress=False)
    >>> {one.name: one.points for one in found.solutions}
    {'reference': 1.0, 'centroids': 1.0, 'naive': 0.0}
    """
    chosen = _chosen(task, solutions)
    count, rank = _count_and_rank(false_fail, confidence, tests)
    check_bool("provisional", provisional)
    check_int("seed", seed, minimum=0, maximum=2**128 - 1)
    check_bool("progress", progress)
    engine_value(executor)
    folder = None if store is None else as_path(store, "store")
    known: dict[str, Runs] = {}

    def play(some: Sequence[Solution], tests: int, name: str) -> dict[str, Runs]:
        how: dict[str, Any] = {"seed": seed, "executor": executor, "progress": progress}
        found = runs_of(task, some, tests, store=_file(folder, name), known=known, **how)
        known.update(found)
        return found

    if provisional:
        # median of the largest of n: P(none of n is above the quantile 1 - p) = 1/2, p = log 2 / n
        tests = DRAWN // task.runs
        above = tests * math.log(2) / fewest_values(false_fail, confidence)
        drawn = partial(with_drawn, count=tests, seed=seed)
        sets, limits = _tested(task, chosen, play, RIGHT_TESTS, max(round(above), 1), drawn)
        count, rank, begin, place = RIGHT_TESTS, 0, 0, slice(RIGHT_TESTS)
    else:
        begin, place = PILOT_TESTS, slice(PILOT_TESTS, None)
        sets, limits = _tested(task, chosen, play, begin + count, rank)
    return TaskCalibration(
        task=task.name,
        parameters={name: plain(value) for name, value in task.parameters.items()},
        limits=limits,
        false_fail=false_fail,
        confidence=confidence,
        tests=count,
        pilot_tests=begin,
        rank=rank,
        seed=seed,
        task_digest=task_digest(task),
        solutions_digest=solutions_digest(chosen),
        versions=surroundings(),
        solutions=tuple(
            marks_of(task, one, sets[one.name][place if one.is_right else slice(None)], limits)
            for one in chosen
        ),
        provisional=FEW_TESTS if provisional else "",
    )


def _tested(
    task: Task,
    chosen: Sequence[Solution],
    play: Callable[[Sequence[Solution], int, str], dict[str, Runs]],
    tests: int,
    rank: int,
    drawn: Callable[[Task, Runs, Runs], Sets] | None = None,
) -> tuple[dict[str, Sets], dict[str, ScoreLimit]]:
    """Return the tests of each solution, and the limits; `drawn` tests = provisional limits."""
    right = play([one for one in chosen if one.is_right], tests, "right")
    for name, runs in right.items():
        if runs.failed.any():
            raise ValueError(
                f"the right solution {quoted(name)} must not fail, but it did: {runs.first_error}"
            )
    of_right, pilot = (sets_of, PILOT_TESTS) if drawn is None else (drawn, tests)
    sets = {name: of_right(task, runs, right[REFERENCE]) for name, runs in right.items()}
    wrong = [one for one in chosen if not one.is_right]

    def limits_after(some: Sequence[Solution], tests: int, name: str) -> dict[str, ScoreLimit]:
        for one, runs in play(some, tests, name).items():
            sets[one] = sets_of(task, runs, right[REFERENCE])
        those = ([sets[one] for one in right], [sets[one.name] for one in wrong])
        return limits_from(task, *those, pilot, rank)

    if drawn is None:
        return sets, limits_after(wrong, WRONG_TESTS, "wrong")
    limits = limits_after(wrong, STAGES[0][0], "wrong")
    for tests, least in STAGES[1:]:
        some = [one for one in wrong if is_needed(task, sets[one.name], limits, least)]
        limits = limits_after(some, tests, f"wrong_{tests}") if some else limits
    return sets, limits


def is_needed(task: Task, sets: Sets, limits: Mapping[str, ScoreLimit], least: float) -> bool:
    """Whether a wrong solution has more points in a test, or determines the zero of a score."""
    if not sets.through.any():
        return False
    medians = np.nanmedian(sets.statistics, axis=0)
    ends = [[limits[s.name].zero, limits[s.name].low_zero or np.nan] for s in task.scores]
    sets_end = np.isclose(medians[:, None], ends).any()
    return bool(sets_end) or sets.points(task.scores, limits).max() > least


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
            f"solutions must have the right solution {REFERENCE!r} first, and another right "
            "solution of equal quality but different design, got "
            f"{quoted(right)}; the reference alone is not enough, because it fits its own runs best"
        )
    wrong = [one.name for one in chosen if not one.is_right]
    if NAIVE not in wrong:
        raise ValueError(
            f"solutions must include {NAIVE!r}, a wrong solution that gets no points, got "
            f"{quoted(wrong)}"
        )


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
        failing=int(np.count_nonzero(points < _ALL)),
        points=float(np.median(points)),
        statistics={
            score.name: None if medians is None else float(medians[index])
            for index, score in enumerate(task.scores)
        },
    )


def calibration_seconds(
    task: Task,
    solutions: Iterable[Solution],
    processes: int,
    *,
    false_fail: float,
    confidence: float,
    provisional: bool,
    seed: int,
    store: Path | None = None,
) -> float:
    """Return the estimated duration of `calibrate_task` (s), from its first test, which is kept."""
    chosen = _chosen(task, solutions)
    count, _ = _count_and_rank(false_fail, confidence, None)
    check_int("processes", processes, minimum=1, maximum=10**4)
    right = [one for one in chosen if one.is_right]
    first = runs_of(task, right, 1, seed=seed, store=_file(store, "right"))
    wrong = len(chosen) - len(right)
    tests = (PILOT_TESTS + count) * len(right) + WRONG_TESTS * wrong
    if provisional:
        (few, _), *_, (most, _) = STAGES
        more = (most - few) * len(task.scores) / 2  # at the zeros of the scores
        tests = RIGHT_TESTS * len(right) + few * wrong + round(more)
    seconds = float(np.mean([runs.seconds for runs in first.values()]))
    return seconds * tests * task.runs / processes


def _file(folder: Path | None, name: str) -> Path | None:
    if folder is not None:
        folder.mkdir(parents=True, exist_ok=True)
    return folder and folder / f"{name}.sqlite"
