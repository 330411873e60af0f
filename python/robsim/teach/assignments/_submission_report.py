"""The result of a submission as a table."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from robsim.base.report import Column, Quantity, Report, Row, Table

if TYPE_CHECKING:
    from robsim.teach.assignments.results import SubmissionResult


@dataclass(frozen=True, kw_only=True)
class SubmissionReport(Report):
    """The result of a submission, for a prompt and a notebook."""

    of: SubmissionResult

    @property
    def title(self) -> str:
        return f"{self.of.student}, {self.of.title}"

    @property
    def quantities(self) -> Sequence[Quantity]:
        return (
            Quantity("points", "points", self.of.points, "", ".2f"),
            Quantity("most", "of", self.of.most, "", "g"),
        )

    @property
    def tables(self) -> Sequence[Table]:
        """The tests."""
        columns = (
            Column("points", "points", "", ".2f"),
            Column("most", "of", "", "g"),
            Column("status", "", ""),
            Column("sentence", "", ""),
        )
        rows = [
            Row(test.name, (test.points, test.most, test.status, test.sentence))
            for test in self.of.tests
        ]
        return (Table(key="tests", columns=columns, rows=rows, row_title="test"),)

    @property
    def remarks(self) -> Sequence[str]:
        """What was left out when it was read."""
        return self.of.notes
