"""`Assignment`: what is graded, by which rules, as its folder says."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from robsim.grading import Limits
from robsim.tasks._limit import Limit
from robsim.tasks._task import Task


@dataclass(frozen=True, kw_only=True)
class TaskTest:
    """A test of an assignment: a task, run some times, and its points.

    Attributes
    ----------
    name, title, number : str
        Its name in files and for the key, what it is for people, and its number such as "3.1".
    task : Task
        The task, with its parameters.
    points : float
        How many it gives.
    public : bool
        Whether students get it: they see its numbers and pictures, and can run it.
    limits : mapping of str to Limit
        Those of the scores, by name; empty until they are calibrated.
    """

    name: str
    title: str
    number: str = ""
    task: Task
    points: float
    public: bool = True
    limits: Mapping[str, Limit] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class FileTests:
    """Tests of the teacher's own: a file for pytest, whose functions have points.

    Attributes
    ----------
    path : Path
        The file.
    public : bool
        Whether students get it.
    """

    path: Path
    public: bool


@dataclass(frozen=True, kw_only=True)
class Assignment:
    """What is graded, by which rules: the content of a folder.

    Attributes
    ----------
    folder : Path
        The folder.
    name, title : str
        Its name, which the seeds come from, and its title.
    slots, imports, masked : tuple of str
        What a submission may fill, may import (None = all), and cannot have; as for
        `robsim.grading.Submission`.
    given : str
        What it gets at each step: ``"frames"``, ``"blobs"`` or ``"pose"``.
    own_seeds : bool
        Whether each student has scenarios of their own; else all have the same.
    isolation : str
        How submissions are shut in.
    limits : robsim.grading.Limits
        What a run may take.
    tests : tuple of TaskTest
        The tests by tasks.
    files : tuple of FileTests
        The teacher's own.
    """

    folder: Path
    name: str
    title: str
    slots: tuple[str, ...]
    imports: tuple[str, ...] | None = None
    masked: tuple[str, ...] = ()
    given: str
    own_seeds: bool = True
    isolation: str = "auto"
    limits: Limits = field(default_factory=Limits)
    tests: tuple[TaskTest, ...] = ()
    files: tuple[FileTests, ...] = ()
