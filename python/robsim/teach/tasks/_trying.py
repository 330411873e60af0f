"""A trial of a solution: its runs, and those of the reference beside them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from os import PathLike
from typing import Any

import numpy as np

from robsim.base.checks import check_bool, check_float
from robsim.base.spelling import check_names
from robsim.base.text import quoted
from robsim.campaigns import CampaignResult, CampaignSpec
from robsim.campaigns.choices import FOLDER, Choice, choice_of
from robsim.campaigns.launch import run_spec
from robsim.campaigns.runs import CaseRuns
from robsim.teach.tasks.definition import Task
from robsim.teach.tasks.limit import Limit
from robsim.teach.tasks.marks.calibration import task_digest
from robsim.teach.tasks.marks.files import shipped_calibrations
from robsim.teach.tasks.solutions import REFERENCE, Solution
from robsim.teach.tasks.trial import TaskTrial
from robsim.trace import Trace

_LABEL, _METRIC = "own", "task"


@dataclass(frozen=True)
class _Metric:
    """The numbers of a run by name, and whether it has broken a rule."""

    task: Task

    def __call__(self, trace: Trace) -> dict[str, float]:
        return self.task.score(trace) | {"broken": self.task.broken_rule(trace) is not None}


def trial(
    task: Task,
    solution: str | PathLike[str] | Solution | None,
    callbacks: Mapping[str, Any],
    *,
    runs: int,
    seed: int,
    time_limit: float | None,
    progress: bool,
) -> TaskTrial:
    """Return the trial of a solution; the arguments are those of `Task.try_out`."""
    check_bool("progress", progress)
    if time_limit is not None:
        check_float("time_limit", time_limit, "s", exclusive_minimum=0)
    name, choices = _choices(task, solution, callbacks)
    result = _runs_of(task, choices, runs, seed, time_limit=time_limit, progress=progress)
    reference = _reference(task, runs, seed)
    failed = {
        run: _failure(error, line)
        for run, (error, line) in enumerate(zip(result["error"], result["line"], strict=True))
        if error is not None
    }
    values, others = _numbers(task, result), _numbers(task, reference)
    worst = _worst(task, values, others, failed)
    broken = _broken(result)
    limits, are_own = _limits(task)
    return TaskTrial(
        task=task,
        solution=name,
        seed=seed,
        values=values,
        reference=others,
        limits=limits,
        failed=failed,
        broken=broken,
        rule=task.broken_rule(_trace(result, broken[0])) if broken else None,
        worst=worst,
        trace=None if worst is None else _trace(result, worst),
        reference_trace=None if worst is None else _trace(reference, worst),
        has_own_limits=are_own,
    )


def _choices(
    task: Task, solution: str | PathLike[str] | Solution | None, callbacks: Mapping[str, Any]
) -> tuple[str, dict[str, Choice]]:
    """Return what is tried: its name, and what it fills slots with."""
    if (solution is None) == (not callbacks):
        example = f"{task.slots[0]}=my_{task.slots[0]}"
        raise TypeError(f"give a solution, a folder or a file, or callbacks by name: {example}")
    check_names(f"the task {task.name} has no slot", callbacks, task.slots, TypeError)
    if solution is None:
        names = [getattr(value, "__name__", slot) for slot, value in callbacks.items()]
        return ", ".join(names), {slot: _code(slot, value) for slot, value in callbacks.items()}
    if not isinstance(solution, Solution):
        if not isinstance(solution, (str, PathLike)):
            raise TypeError(
                f"solution must be the path of a folder or a file, got {quoted(solution)}: "
                f"callbacks are given by name, such as {task.slots[0]}=..."
            )
        solution = Solution.read(solution, task.slots, is_right=False)
    folder = solution.choice(task)
    with folder.callbacks():  # which raises what its files raise
        pass
    return solution.name, {FOLDER: folder}


def _code(slot: str, value: Any) -> Choice:
    try:
        return choice_of(slot, value)
    except (TypeError, ValueError) as error:
        raise type(error)(str(error).removeprefix("vary: ")) from None


def _runs_of(
    task: Task,
    choices: Mapping[str, Choice],
    runs: int,
    seed: int,
    *,
    time_limit: float | None,
    progress: bool,
) -> CampaignResult:
    spec = CampaignSpec(
        scenario=task.scenario,
        vary={option: {_LABEL: choice} for option, choice in choices.items()},
        metrics={_METRIC: _Metric(task)},
        runs=runs,
        steps=task.steps,
        seed=seed,
        time_limit=time_limit,
        given=task.given,
    )
    return run_spec(spec, executor=None, store=None, progress=progress)


@lru_cache(maxsize=16)
def _reference(task: Task, runs: int, seed: int) -> CampaignResult:
    """Return the runs of the reference; trials of others have the same."""
    own = next(one for one in task.solutions if one.name == REFERENCE)
    choices = {FOLDER: own.choice(task)}
    result = _runs_of(task, choices, runs, seed, time_limit=None, progress=False)
    if any(error is not None for error in result["error"]):
        raise RuntimeError(f"the reference of the task {task.name} fails: {result['error'][0]}")
    return result


def _numbers(task: Task, result: CampaignResult) -> dict[str, tuple[float, ...]]:
    missing = [math.nan] * len(result["error"])
    return {
        score.name: tuple(map(float, _column(result, score.name, missing))) for score in task.scores
    }


def _column(result: CampaignResult, name: str, missing: list[float]) -> Any:
    """Return a column of the metric, which is not there if all runs failed."""
    column = f"{_METRIC}_{name}"
    return result[column] if column in result.columns else missing


def _failure(error: str, line: str | None) -> str:
    return error if line is None else f"{error} ({line})"


def _broken(result: CampaignResult) -> tuple[int, ...]:
    is_broken = np.nan_to_num(_column(result, "broken", [0.0] * len(result["error"])))
    return tuple(int(run) for run in np.flatnonzero(is_broken))


def _trace(result: CampaignResult, run: int) -> Trace:
    (case,) = result.spec.cases
    return CaseRuns(result.spec, case).trace(run)


def _worst(
    task: Task,
    values: Mapping[str, tuple[float, ...]],
    reference: Mapping[str, tuple[float, ...]],
    failed: Mapping[int, str],
) -> int | None:
    """Return the run that loses most, of those that came through."""
    runs = [run for run in range(len(next(iter(values.values())))) if run not in failed]

    def loss(run: int) -> float:
        logs = 0.0
        for score in task.scores:
            log = math.log(score.statistic([values[score.name][run]], [reference[score.name][run]]))
            logs += score.share * (abs(log) if score.kind == "consistency" else log)
        return logs

    return max(runs, key=loss, default=None)


def _limits(task: Task) -> tuple[Mapping[str, Limit], bool]:
    """Return the limits that ship for its kind, and whether they are for its parameters."""
    shipped = shipped_calibrations().get(task.name)
    if shipped is None:
        return {}, False
    return shipped.limits, shipped.task_digest == task_digest(task)
