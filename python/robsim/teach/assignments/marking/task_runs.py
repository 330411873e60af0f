"""A test by a task: the runs of a submission and of the reference."""

from __future__ import annotations

import time
from dataclasses import dataclass, field, replace

from robsim.teach.assignments.assignment import Assignment, TaskTest
from robsim.teach.assignments.marking.marking import Mark, mark_of, run_to_show, runs_by_badness
from robsim.teach.assignments.marking.references import References, numbers_of, seeds_of
from robsim.teach.errors import TIMEOUT, SubmissionError
from robsim.teach.grading.graded_run import graded_run
from robsim.teach.grading.task import Task as GradedTask
from robsim.teach.results import FailedRun
from robsim.teach.submissions import SubmissionFiles
from robsim.teach.submissions.reading import Contents, arranged
from robsim.teach.tasks.solutions import MODULE, module_source
from robsim.teach.texts import clean_text
from robsim.trace import Trace

OUT_OF_TIME = "not run: out of time"
NOT_BEGUN = "not run: the previous runs failed at their start"
_TRIES = 3  # to load a submission and to get its first answer
_LEAST = 0.5  # s, minimum time for a run


@dataclass
class Runs:
    """The runs of a test so far."""

    #: By score: the numbers of the completed runs, and of the reference in these.
    numbers: dict[str, list[float]]
    reference: dict[str, list[float]]
    failed: list[FailedRun] = field(default_factory=list)
    #: The runs, by number; failed ones with the steps until their failure, if any.
    traces: dict[int, Trace] = field(default_factory=dict)
    output: str = ""  # printed in the first failed run, else in the last
    isolation: str = ""  # the layers of its sandbox

    @property
    def cannot_begin(self) -> bool:
        """Whether each try so far ended before the first answer: without loading, or by time."""
        is_never = not any(self.numbers.values()) and all(
            run.step is None or (run.step == 0 and run.cause == TIMEOUT) for run in self.failed
        )
        return is_never and len(self.failed) >= _TRIES


@dataclass(frozen=True)
class RunTest:
    """A completed test."""

    task: GradedTask
    runs: Runs
    mark: Mark
    #: Numbers of the run to show, and of the best run; None = no such run.
    shown: int | None
    best: int | None
    seconds: float


def run_task_test(
    assignment: Assignment,
    test: TaskTest,
    files: SubmissionFiles,
    student: str,
    references: References,
    seconds: float,
) -> RunTest:
    """Run a test of a submission, with a time limit (s); `files_for` the test has its files.

    Raise AssignmentError if the reference or a score fails, GraderError without a process.
    """
    begin = time.monotonic()
    task = graded_task(assignment, test, files)
    names = [score.name for score in test.task.scores]
    runs = Runs({name: [] for name in names}, {name: [] for name in names})
    for run in range(test.task.runs):
        left = begin + seconds - time.monotonic()
        if left < _LEAST:
            runs.failed.append(FailedRun(run=run, reason=OUT_OF_TIME))
            continue
        if runs.cannot_begin:
            runs.failed.append(FailedRun(run=run, reason=NOT_BEGUN))
            continue
        limits = replace(task.limits, run=min(task.limits.run, left))
        _run(assignment, test, replace(task, limits=limits), student, run, references, runs)
    seconds = time.monotonic() - begin
    mark = mark_of(test, runs.failed, runs.numbers, runs.reference)
    through = runs_by_badness(test, mark)
    best = through[0] if through else None
    return RunTest(task, runs, mark, run_to_show(mark, through), best, seconds)


def files_for(assignment: Assignment, test: TaskTest, contents: Contents) -> SubmissionFiles:
    """Return the files of a submission for a test; raise SubmissionError without such a file."""
    given = {**assignment.given_files, f"{MODULE}.py": module_source(test.task)}
    return arranged(contents, assignment._rules(test.task.slots), given)


def graded_task(assignment: Assignment, test: TaskTest, files: SubmissionFiles) -> GradedTask:
    return GradedTask(
        submission=files,
        rules=assignment._rules(test.task.slots),
        frames=assignment._frames,
        limits=assignment.limits,
        isolation=assignment.isolation,
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
    seeds = seeds_of(assignment, test, student, run)
    try:
        graded = graded_run(task, test.task.scenario, test.task.steps, seeds)
    except SubmissionError as error:
        if not runs.failed:
            runs.output = error.output
        reason = clean_text(str(error))
        runs.failed.append(FailedRun(run=run, reason=reason, **error._place))
        if error.trace is not None:
            runs.traces[run] = error.trace
        return
    runs.isolation = graded.layers
    if not runs.failed:
        runs.output = graded.output
    own, others = numbers_of(test, graded.result), references.numbers(test, student, run)
    for name, number in own.items():
        runs.numbers[name].append(number)
        runs.reference[name].append(others[name])
    runs.traces[run] = graded.result
