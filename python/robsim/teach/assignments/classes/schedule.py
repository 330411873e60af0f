"""The tests of a class in an order for many workers, and what comes of them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any

from robsim.teach.assignments.classes.plan import Plan
from robsim.teach.assignments.classes.progress import Progress
from robsim.teach.assignments.classes.store import ResultFolder
from robsim.teach.assignments.classes.submissions import Handed
from robsim.teach.assignments.grading.work import Job, Row
from robsim.teach.assignments.results import SubmissionResult

Tell = Callable[[SubmissionResult, str], Any]
Keep = Callable[[SubmissionResult], Any]


class Schedule:
    """Hands out the tests of submissions, those of one submission one after the other.

    So what a submission takes in all is known, and no more submissions are begun than there are
    workers.

    Parameters
    ----------
    plan : Plan
        What is graded.
    handed : iterable of Handed
        The submissions.
    folder : ResultFolder
        Where results are written after each test.
    tell : callable, optional
        Is called with the result of each submission that is done, and why it was graded anew.
    keep : callable, optional
        Is called with what came of a submission so far, after each test.
    """

    def __init__(
        self,
        plan: Plan,
        handed: Iterable[Handed],
        folder: ResultFolder,
        tell: Tell | None,
        keep: Keep | None,
    ) -> None:
        self._plan, self._folder, self._tell, self._keep = plan, folder, tell, keep
        self._waiting = enumerate(handed)
        self._open: dict[int, Progress] = {}
        self._busy: set[int] = set()
        self.results: list[SubmissionResult] = []

    def take(self, whole: float = 0.0, room: int = 1) -> list[Job]:
        """Return the next test, as a list; an empty one where there is none just now."""
        for index in sorted(self._open.keys() - self._busy):
            if job := self._next(index):
                return [job]
        for index, handed in self._waiting:
            old = self._folder.read(handed.student)
            self._open[index] = Progress(index, handed, self._plan, old)
            if job := self._next(index):
                return [job]
        return []

    def note(self, rows: Sequence[Any], /) -> None:
        """Do nothing: all tests are handed out one by one, however long they take."""

    def done(self, row: Row) -> None:
        """Take what came of a test, and write it."""
        progress = self._open[row.job.submission]
        progress.take(row)
        self._busy.discard(row.job.submission)
        result = progress.result
        self._folder.write(result, row.pictures, row.paths)
        if self._keep is not None:
            self._keep(result)

    def _next(self, index: int) -> Job | None:
        """Return the next test of a submission; where there is none left, end it."""
        progress = self._open[index]
        if job := progress.next():
            self._busy.add(index)
            return job
        del self._open[index]
        result = progress.result
        self._folder.write_whole(result)
        if self._keep is not None:
            self._keep(result)
        self.results.append(result)
        if self._tell is not None:
            self._tell(result, progress.changed)
        return None
