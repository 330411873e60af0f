"""The tests in a file of the teacher's, with their points."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from robsim.teach.assignments.results import TestResult


@dataclass(frozen=True, kw_only=True)
class OwnTest:
    """A function of a file for pytest that is a test of an assignment.

    Attributes
    ----------
    name : str
        Its name, for pytest.
    title : str
        What it is for people: the first line of its docstring, else its name.
    points : float
        How many it gives.
    public : bool
        Whether students get it.
    success, failure : str
        What to tell the student; "" = what comes.
    """

    name: str
    title: str
    points: float
    public: bool
    success: str = ""
    failure: str = ""

    def to_dict(self) -> dict[str, Any]:
        return asdict(self)

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> OwnTest:
        return cls(**data)

    def result(self, status: str, sentence: str, *, points: float = 0.0, **more: Any) -> TestResult:
        return TestResult(
            name=self.name,
            title=self.title,
            public=self.public,
            points=points,
            most=self.points,
            status=status,
            sentence=sentence,
            **more,
        )
