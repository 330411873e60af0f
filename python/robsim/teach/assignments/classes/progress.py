"""The progress of a submission: its kept results, and its remaining tests."""

from __future__ import annotations

import platform
from collections.abc import Callable, Collection, Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

import robsim
from robsim.teach.assignments.assignment import TaskTest
from robsim.teach.assignments.classes.plan import Plan
from robsim.teach.assignments.classes.store import ResultFolder
from robsim.teach.assignments.classes.submissions import Handed
from robsim.teach.assignments.marking import references as digests
from robsim.teach.assignments.marking.marking import labels_of, marked_anew
from robsim.teach.assignments.marking.task_runs import files_for
from robsim.teach.assignments.marking.work import Job, Row, Unit
from robsim.teach.errors import SubmissionError
from robsim.teach.reports import words
from robsim.teach.reports.similarity import Program, program_of
from robsim.teach.results import ERROR, FAILED, NOT_RUN, SubmissionResult, TestResult
from robsim.teach.submissions import SubmissionFiles
from robsim.teach.submissions.reading import Contents, arranged, open_submission
from robsim.teach.texts import clean_text

_WAITING = "Not run yet."
_OUT_OF_TIME = "Not run: the previous tests took all the available time."
_LEAST = 1.0  # s, minimum time for a test


class Progress:
    """A submission, by its number in the class, with its results so far."""

    def __init__(
        self, index: int, handed: Handed, plan: Plan, old: SubmissionResult | None
    ) -> None:
        self.handed = handed
        self.changed = ""
        self._index, self._plan = index, plan
        self._assignment, self._units = plan.assignment, plan.work.units
        self._isolation = ""
        self._read()
        kept = self._kept(old)
        self._results: dict[str, TestResult] = {}
        self._left: list[int] = []
        for number, unit in enumerate(self._units):
            self._begin(number, unit, kept, not plan.wanted.isdisjoint(unit.names))

    def _read(self) -> None:
        self._refused, self._digest = "", ""
        self.contents: Contents | None = None
        rules = self._assignment._rules()
        try:
            self.contents = open_submission(self.handed.path, rules, self.handed.files)
            files = arranged(self.contents, rules, self._assignment.files_of_all)
            self._notes = tuple(map(clean_text, files.notes))
            self._digest = digests.of_submission(files)
        except SubmissionError as error:
            self._refused = clean_text(str(error))
            self._notes = (self._refused,)

    def _kept(self, old: SubmissionResult | None) -> dict[str, TestResult]:
        """Return the results that are still valid, by test; note the reason if all are invalid."""
        if old is None or self._refused:
            return {}
        if old.submission_digest != self._digest:
            self.changed = "it has changed since it was graded"
            return {}
        if dict(old.versions) != versions():
            self.changed = "it was graded with other versions"
            return {}
        self._isolation = old.isolation
        return {test.name: test for test in old.tests if test.digest and test.status != ERROR}

    def _begin(self, number: int, unit: Unit, kept: dict[str, TestResult], is_wanted: bool) -> None:
        if self._refused:
            self._end(unit, FAILED, self._refused)
            return
        found = [kept[name] for name in unit.names if name in kept]
        if len(found) == len(unit.names) and all(one.digest == unit.digest for one in found):
            self._take(again(unit, one) for one in found)
            return
        if found and not self.changed:
            self.changed = "the assignment has changed since it was graded"
        waits = _WAITING if unit.test.public else self._plan.waits or _WAITING
        self._take(unit.unmarked(status=NOT_RUN, sentence=waits, digest=""))
        if is_wanted:
            self._left.append(number)

    def _take(self, results: Iterable[TestResult]) -> None:
        self._results |= {one.name: one for one in results}

    def _end(self, unit: Unit, status: str, sentence: str) -> None:
        whose = SubmissionError.whose
        self._take(unit.unmarked(status=status, sentence=sentence, whose=whose))

    def next(self) -> Job | None:
        """Return the next test to run, if any; without time left, tests do not run."""
        while self._left:
            number = self._left[0]
            unit = self._units[number]
            seconds = self._assignment.seconds - self._seconds
            try:
                if seconds >= _LEAST:
                    assert self.contents is not None
                    files: SubmissionFiles | Contents = replace(self.contents, found={})
                    if isinstance(unit.test, TaskTest):
                        files = files_for(self._assignment, unit.test, self.contents)
                    return Job(self._index, number, self.handed.student, files, seconds)
                self._end(unit, NOT_RUN, _OUT_OF_TIME)
            except Exception as error:  # for example, if no file is for this test
                self._take(unit.failed_by(error))
            del self._left[0]
        return None

    def take(self, row: Row) -> None:
        self._take(row.results)
        self._isolation = row.isolation or self._isolation
        self._left.remove(row.unit)

    @property
    def _seconds(self) -> float:
        return sum(test.seconds for test in self._results.values())

    @property
    def result(self) -> SubmissionResult:
        tests = tuple(self._results.values())
        return SubmissionResult(
            assignment=self._assignment.name,
            title=self._assignment.title,
            student=self.handed.student,
            members=self.handed.members,
            tests=tests,
            notes=self._notes,
            isolation=self._isolation,
            submission_digest=self._digest,
            assignment_digest=self._plan.digest,
            versions=versions(),
            is_done=all(test.digest and test.status != ERROR for test in tests),
            seconds=self._seconds,
        )


