"""`Task`: what students are asked to do, and how a run of it is scored."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any, ClassVar

from robsim.simulation import Scenario
from robsim.tasks._score import Score
from robsim.trace import Trace


@dataclass(frozen=True, kw_only=True)
class Task(ABC):
    """Something to do for students: a world, what they write, and scores of their runs.

    A subclass is a dataclass whose fields are what can be set, such as a goal or the noise: a
    value, which can be compared, sent to other processes, and written in an assignment by name.

    Attributes
    ----------
    name : str
        Its name in commands and files.
    title : str
        What is to be done, in a line.
    slots : tuple of str
        The slots that a solution fills.
    given : str
        What a solution gets at each step: ``"frames"``, ``"blobs"`` (no frame), ``"pose"`` (the
        measurement alone).
    scores : tuple of Score
        The numbers of a run; their shares sum to 1.
    steps : int
        Number of steps of a run.
    runs : int
        Number of runs of a test.
    """

    name: ClassVar[str]
    title: ClassVar[str]
    slots: ClassVar[tuple[str, ...]]
    given: ClassVar[str]
    scores: ClassVar[tuple[Score, ...]]

    steps: int = 60
    runs: int = 10

    @property
    @abstractmethod
    def scenario(self) -> Scenario:
        """The world of its runs, without a seed."""

    @property
    @abstractmethod
    def values(self) -> Mapping[str, Any]:
        """What a solution is told: the names in its module ``task``, ``from task import GOAL``."""

    @property
    @abstractmethod
    def sheet(self) -> str:
        """What students read, with these values, in Markdown."""

    @abstractmethod
    def score(self, trace: Trace) -> dict[str, float]:
        """Return the numbers of a run by the names of `scores`; NaN where there is none."""

    @property
    def parameters(self) -> dict[str, Any]:
        """What was set, by name: ``type(task)(**task.parameters) == task``."""
        return {field.name: getattr(self, field.name) for field in fields(self)}
