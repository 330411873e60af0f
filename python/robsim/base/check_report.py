"""The report of a check: what is wrong, where, and how to fix it; every `check_*` returns it."""

from __future__ import annotations

from dataclasses import dataclass

from robsim.base.report import Problem, Report, Table

__all__ = ["CheckReport", "Problem"]


@dataclass(frozen=True, kw_only=True)
class CheckReport(Report):
    """The result of a check. ``bool(report)`` is `ok`.

    Attributes
    ----------
    name : str
        What was checked.
    problems : tuple of Problem
        What is wrong, the cause first; mere consequences of it are left out.
    remarks : tuple of str
        Observations that are not problems.
    tables : tuple of Table
        Numbers to go with them.
    """

    name: str
    problems: tuple[Problem, ...] = ()
    remarks: tuple[str, ...] = ()
    tables: tuple[Table, ...] = ()

    @property
    def ok(self) -> bool:
        """Whether nothing is wrong."""
        return not self.problems

    def __bool__(self) -> bool:
        return self.ok

    @property
    def sentences(self) -> list[str]:
        """One sentence for each problem."""
        return [problem.sentence for problem in self.problems]

    @property
    def title(self) -> str:
        """What was checked."""
        return f"Check of {self.name}"

    @property
    def verdict(self) -> str:
        """Return ``"passed"`` or ``"failed"``."""
        return "passed" if self.ok else "failed"

    @property
    def headline(self) -> str:
        """The verdict in one line."""
        if self.ok:
            return f"{self.name} passed all checks"
        count = len(self.problems)
        return f"{self.name} failed {count} check{'s' if count > 1 else ''}"

    def raise_for_problems(self) -> CheckReport:
        """Return the report if there are no problems; for use in tests.

        Raises
        ------
        AssertionError
            If there are problems; the message lists all of them.
        """
        if self.problems:
            raise AssertionError(str(self))
        return self

    def __repr__(self) -> str:
        # pytest shows this where `assert report` fails, and elides the middle of a long one.
        return f"<{'; '.join(map(str, self.problems)) or self.headline}>"
