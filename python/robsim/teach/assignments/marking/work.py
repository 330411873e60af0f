"""The tests of submissions as jobs for an engine: each is a test of one submission."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from robsim.base.text import said_by
from robsim.teach.assignments._own_tests.listing import OwnTest, run_own_tests
from robsim.teach.assignments.assignment import Assignment, FileTests, TaskTest
from robsim.teach.assignments.marking.findings import Doctor
from robsim.teach.assignments.marking.marking import labels_of
from robsim.teach.assignments.marking.playing import path_of, picture_of
from robsim.teach.assignments.marking.references import References
from robsim.teach.assignments.marking.task_runs import RunTest, run_task_test
from robsim.teach.errors import GraderError, GradingError, SubmissionError
from robsim.teach.results import ERROR, FAILED, TestResult
from robsim.teach.submissions import SubmissionFiles
from robsim.teach.submissions.reading import Contents
from robsim.teach.texts import clean_text

_DIED = "the grader's process ended in this test in each try: tell your teacher"


@dataclass(frozen=True)
class Unit:
    """A test by a task, or a file with tests of the teacher."""

    test: TaskTest | FileTests
    own: tuple[OwnTest, ...]  # the tests of the file
    digest: str  # of the inputs of its numbers

    @property
    def names(self) -> tuple[str, ...]:
        if isinstance(self.test, TaskTest):
            return (self.test.name,)
        return tuple(one.name for one in self.own)

    def unmarked(self, **told: Any) -> tuple[TestResult, ...]:
        """Return results without points; `told` are further attributes."""
        told.setdefault("digest", self.digest)
        if isinstance(self.test, TaskTest):
            return (TestResult(name=self.test.name, points=0.0, **labels_of(self.test), **told),)
        return tuple(one.result(**told) for one in self.own)

    def failed_by(self, error: Exception) -> tuple[TestResult, ...]:
        """Return the results of tests that failed to run: only the submission loses points."""
        whose = error.whose if isinstance(error, GradingError) else GraderError.whose
        said = str(error) if isinstance(error, GradingError) else said_by(error)
        status = FAILED if isinstance(error, SubmissionError) else ERROR
        return self.unmarked(status=status, sentence=clean_text(said), whose=whose)


class Job(NamedTuple):
    """A unit of tests of a submission, and its time limit (s).

    It has the submission's files: only the files for the test by a task, else all.
    """

    submission: int
    unit: int
    student: str
    files: SubmissionFiles | Contents
    seconds: float


class Row(NamedTuple):
    """The result of a job."""

    submission: int
    unit: int
    results: tuple[TestResult, ...]  # of each test
    isolation: str = ""  # the layers of the sandbox
    pictures: Mapping[str, bytes] = {}  # PNG, by test
    paths: Mapping[str, list[list[float]]] = {}  # of the best runs, (N, 2), by test


@dataclass(frozen=True)
class GradingWork:
    """The message to the graders: an assignment, and its tests."""

    assignment: Assignment
    units: tuple[Unit, ...]

    def doer(self) -> Callable[[Job], Row]:
        return Grader(self).row

    def lost(self, job: Job, /) -> Row:
        """Return the row of a job whose process ends in each try."""
        told = {"status": ERROR, "sentence": _DIED, "whose": GraderError.whose}
        return Row(job.submission, job.unit, self.units[job.unit].unmarked(**told))


class Grader:
    """A grader does jobs, one after the other."""

    def __init__(self, work: GradingWork) -> None:
        self._work = work
        self._references = References(work.assignment)
        self._doctor = Doctor()

    def row(self, job: Job) -> Row:
        unit = self._work.units[job.unit]
        try:
            if isinstance(unit.test, TaskTest):
                return self._by_task(job, unit.test, unit.digest)
            assert isinstance(job.files, Contents)
            given = (unit.own, job.files, job.student, job.seconds, unit.digest)
            results = run_own_tests(self._work.assignment, unit.test, *given)
            return Row(job.submission, job.unit, results)
        except Exception as error:
            return Row(job.submission, job.unit, unit.failed_by(error))

    def _by_task(self, job: Job, test: TaskTest, digest: str) -> Row:
        assert isinstance(job.files, SubmissionFiles)
        given = (job.files, job.student, self._references, job.seconds)
        run = run_task_test(self._work.assignment, test, *given)
        finding = self._doctor.finding(run, job.seconds - run.seconds)
        pictures, caption = self._drawn(job, test, run)
        result = TestResult(
            name=test.name,
            **labels_of(test),
            **vars(run.mark),
            whose=SubmissionError.whose if run.mark.failed else None,
            worst=run.shown,
            picture=f"{test.name}.png" if pictures else None,
            caption=caption,
            finding=finding,
            output=clean_text(run.runs.output),
            seconds=run.seconds,
            digest=digest,
        )
        paths = {} if run.best is None else {test.name: path_of(run.runs.traces[run.best])}
        return Row(job.submission, job.unit, (result,), run.runs.isolation, pictures, paths)

    def _drawn(self, job: Job, test: TaskTest, run: RunTest) -> tuple[dict[str, bytes], str]:
        if run.shown is None or (trace := run.runs.traces.get(run.shown)) is None:
            return {}, ""
        reference = None
        if test.reference is not None:
            reference = self._references.trace(test, job.student, run.shown)
        png, caption = picture_of(test, trace, reference)
        return {test.name: png}, caption
