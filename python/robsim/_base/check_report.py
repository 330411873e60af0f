"""The report of a check: what is wrong, where, and how to fix it; every `check_*` returns it."""

from __future__ import annotations

from dataclasses import dataclass
from html import escape

from robsim._base.source_line import SourceLine


@dataclass(frozen=True, kw_only=True)
class Problem:
    """Something that a check found wrong.

    Attributes
    ----------
    kind : str
        Short identifier for programs, such as ``"asymmetric covariance"``.
    sentence : str
        What is wrong and how to fix it, for people.
    situation : str
        What the robot was doing; empty if it does not matter.
    k : int or None
        The first step at which it occurred; None = not tied to a step.
    line : SourceLine or None
        The line that failed, or the definition of the faulty function; None = unknown.
    """

    kind: str
    sentence: str
    situation: str = ""
    k: int | None = None
    line: SourceLine | None = None

    @property
    def where(self) -> str:
        """Step, situation and line, as far as they are known."""
        step = "" if self.k is None else f"step {self.k}"
        when = ", ".join(part for part in (step, self.situation) if part)
        return "; ".join(part for part in (when, str(self.line or "")) if part)

    def __str__(self) -> str:
        return f"{self.sentence} ({self.where})" if self.where else self.sentence


@dataclass(frozen=True, kw_only=True)
class CheckReport:
    """The result of a check. ``bool(report)`` is `ok`.

    Attributes
    ----------
    name : str
        What was checked.
    problems : tuple of Problem
        What is wrong, the cause first; mere consequences of it are left out.
    remarks : tuple of str
        Observations that are not problems.
    """

    name: str
    problems: tuple[Problem, ...] = ()
    remarks: tuple[str, ...] = ()

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
        """The verdict in one line."""
        if not self.problems:
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

    def __str__(self) -> str:
        lines = [self.title]
        for number, problem in enumerate(self.problems, 1):
            lines.append(f"  {number}. {problem}")
            if problem.line and problem.line.text:
                lines.append(f"     > {problem.line.text}")
        return "\n".join([*lines, *(f"  Remark: {remark}" for remark in self.remarks)])

    def __repr__(self) -> str:
        # pytest shows this where `assert report` fails, and elides the middle of a long one.
        return f"<{'; '.join(map(str, self.problems)) or self.title}>"

    def _repr_html_(self) -> str:
        items = "".join(
            f"<li>{escape(problem.sentence)}{_where(problem)}{_code(problem.line)}</li>"
            for problem in self.problems
        )
        remarks = "".join(f"<p>Remark: {escape(remark)}</p>" for remark in self.remarks)
        return f"<p><b>{escape(self.title)}</b></p><ol>{items}</ol>{remarks}"


def _where(problem: Problem) -> str:
    return f"<br><small>{escape(problem.where)}</small>" if problem.where else ""


def _code(line: SourceLine | None) -> str:
    return f"<br><code>{escape(line.text)}</code>" if line and line.text else ""
