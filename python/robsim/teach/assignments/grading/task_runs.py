"""A test by a task: the runs of a submission beside those of the reference."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, field, replace

from robsim.teach.assignments.assignment import Assignment, TaskTest
from robsim.teach.assignments.grading.marking import marked, runs_by_badness
from robsim.teach.assignments.grading.references import References, numbers_of, seeds_of
from robsim.teach.assignments.results import FAILED, NOT_RUN, FailedRun, ScoreResult, TestResult
from robsim.teach.errors import SubmissionError
from robsim.teach.grading.graded_run import graded_run
from robsim.teach.grading.task import Task as GradedTask
from robsim.teach.submissions import read_submission
from robsim.teach.tasks.solutions import MODULE, module_source
from robsim.teach.texts import clean_text
from robsim.trace import Trace

OUT_OF_TIME = "not run: out of time"
NOT_LOADED = "not run: it could not be loaded in the runs before"
_TRIES = 3  # to load a submission
_LEAST = 0.5  # s that a run must have left, else it is not begun


@dataclass
class Runs:
    """The runs of a test so far.

    Attributes
    ----------
    numbers, reference : list of dict
        Those of the runs that came through, and of the reference in the same ones, by score.
    failed : list of FailedRun
        Those that did not.
    traces : dict of int to Trace
        The runs, by number; of those that failed the steps until then, if there were any.
    output : str
        What the submission printed in the first that failed, else in the last.
    isolation : str
        What has shut it in.
    """

    numbers: list[dict[str, float]] = field(default_factory=list)
    reference: list[dict[str, float]] = field(default_factory=list)
    failed: list[FailedRun] = field(default_factory=list)
    traces: dict[int, Trace] = field(default_factory=dict)
    output: str = ""
    isolation: str = ""

    @property
    def cannot_be_loaded(self) -> bool:
        """Whether the submission was never loaded, and that was tried often enough."""
        is_never = not self.numbers and all(run.step is None for run in self.failed)
        return is_never and len(self.failed) >= _TRIES


@dataclass(frozen=True)
class RunTest:
    """A test that was run: its result, two of its runs, and what has shut the submission in.

    Without a task nothing was run: the submission could not be read.
    """

    result: TestResult
    task: GradedTask | None = None
    worst: Trace | None = None
    best: Trace | None = None
    isolation: str = ""


def run_task_test(
    assignment: Assignment,
    test: TaskTest,
    path: str,
    student: str,
    references: References,
    seconds: float,
) -> RunTest:
    """Run a test of a submission.

    Parameters
    ----------
    assignment, test
        What is graded.
    path : str
        What was handed in.
    student : str
        The student's name, for the key.
    references : References
        What has the numbers of the reference.
    seconds : float
        How long it may take.

    Raises
    ------
    AssignmentError
        If the reference fails, or a run cannot be scored.
    GraderError
        If no process can be started.
    """
    begin = time.monotonic()
    try:
        task = graded_task(assignment, test, path)
    except SubmissionError as error:
        return RunTest(_unread(test, error))
    runs = Runs()
    for run in range(test.task.runs):
        left = begin + seconds - time.monotonic()
        if left < _LEAST:
            runs.failed.append(FailedRun(run=run, reason=OUT_OF_TIME))
            continue
        if runs.cannot_be_loaded:
            runs.failed.append(FailedRun(run=run, reason=NOT_LOADED))
            continue
        limits = replace(task.limits, run=min(task.limits.run, left))
        _run(assignment, test, replace(task, limits=limits), student, run, references, runs)
    result = marked(test, _result(test, runs, time.monotonic() - begin))
    through = runs_by_badness(test, result)
    best = runs.traces[through[0]] if through else None
    if (shown := run_to_show(result, through)) is None:
        return RunTest(result, task, isolation=runs.isolation)
    result = replace(result, worst=shown)
    return RunTest(result, task, runs.traces.get(shown), best, runs.isolation)


def run_to_show(result: TestResult, through: list[int]) -> int | None:
    """Return the run to show: the worst, or the first that failed where these cost more."""
    of_failed = len(result.failed) / result.runs
    of_scores = (1 - of_failed) * sum((1 - one.fraction) * one.share for one in result.scores)
    if result.failed and of_failed >= of_scores:
        begun = [run for run in result.failed if run.step is not None]
        # One with steps before that, which can be drawn.
        return next((run.run for run in sorted(begun, key=lambda run: not run.step)), None)
    return through[-1] if through else None


def graded_task(assignment: Assignment, test: TaskTest, path: str) -> GradedTask:
    """Read a submission for a test; raise SubmissionError if that cannot be."""
    rules = assignment._rules(test.task.slots)
    given = {**assignment.given_files, f"{MODULE}.py": module_source(test.task)}
    return GradedTask(
        submission=read_submission(path, rules, given),
        rules=rules,
        frames=assignment._frames,
        limits=assignment.limits,
        isolation=assignment.isolation,  # type: ignore[arg-type]
    )


def _run(
    assignment: Assignment,
    test: TaskTest,
    task: GradedTask,
    student: str,
    run: int,
    references: References,
    runs: Runs,
) -> None:
    """Run once, and note what came of it."""
    seeds = seeds_of(assignment, test, student, run)
    try:
        graded = graded_run(task, test.task.scenario, test.task.steps, seeds)
    except SubmissionError as error:
        if not runs.failed:
            runs.output = error.output
        runs.failed.append(failed_run(run, error))
        if error.trace is not None:
            runs.traces[run] = error.trace
        return
    runs.isolation = graded.layers
    if not runs.failed:
        runs.output = graded.output
    runs.numbers.append(dict(numbers_of(test, graded.result)))
    runs.reference.append(dict(references.numbers(test, student, run)))
    runs.traces[run] = graded.result


def failed_run(run: int, error: SubmissionError) -> FailedRun:
    return FailedRun(
        run=run,
        reason=clean_text(str(error)),
        slot=error.slot,
        step=error.step,
        file=error.file,
        line=error.line,
        cause=error.cause,
    )


def _result(test: TaskTest, runs: Runs, seconds: float) -> TestResult:
    """Return the numbers of a test, not marked yet."""
    scores = tuple(
        ScoreResult(
            name=score.name,
            title=score.title,
            values=tuple(numbers[score.name] for numbers in runs.numbers),
            reference=tuple(numbers[score.name] for numbers in runs.reference),
            statistic=math.nan,
            limit=0.0,
            zero=0.0,
            fraction=0.0,
        )
        for score in test.task.scores
    )
    return TestResult(
        name=test.name,
        title=test.title,
        points=0.0,
        most=test.points,
        status=NOT_RUN,
        whose=SubmissionError.whose if runs.failed else None,
        scores=scores,
        runs=test.task.runs,
        failed=tuple(runs.failed),
        output=clean_text(runs.output),
        seconds=seconds,
    )


def unmarked(test: TaskTest, status: str, sentence: str, whose: str | None = None) -> TestResult:
    """Return the result of a test without runs: no points."""
    return TestResult(
        name=test.name,
        title=test.title,
        number=test.number,
        public=test.public,
        points=0.0,
        most=test.points,
        status=status,
        sentence=sentence,
        whose=whose,
    )


def _unread(test: TaskTest, error: SubmissionError) -> TestResult:
    return unmarked(test, FAILED, clean_text(str(error)), error.whose)
