"""Statistics of many repeated tests: sets of M runs, as in the grading of a submission."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from robsim.base.checks import Floats
from robsim.campaigns import CampaignResult, CampaignSpec
from robsim.campaigns.engines.executors import DaskClient
from robsim.campaigns.launch import run_spec
from robsim.campaigns.runs import Row
from robsim.teach.tasks.definition import Task, solution_folder
from robsim.teach.tasks.score import Score, ScoreLimit, share_of_points
from robsim.teach.tasks.solutions import Solution

#: The name of the numbers in a campaign.
METRIC = "task"


@dataclass(frozen=True)
class Runs:
    """The runs of a solution."""

    values: Floats  # (N, S): the numbers of each run, by the scores of its task
    failed: NDArray[np.bool_]  # (N,): the runs that failed
    first_error: str = ""  # of the first failed run
    seconds: float = 0.0  # of a run, on average

    def first(self, count: int) -> Runs:
        return replace(self, values=self.values[:count], failed=self.failed[:count])


def runs_of(
    task: Task,
    solutions: Sequence[Solution],
    tests: int,
    *,
    seed: int,
    executor: int | str | Executor | DaskClient | None = None,
    store: Path | None = None,
    progress: bool = False,
    known: Mapping[str, Runs] = MappingProxyType({}),
) -> dict[str, Runs]:
    """Run solutions of a task, all in the same runs, and return the runs of each by its name.

    Each test has the task's number of runs. Known runs are not repeated. `robsim.campaign`
    documents the other arguments.
    """
    folders = {one.name: replace(solution_folder(task, one), warns=False) for one in solutions}
    spec = CampaignSpec(
        scenario=task.scenario,
        vary={"folder": folders},
        metrics={METRIC: task.score},
        runs=tests * task.runs,
        steps=task.steps,
        seed=seed,
    )
    rows = [
        row
        for case, one in enumerate(solutions)
        if one.name in known
        for row in _rows_of(task, case, known[one.name])
    ]
    result = run_spec(spec, executor=executor, store=store, progress=progress, known=rows)
    return {one.name: _runs_in(result, task, one.name) for one in solutions}


def _rows_of(task: Task, case: int, runs: Runs) -> Iterator[Row]:
    names = [f"{METRIC}_{score.name}" for score in task.scores]
    for run, values in enumerate(runs.values.tolist()):
        error = runs.first_error if runs.failed[run] else None
        yield Row(case, run, error, None, runs.seconds, dict(zip(names, values, strict=True)))


def _runs_in(result: CampaignResult, task: Task, solution: str) -> Runs:
    is_own = result["folder"] == solution
    errors = result["error"][is_own]
    failed = np.array([error is not None for error in errors])
    first = f"run {failed.argmax()}: {errors[failed][0]}" if failed.any() else ""
    seconds = float(np.mean(result["seconds"][is_own]))
    return Runs(numbers_in(result, task)[is_own], failed, first, seconds)


def numbers_in(result: CampaignResult, task: Task) -> Floats:
    """Return the numbers of runs (N, S), by the scores of their task."""
    missing = np.full(len(result["error"]), np.nan)  # for a missing column, if all runs failed
    names = (f"{METRIC}_{score.name}" for score in task.scores)
    return np.stack([result[n] if n in result.columns else missing for n in names], axis=1)


@dataclass(frozen=True)
class Sets:
    """Tests, each of M runs."""

    statistics: Floats  # (N, S): of each score of a test; NaN = all runs failed
    through: Floats  # (N,): the share of its completed runs

    def __getitem__(self, place: slice) -> Sets:
        return Sets(self.statistics[place], self.through[place])

    def points(self, scores: Sequence[Score], limits: Mapping[str, ScoreLimit]) -> Floats:
        return np.array(
            [
                points_of(scores, limits, row, through)
                for row, through in zip(self.statistics, self.through, strict=True)
            ]
        )


def points_of(
    scores: Sequence[Score],
    limits: Mapping[str, ScoreLimit],
    statistics: Sequence[float] | Floats,
    through: float,
) -> float:
    """Return the share of a test's points, 0..1; `through` is the share of completed runs."""
    fractions = [
        0.0 if math.isnan(statistic) else limits[score.name].fraction(statistic)
        for score, statistic in zip(scores, statistics, strict=True)
    ]
    parts = share_of_points(scores, fractions)
    return through * math.fsum(s.share * part for s, part in zip(scores, parts, strict=True))


def sets_of(task: Task, own: Runs, reference: Runs) -> Sets:
    size = task.runs
    places = [slice(i, i + size) for i in range(0, len(own.failed) - size + 1, size)]
    statistics = [_statistics(task, own, reference, place) for place in places]
    through = [1 - float(np.mean(own.failed[place])) for place in places]
    return Sets(np.array(statistics), np.array(through))


def with_drawn(task: Task, own: Runs, reference: Runs, count: int, seed: int) -> Sets:
    """Return the tests of completed runs, and more tests whose runs are drawn from these."""
    done = sets_of(task, own, reference)
    runs = np.random.default_rng(seed).integers(len(own.failed), size=(count, task.runs))
    numbers = zip(task.scores, own.values.T, reference.values.T, strict=True)
    drawn = [score._of_tests(one[runs], other[runs]) for score, one, other in numbers]
    statistics = np.concatenate([done.statistics, np.stack(drawn, axis=1)])
    return Sets(statistics, np.ones(len(statistics)))


def _statistics(task: Task, own: Runs, reference: Runs, place: slice) -> list[float]:
    came_through = ~own.failed[place]
    if not came_through.any():
        return [math.nan] * len(task.scores)
    values, others = own.values[place][came_through], reference.values[place][came_through]
    return [
        score.statistic(values[:, index].tolist(), others[:, index].tolist())
        for index, score in enumerate(task.scores)
    ]
