"""The tests of a class in an order for many workers, and what comes of them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import Any

from robsim.teach.assignments.classes.plan import Plan
from robsim.teach.assignments.classes.progress import Progress
from robsim.teach.assignments.classes.store import ResultFolder
from robsim.teach.assignments.classes.submissions import Handed
from robsim.teach.assignments.grading.work import Job, Row
from robsim.teach.assignments.results import SubmissionResult
from robsim.teach.errors import SubmissionError
from robsim.teach.reports.similarity import Program, program_of
from robsim.teach.submissions.reading import Contents, arranged

Tell = Callable[[SubmissionResult, str], Any]


class Schedule:
    """Hands out the tests of submissions, those of one submission one after the other.

    So what a submission takes in all is known, and no more submissions are begun than there are
    workers.

    Parameters
    ----------
    plan : Plan
        What is graded.
    handed : sequence of Handed
        The submissions.
    folder : ResultFolder
        Where results are written after each test.
    tell : callable, optional
        Is called with the result of each finished submission, and why it was graded again.
    """

    def __init__(
        self, plan: Plan, handed: Sequence[Handed], folder: ResultFolder, tell: Tell | None
    ) -> None:
        self._plan, self._folder, self._tell = plan, folder, tell
        self._waiting = enumerate(handed)
        self._is_class = len(handed) > 1
        self._open: dict[int, Progress] = {}
        self._busy: set[int] = set()
        self.results: list[SubmissionResult] = []
        self.programs: dict[str, Program] = {}

    def take(self, whole: float = 0.0, room: int = 1) -> list[Job]:
        """Return the next test, as a list; an empty one where there is none just now."""
        for index in sorted(self._open.keys() - self._busy):
            if job := self._next(index):
                return [job]
        for index, handed in self._waiting:
            old = self._folder.read(handed.student)
            self._open[index] = progress = Progress(index, handed, self._plan, old)
            self._note_program(handed.student, progress.contents)
            if job := self._next(index):
                return [job]
        return []

    def _note_program(self, student: str, contents: Contents | None) -> None:
        """Keep what tells a program from others, which all of a class are compared by."""
        with suppress(SubmissionError):
            if self._is_class and contents is not None:
                files = arranged(contents, self._plan.assignment._rules(), {})
                self.programs[student] = program_of(files.sources)

    def note(self, rows: Sequence[Any], /) -> None:
        """Do nothing: all tests are handed out one by one, however long they take."""

    def done(self, row: Row) -> None:
        """Take what came of a test, and write it."""
        progress = self._open[row.submission]
        progress.take(row)
        self._busy.discard(row.submission)
        self._folder.write(progress.result, row.pictures, row.paths)

    def _next(self, index: int) -> Job | None:
        """Return the next test of a submission; where there is none left, end it."""
        progress = self._open[index]
        if job := progress.next():
            self._busy.add(index)
            return job
        del self._open[index]
        result = progress.result
        self._folder.write_whole(result)
        self.results.append(result)
        if self._tell is not None:
            self._tell(result, progress.changed)
        return None