def again(unit: Unit, result: TestResult) -> TestResult:
    """Return a result with the current points and sentences."""
    if isinstance(unit.test, TaskTest):
        # A test without runs has no points under any limits.
        if not result.scores:
            return replace(result, **labels_of(unit.test))
        return marked_anew(unit.test, result)
    (own,) = (one for one in unit.own if one.name == result.name)
    points = own.points if result.points > 0 else 0.0
    return replace(result, points=points, most=own.points, title=own.title, public=own.public)


def versions() -> dict[str, str]:
    return {
        "robsim": robsim.__version__,
        "numpy": np.__version__,
        "python": platform.python_version(),
    }


@dataclass
class Schedule:
    """Hands out the tests of submissions, each submission's tests one after the other.

    So the duration of a submission is known, and at most one submission per worker is open.
    `tell` gets each finished result, and the reason of a repeated grading. Without `students`, all
    are graded; otherwise other students' results come from the folder.
    """

    plan: Plan
    handed: Sequence[Handed]
    folder: ResultFolder
    tell: Callable[[SubmissionResult, str], Any] | None = None
    students: Collection[str] | None = None
    results: list[SubmissionResult] = field(default_factory=list)
    programs: dict[str, Program] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self._waiting = enumerate(self.handed)
        self._open: dict[int, Progress] = {}
        self._busy: set[int] = set()

    def take(self) -> list[Job]:
        """Return the next test in a list; empty while no test is ready."""
        for index in sorted(self._open.keys() - self._busy):
            if job := self._next(index):
                return [job]
        for index, handed in self._waiting:
            old = self.folder.read(handed.student)
            progress = Progress(index, handed, self.plan, old)
            if len(self.handed) > 1 and progress.contents is not None:
                with suppress(SubmissionError):
                    files = arranged(progress.contents, self.plan.assignment._rules(), {})
                    self.programs[handed.student] = program_of(files.sources)
            if self.students is not None and handed.student not in self.students:
                self.results += [] if old is None else [old]
                continue
            self._open[index] = progress
            if job := self._next(index):
                return [job]
        return []

    def note(self, rows: Sequence[Any], /) -> None:
        """Do nothing: all tests are handed out one by one, regardless of their duration."""

    def done(self, row: Row) -> None:
        progress = self._open[row.submission]
        progress.take(row)
        self._busy.discard(row.submission)
        self._write(progress, row.pictures, row.paths)

    def _write(self, progress: Progress, *files: Any) -> SubmissionResult:
        place = self.plan.assignment.folder, progress.handed.path, self.folder.folder
        command = words.grade_command(*place, progress.handed.student)
        return self.folder.write(replace(progress.result, command=command), *files)

    def _next(self, index: int) -> Job | None:
        """Return the next test of a submission; after its last test, end it."""
        progress = self._open[index]
        if job := progress.next():
            self._busy.add(index)
            return job
        del self._open[index]
        result = self._write(progress)
        self.results.append(result)
        if self.tell is not None:
            self.tell(result, progress.changed)
        return None
