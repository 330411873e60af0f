"""A problem found by a check, and its place."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from robsim.base.source_line import SourceLine


@dataclass(frozen=True, kw_only=True)
class Problem:
    """A problem found by a check.

    Attributes
    ----------
    kind : str
        Short identifier for programs, such as ``"covariance not symmetric"``.
    sentence : str
        The problem and its remedy, for people.
    situation : str
        The robot's situation; empty if it does not matter.
    k : int or None
        The first step at which it occurred; None = not tied to a step.
    line : SourceLine or None
        The line that failed or that the problem concerns, or else the definition of the faulty
        function; None = unknown.

    Examples
    --------
    >>> [problem] = robsim.teach.check_estimator(lambda: lambda step: None).problems
    >>> problem.sentence
    'it returns None, not an Estimate: end with return robsim.Estimate(pose, covariance)'
    """

    kind: str
    sentence: str
    situation: str = ""
    k: int | None = None
    line: SourceLine | None = None

    @property
    def where(self) -> str:
        """Known step, situation and line."""
        step = "" if self.k is None else f"step {self.k}"
        when = ", ".join(part for part in (step, self.situation) if part)
        return "; ".join(part for part in (when, str(self.line or "")) if part)

    @property
    def code(self) -> str:
        """The text of the line; empty if it is not known."""
        return self.line.text if self.line else ""

    def to_dict(self) -> dict[str, Any]:
        """Return the values by name in a dict; two texts, place and source, represent the line."""
        return {
            "kind": self.kind,
            "sentence": self.sentence,
            "situation": self.situation,
            "k": self.k,
            "line": str(self.line) if self.line else None,
            "code": self.code or None,
        }

    def __str__(self) -> str:
        return f"{self.sentence} ({self.where})" if self.where else self.sentence
