"""`ClassResult`: the results of a class."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from robsim.base.report import Column, Quantity, Report, Row, Table
from robsim.teach.reports.words import by_hand, person, waiting
from robsim.teach.results import ERROR, NOT_RUN, SubmissionResult

_MOST_LISTED = 5
_WIDEST = 24  # characters of the heading of a column


@dataclass(frozen=True, kw_only=True)
class ClassResult(Report):
    """The results of a class.

    Attributes
    ----------
    name : str
        The name of the assignment.
    results : tuple of SubmissionResult
        The results of the submissions, by the names of the students.
    changes : mapping of str to (float, float), or None
        The points before and after `regrade_class`, of students whose points have changed.

    Examples
    --------
    >>> import pathlib
    >>> assignment = robsim.teach.new_assignment("measure", "hw1", seed=1)
    >>> pathlib.Path("class/ann").mkdir(parents=True)
    >>> size = pathlib.Path("class/ann/measure.py").write_text("def measure(step): return None")
    >>> result = robsim.teach.grade_class(assignment, "class", "marks", public=True)
    >>> [(one.student, one.points) for one in result.results]
    [('ann', 1.0)]
    """

    name: str
    results: tuple[SubmissionResult, ...]
    changes: Mapping[str, tuple[float, float]] | None = None

    @property
    def title(self) -> str:
        """The name of the assignment and the number of submissions."""
        return f"{self.name}: {len(self.results)} submission{'s' * (len(self.results) != 1)}"

    @property
    def quantities(self) -> Sequence[Quantity]:
        """Mean and median of the points, and the number of students with full points."""
        points = [result.points for result in self.results]
        most = max((result.most for result in self.results), default=0.0)
        full = sum(result.points >= result.most for result in self.results)
        return (
            Quantity("mean", "mean", float(np.mean(points)), "", ".2f"),
            Quantity("median", "median", float(np.median(points)), "", ".2f"),
            Quantity("most", "of", most),
            Quantity("full", "with all points", full),
        )

    @property
    def tables(self) -> Sequence[Table]:
        """The points of each student in each test."""
        names = list(dict.fromkeys(test.name for one in self.results for test in one.tests))
        tests = [Column(name, _heading(name), "", ".2f") for name in names]
        columns = [Column("points", "points", "", ".2f"), *tests]
        rows = [Row(person(one.student), _row(one, names)) for one in self.results]
        return (Table(key="students", columns=columns, rows=rows, row_title="student"),)

    @property
    def remarks(self) -> Sequence[str]:
        """Notes on provisional limits, and on submissions that could not be read or graded."""
        return tuple(self._remarks())

    def _remarks(self) -> Iterator[str]:
        yield from sorted({test.provisional for one in self.results for test in one.tests} - {""})
        if broken := [one for one in self.results if one.has_errors]:
            yield (
                f"grading failed without a fault of the submission: {_listed(broken)}; the "
                "same call tries again"
            )
        if unread := [one for one in self.results if one.is_unread]:
            yield f"without points, because unreadable (see their pages): {_listed(unread)}"
        if left := [one for one in self.results if not one.is_done and not one.has_errors]:
            why = dict.fromkeys(test.sentence for one in left for test in waiting(one))
            yield f"some tests were not run: {_listed(left)}. {' '.join(why)}"
        for one in self.results:
            if said := by_hand(one):
                yield f"{person(one.student)}: {' '.join(said)}"

    @property
    def has_errors(self) -> bool:
        """Whether the grading of a test failed because of the assignment or the grader."""
        return any(one.has_errors for one in self.results)

    @property
    def is_full(self) -> bool:
        """Whether all students have all points."""
        return all(one.is_done and one.points >= one.most for one in self.results)


def _heading(name: str) -> str:
    """Return the name of a test, shortened for a column: pytest functions have long names."""
    name = name.removeprefix("test_")
    return name if len(name) <= _WIDEST else f"{name[: _WIDEST - 3]}..."


def _row(result: SubmissionResult, names: Sequence[str]) -> list[float | None]:
    graded = (one for one in result.tests if one.status != ERROR)
    points = {one.name: one.points for one in graded if one.status != NOT_RUN or one.digest}
    return [result.points, *(points.get(name) for name in names)]


def _listed(results: Sequence[SubmissionResult]) -> str:
    more = len(results) - _MOST_LISTED
    names = ", ".join(person(one.student) for one in results[:_MOST_LISTED])
    return names + (f" and {more} more" if more > 0 else "")
