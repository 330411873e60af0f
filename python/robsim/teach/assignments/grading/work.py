"""The tests of submissions as jobs for an engine: each is a test of one submission."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

from robsim.base.text import said_by
from robsim.teach.assignments._own_tests.listing import OwnTest, run_own_tests
from robsim.teach.assignments.assignment import Assignment, FileTests, TaskTest
from robsim.teach.assignments.grading.findings import Doctor
from robsim.teach.assignments.grading.playing import path_of, picture_of
from robsim.teach.assignments.grading.references import References
from robsim.teach.assignments.grading.task_runs import run_task_test, unmarked
from robsim.teach.assignments.results import ERROR, TestResult
from robsim.teach.errors import GraderError, GradingError
from robsim.teach.texts import clean_text

_DIED = "the grader's own process ended in this test, whenever it was tried: tell your teacher"


@dataclass(frozen=True)
class Unit:
    """What is run in one go: a test by a task, or a file with tests of the teacher's own.

    Attributes
    ----------
    test : TaskTest or FileTests
        The test.
    own : tuple of OwnTest
        The tests of the file.
    digest : str
        Of what its numbers rest on.
    """

    test: TaskTest | FileTests
    own: tuple[OwnTest, ...]
    digest: str

    @property
    def names(self) -> tuple[str, ...]:
        """The names of its tests."""
        if isinstance(self.test, TaskTest):
            return (self.test.name,)
        return tuple(one.name for one in self.own)

    def unmarked(self, status: str, sentence: str, whose: str | None) -> tuple[TestResult, ...]:
        """Return results without points."""
        if isinstance(self.test, TaskTest):
            results: tuple[TestResult, ...] = (unmarked(self.test, status, sentence, whose),)
        else:
            results = tuple(one.result(status, sentence, whose=whose) for one in self.own)
        return tuple(replace(one, digest=self.digest) for one in results)


class Job(NamedTuple):
    """A unit of tests of a submission, and how long it may take (s)."""

    submission: int
    unit: int
    student: str
    path: str
    seconds: float


class Row(NamedTuple):
    """What came of a job.

    Attributes
    ----------
    job : Job
        The job.
    results : tuple of TestResult
        A result for each test.
    isolation : str
        What has shut the submission in.
    pictures : dict of str to bytes
        PNG pictures by test.
    paths : dict of str to list
        The path of the best run, (N, 2), by test.
    seconds : float
        How long it took.
    """

    job: Job
    results: tuple[TestResult, ...]
    isolation: str
    pictures: dict[str, bytes]
    paths: dict[str, list[list[float]]]
    seconds: float


@dataclass(frozen=True)
class GradingWork:
    """What is sent to those who grade.

    Attributes
    ----------
    assignment : Assignment
        What is graded.
    units : tuple of Unit
        Its tests.
    """

    assignment: Assignment
    units: tuple[Unit, ...]

    def doer(self) -> Grader:
        return Grader(self)

    def lost(self, job: Job, /) -> Row:
        """Return the row of a job whose process ends, whenever it is tried."""
        results = self.units[job.unit].unmarked(ERROR, _DIED, GraderError.whose)
        return Row(job, results, "", {}, {}, 0.0)

    def check_can_be_sent(self) -> None:
        """Do nothing: an assignment is plain data."""


class Grader:
    """What does jobs, one after the other."""

    def __init__(self, work: GradingWork) -> None:
        self._work = work
        self._references = References(work.assignment)
        self._doctor = Doctor()

    def rows(self, jobs: Sequence[Job], /) -> list[Row]:
        return [self._row(job) for job in jobs]

    def _row(self, job: Job) -> Row:
        begin = time.monotonic()
        unit = self._work.units[job.unit]
        row = Row(job, (), "", {}, {}, 0.0)
        try:
            done = self._by_task if isinstance(unit.test, TaskTest) else self._own
            row = done(row, unit)
        except Exception as error:  # not of a submission: these are results
            whose = error.whose if isinstance(error, GradingError) else GraderError.whose
            said = str(error) if isinstance(error, GradingError) else said_by(error)
            row = row._replace(results=unit.unmarked(ERROR, clean_text(said), whose))
        results = tuple(replace(one, digest=unit.digest) for one in row.results)
        return row._replace(results=results, seconds=time.monotonic() - begin)

    def _own(self, row: Row, unit: Unit) -> Row:
        """Do the tests of a file."""
        assert isinstance(unit.test, FileTests)
        job, assignment = row.job, self._work.assignment
        results = run_own_tests(assignment, unit.test, unit.own, job.path, job.student, job.seconds)
        return row._replace(results=results)

    def _by_task(self, row: Row, unit: Unit) -> Row:
        """Do a test by a task, with the picture of a run that went wrong."""
        assert isinstance(unit.test, TaskTest)
        job, test = row.job, unit.test
        run = run_task_test(
            self._work.assignment, test, job.path, job.student, self._references, job.seconds
        )
        left = job.seconds - run.result.seconds
        result = replace(run.result, finding=self._doctor.finding(run, left))
        row = row._replace(isolation=run.isolation, results=(result,))
        if run.best is not None:
            row.paths[test.name] = path_of(run.best)
        if run.worst is None or result.worst is None:
            return row
        reference = None
        if test.reference is not None:
            reference = self._references.trace(test, job.student, result.worst)
        row.pictures[test.name], caption = picture_of(test, run.worst, reference)
        shown = replace(result, picture=f"{test.name}.png", caption=caption)
        return row._replace(results=(shown,))
