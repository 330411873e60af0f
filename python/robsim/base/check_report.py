"""The report of a check: each problem, its place and its remedy; every `check_*` returns one."""

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
        The subject of the check.
    problems : tuple of Problem
        The problems, the cause first; mere consequences are left out.
    remarks : tuple of str
        Other observations.
    tables : tuple of Table
        Numbers for the problems and remarks.

    Examples
    --------
    >>> report = robsim.teach.check_estimator(lambda: lambda step: None)
    >>> bool(report)
    False
    """

    name: str
    problems: tuple[Problem, ...] = ()
    remarks: tuple[str, ...] = ()
    tables: tuple[Table, ...] = ()

    @property
    def ok(self) -> bool:
        """Whether the check found no problem."""
        return not self.problems

    def __bool__(self) -> bool:
        return self.ok

    @property
    def sentences(self) -> list[str]:
        """One sentence for each problem."""
        return [problem.sentence for problem in self.problems]

    @property
    def title(self) -> str:
        """The subject of the check."""
        return f"Check of {self.name}"

    @property
    def verdict(self) -> str:
        """Return ``"passed"`` or ``"failed"``."""
        return "passed" if self.ok else "failed"

    @property
    def headline(self) -> str:
        """The verdict in one line."""
        if self.ok:
            count = len(self.remarks)
            remarks = f", with {count} remark{'s' if count > 1 else ''}" if count else ""
            return f"{self.name} passed all checks{remarks}"
        count = len(self.problems)
        return f"{self.name} failed {count} check{'s' if count > 1 else ''}"

    def raise_for_problems(self) -> CheckReport:
        """Return the report if there are no problems; use it in tests.

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
