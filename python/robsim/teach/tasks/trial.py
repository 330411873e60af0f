"""`TaskTrial`: the quality of a task's solution, compared with the reference."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from os import PathLike
from typing import TYPE_CHECKING, Any

import numpy as np

from robsim.base.checks import check_bool, check_float, check_int
from robsim.base.report import Column, Quantity, Report, Row, Table, count, percent
from robsim.base.spelling import check_names
from robsim.base.text import quoted
from robsim.campaigns import CampaignResult, CampaignSpec
from robsim.campaigns.choices import FOLDER, Choice, choice_of
from robsim.campaigns.launch import run_spec
from robsim.campaigns.runs import CaseRuns
from robsim.teach.submissions.at_home import quiet, why_files_refused, why_notebook_refused
from robsim.teach.submissions.rules import Rules
from robsim.teach.tasks.definition import MOST_RUNS, Task, check_task, solution_folder
from robsim.teach.tasks.marks.calibration import shipped_calibrations, task_digest
from robsim.teach.tasks.marks.sets import METRIC, numbers_in, points_of
from robsim.teach.tasks.score import Score, ScoreLimit
from robsim.teach.tasks.solutions import MODULE, REFERENCE, Solution, module_source
from robsim.trace import Trace

if TYPE_CHECKING:
    from matplotlib.figure import Figure
_MOST_SHOWN = 3  # failures, in words
_NEARLY, _SOME = 0.8, 0.1  # of the points; a naive solution has some by chance


@dataclass(frozen=True, kw_only=True)
class TaskTrial(Report):
    """The quality of a task's solution relative to the reference: the result of `try_solution`.

    Attributes
    ----------
    task : Task
        The task.
    solution : str
        The name of the solution.
    seed : int
        The seed from which the seeds of the runs are derived.
    values, reference : mapping of str to tuple of float
        The numbers of the solution's and the reference's runs, by score name. NaN = no number, for
        example because the solution's run failed.
    limits : mapping of str to ScoreLimit
        The limits of all points by score name; empty = unknown.
    failed : mapping of int to str
        The errors of failed runs, by run number.
    broken : tuple of int
        The numbers of the runs that have broken a rule of the task; these have no scores.
    rule : str or None
        The violation in the first of them.
    worst : int or None
        The number of the worst completed run; None = all failed.
    trace, reference_trace : Trace or None
        The traces of the worst run, from the solution and the reference.
    has_own_limits : bool
        Whether the limits belong to this very task; else to a task with default parameters.

    Examples
    --------
    >>> park = robsim.teach.ParkTask()
    >>> trial = robsim.teach.try_solution(park, control=lambda: robsim.Spin(), runs=2)
    >>> trial.is_solved, sorted(trial.values)
    (False, ['distance', 'heading', 'overshoot', 'settling'])
    """

    task: Task
    solution: str
    seed: int
    values: Mapping[str, tuple[float, ...]]
    reference: Mapping[str, tuple[float, ...]]
    limits: Mapping[str, ScoreLimit]
    failed: Mapping[int, str]
    broken: tuple[int, ...]
    rule: str | None
    worst: int | None
    trace: Trace | None = field(repr=False, compare=False)
    reference_trace: Trace | None = field(repr=False, compare=False)
    has_own_limits: bool = True

    @property
    def runs(self) -> int:
        """The number of runs."""
        return len(next(iter(self.reference.values())))

    @property
    def statistics(self) -> dict[str, float]:
        """The statistic of each score, see `Score.statistic`; NaN = all runs failed."""
        return {score.name: self._statistic(score) for score in self.task.scores}

    def _statistic(self, score: Score) -> float:
        own, others = self._through(score), self._through(score, self.reference)
        return score.statistic(own, others) if own else math.nan

    def _through(
        self, score: Score, of: Mapping[str, tuple[float, ...]] | None = None
    ) -> list[float]:
        numbers = (self.values if of is None else of)[score.name]
        return [value for run, value in enumerate(numbers) if run not in self.failed]

    @property
    def points(self) -> float:
        """The part of the points, 0..1; NaN = unknown."""
        if not self.limits:
            return math.nan
        through = 1 - len(self.failed) / self.runs
        return points_of(self.task.scores, self.limits, tuple(self.statistics.values()), through)

    @property
    def is_solved(self) -> bool:
        """Whether the solution has full points; False also if the points are unknown."""
        return self.points > 1 - 1e-9

    @property
    def title(self) -> str:
        """The name of the task and the solution."""
        return f"Task {self.task.name}, {self.solution}"

    @property
    def verdict(self) -> str | None:
        """Return ``"as good as the reference"``, ``"nearly as good ..."``, or a worse verdict."""
        if len(self.failed) == self.runs:
            return "fails"
        if not self.limits:
            return None
        if self.is_solved:
            return "as good as the reference"
        if self.points >= _NEARLY:
            return "nearly as good as the reference"
        is_better = self.points > _SOME
        return "better than a naive solution" if is_better else "no better than a naive solution"

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """Points, runs, and the number of failed runs."""
        return (
            Quantity("points", "points", self.points, format=percent, missing="not known"),
            Quantity("runs", "runs", self.runs),
            Quantity("failed", "failed", len(self.failed)),
        )

    @property
    def tables(self) -> tuple[Table, ...]:
        """The scores: medians, statistics, and the limits."""
        columns = [
            Column("own", "yours"),
            Column("reference", "reference"),
            Column("statistic", "comes to", "", ".3g"),
            *([Column("full", "all points"), Column("zero", "none")] if self.limits else []),
        ]
        return (Table(key="scores", columns=columns, rows=self._rows()),)

    def _rows(self) -> list[Row]:
        rows = []
        for score in self.task.scores:
            medians = (_median(self._through(score)), _median(self.reference[score.name]))
            limits = _in_words(self.limits[score.name]) if self.limits else ()
            values = (*medians, self.statistics[score.name], *limits)
            rows.append(Row(score.title, values, score.unit))
        return rows

    @property
    def remarks(self) -> tuple[str, ...]:
        """Notes on the numbers, the failed runs and the limits."""
        return tuple(self._remarks())

    def _remarks(self) -> Iterator[str]:
        for run, sentence in list(self.failed.items())[:_MOST_SHOWN]:
            yield f"run {run} failed: {sentence}"
        if len(self.failed) > _MOST_SHOWN:
            yield f"{len(self.failed) - _MOST_SHOWN} more failed"
        if self.broken:
            runs = count(len(self.broken), self.runs)
            yield f"runs against the rules: {runs}; in run {self.broken[0]}, {self.rule}"
        yield (
            "yours and the reference's are medians of the runs; the result is the ratio of yours "
            "to the reference's, as the geometric mean over the runs"
        )
        for score in self.task.scores:
            if without := sum(map(math.isnan, self._through(score))):
                runs = count(without, self.runs)
                yield f"runs without {score.title}, which count as the worst: {runs}"
        if any(score.kind == "consistency" for score in self.task.scores):
            yield "the result of a consistency, ideally 1, is the geometric mean of yours alone"
        if self.worst is not None:
            yield f"the worst run is number {self.worst}"
        if self.limits and not self.has_own_limits:
            yield "the limits belong to the task with its default parameters"
        if self.limits and self.runs < self.task.runs:
            yield (
                f"the limits are for {self.task.runs} runs: with fewer runs, the result depends "
                "more on chance"
            )

    def figure(self) -> Figure:
        """Draw the worst run next to the reference's run.

        Returns
        -------
        matplotlib.figure.Figure
            The figure, from `Task.figure`.

        Raises
        ------
        ValueError
            If all runs failed.
        """
        if self.trace is None:
            raise ValueError("no run to draw: all runs have failed")
        return self.task.figure(self.trace, self.reference_trace)


def _median(values: Sequence[float]) -> float:
    """Return the median, with NaN as the largest value; NaN = such a value is the median."""
    median = np.median([math.inf if math.isnan(value) else value for value in values or [math.nan]])
    return float(median) if median < math.inf else math.nan


def _in_words(limit: ScoreLimit) -> tuple[str, str]:
    if limit.low is None or limit.low_zero is None:
        return f"up to {limit.full:.3g}", f"from {limit.zero:.3g}"
    full = f"{limit.low:.3g} to {limit.full:.3g}"
    return full, f"below {limit.low_zero:.3g}, from {limit.zero:.3g}"


_LABEL = "own"


@dataclass(frozen=True)
class _Metric:
    """The numbers of a run by name, and whether it has broken a rule."""

    task: Task

    def __call__(self, trace: Trace) -> dict[str, float]:
        return self.task.score(trace) | {"broken": self.task.broken_rule(trace) is not None}


#: The default seed of trials: all users have the same runs.
PUBLIC_SEED = 1


def try_solution(
    task: Task,
    solution: str | PathLike[str] | Solution | None = None,
    *,
    runs: int | None = None,
    seed: int = PUBLIC_SEED,
    time_limit: float | None = None,
    progress: bool = True,
    **callbacks: Any,
) -> TaskTrial:
    """Try a solution of a task in this process, with the reference in the same runs.

    Parameters
    ----------
    task : Task
        The task.
    solution : path or Solution, optional
        A folder with a file for each slot, one such file, or a notebook; each call reads it
        again. The solution can import the values of the task from the module ``task``.
    runs : int, optional
        Number of runs, 1..1000. Default: `runs` of the task.
    seed : int
        The seed of all runs; the default is the same for all users.
    time_limit : float, optional
        Maximum duration of a call of a callback (s); a run that exceeds it fails.
    progress : bool
        Show a progress bar in a terminal or a notebook.
    **callbacks
        Instead of `solution` the callbacks by slot, such as ``control=my_controller``: a function
        of the step, or a maker of the callback (a class or function without arguments), which
        each run calls again.

    Returns
    -------
    TaskTrial
        The scores, the reference's scores, and their statistics; ``figure()`` draws the worst run.

    Raises
    ------
    TypeError, ValueError, OSError
        If an argument is wrong, or a file cannot be read; the message names it.
    Exception
        Any exception that a file of the solution raises while loading. Exceptions in a run are
        part of the result.

    Examples
    --------
    >>> park = robsim.teach.ParkTask()
    >>> make = lambda: robsim.GoToPoint(600, 300)
    >>> robsim.teach.try_solution(park, control=make, runs=2).is_solved
    False
    """
    check_task(task)
    if runs is None:
        runs = task.runs
    check_int("runs", runs, minimum=1, maximum=MOST_RUNS)
    check_int("seed", seed, minimum=0, maximum=2**64)
    check_bool("progress", progress)
    if time_limit is not None:
        check_float("time_limit", time_limit, "s", exclusive_minimum=0)
    name, choices = _choices(task, solution, callbacks)
    result = _runs_of(task, choices, runs, seed, time_limit=time_limit, progress=progress)
    reference = _reference(task, runs, seed)
    failed = {
        run: error if line is None else f"{error} ({line})"
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


def why_not_own(task: Task, solution: Solution) -> str:
    """Return the reason for which grading would refuse a solution; "" = accepted."""
    rules = Rules(slots=task.slots, masked=task.masked)
    if solution.notebook is not None:
        sources = {**solution.notebook.sources, f"{MODULE}.py": module_source(task)}
        return why_notebook_refused(replace(solution.notebook, sources=sources), rules)
    return why_files_refused(solution.files, solution_folder(task, solution).callbacks(), rules)


def _choices(
    task: Task, solution: str | PathLike[str] | Solution | None, callbacks: Mapping[str, Any]
) -> tuple[str, dict[str, Choice]]:
    if (solution is None) == (not callbacks):
        example = f"{task.slots[0]}=my_{task.slots[0]}"
        raise TypeError(
            f"give either a solution (a folder, file or notebook), or callbacks by name: {example}"
        )
    check_names(f"the task {task.name} has no slot", callbacks, task.slots, TypeError)
    if solution is None:
        names = [getattr(value, "__name__", slot) for slot, value in callbacks.items()]
        choices = {slot: choice_of(slot, value, "") for slot, value in callbacks.items()}
        return ", ".join(names), choices
    if not isinstance(solution, Solution):
        if not isinstance(solution, (str, PathLike)):
            raise TypeError(
                f"solution must be the path of a folder, file or notebook, got {quoted(solution)}: "
                f"give callbacks by name, such as {task.slots[0]}=..."
            )
        solution = Solution.load(solution, task.slots, is_right=False)
        if reason := why_not_own(task, solution):
            raise ValueError(reason)
        return solution.name, {FOLDER: solution_folder(task, solution)}
    folder = solution_folder(task, solution)
    with quiet(), folder.callbacks():  # which raises what its files raise
        pass
    return solution.name, {FOLDER: folder}


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
        metrics={METRIC: _Metric(task)},
        runs=runs,
        steps=task.steps,
        seed=seed,
        time_limit=time_limit,
        given=task.given,
    )
    return run_spec(spec, executor=None, store=None, progress=progress)


@lru_cache(maxsize=16)
def _reference(task: Task, runs: int, seed: int) -> CampaignResult:
    """Return the runs of the reference, which other trials share."""
    own = next(one for one in task.solutions if one.name == REFERENCE)
    choices = {FOLDER: solution_folder(task, own)}
    result = _runs_of(task, choices, runs, seed, time_limit=None, progress=False)
    if any(error is not None for error in result["error"]):
        raise RuntimeError(f"the reference of the task {task.name} fails: {result['error'][0]}")
    return result


def _numbers(task: Task, result: CampaignResult) -> dict[str, tuple[float, ...]]:
    columns = numbers_in(result, task).T.tolist()
    return {score.name: tuple(one) for score, one in zip(task.scores, columns, strict=True)}


def _broken(result: CampaignResult) -> tuple[int, ...]:
    column = f"{METRIC}_broken"  # missing if all runs failed
    is_broken = result[column] if column in result.columns else np.zeros(0)
    return tuple(np.flatnonzero(np.nan_to_num(is_broken)).tolist())


def _trace(result: CampaignResult, run: int) -> Trace:
    (case,) = result.spec.cases
    with quiet():
        return CaseRuns(result.spec, case).trace(run)


def _worst(
    task: Task,
    values: Mapping[str, tuple[float, ...]],
    reference: Mapping[str, tuple[float, ...]],
    failed: Mapping[int, str],
) -> int | None:
    runs = [run for run in range(len(next(iter(values.values())))) if run not in failed]

    def loss(run: int) -> float:
        logs = 0.0
        for score in task.scores:
            log = math.log(score.statistic([values[score.name][run]], [reference[score.name][run]]))
            logs += (score.share or 1.0) * (abs(log) if score.kind == "consistency" else log)
        return logs

    return max(runs, key=loss, default=None)


def _limits(task: Task) -> tuple[Mapping[str, ScoreLimit], bool]:
    """Return the limits of the task's kind in robsim, and whether they fit its parameters."""
    shipped = shipped_calibrations().get(task.name)
    if shipped is None:
        return {}, False
    return shipped.limits, shipped.task_digest == task_digest(task)


def reference_run(task: Task, seed: np.random.SeedSequence) -> Trace:
    """Return the run of the reference in the world of a seed."""
    own = next(one for one in task.solutions if one.name == REFERENCE)
    with quiet(), solution_folder(task, own).callbacks() as callbacks:
        return task.simulation(seed=seed, **callbacks).run(task.steps)


def trial_of(task: Task, trace: Trace, reference: Trace) -> TaskTrial:
    """Return the trial of one run, or of its start, compared with the reference in its world."""
    own, other = task.score(trace), task.score(reference)
    limits, are_own = _limits(task)
    rule = task.broken_rule(trace)
    return TaskTrial(
        task=task,
        solution="run",
        seed=0,
        values={score.name: (own[score.name],) for score in task.scores},
        reference={score.name: (other[score.name],) for score in task.scores},
        limits=limits,
        failed={},
        broken=() if rule is None else (0,),
        rule=rule,
        worst=0,
        trace=trace,
        reference_trace=reference,
        has_own_limits=are_own,
    )


def stars_of(trial: TaskTrial) -> int:
    """Return 3 stars for all points, 2 for nearly all, 1 for more than chance gives."""
    return trial.is_solved + (trial.points >= _NEARLY) + (trial.points > _SOME)
