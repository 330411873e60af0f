"""`Assignment`: what is graded, by which rules, as its folder says."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path
from typing import Any

from robsim.base.checks import check_kind
from robsim.teach.grading.keys import Key
from robsim.teach.grading.task import Frames, rules_of
from robsim.teach.isolation.limits import Isolation, WorkerLimits
from robsim.teach.submissions import Rules
from robsim.teach.tasks.definition import Task
from robsim.teach.tasks.score import ScoreLimit
from robsim.teach.tasks.solutions import MODULE, Solution, module_source

#: Who has the public tests has their key, too: they are the same for all.
SEEDS = ("student", "class")
#: The attributes that bound a submission, as of `robsim.teach.Submission`.
RULES = ("slots", "functions", "imports", "masked", "defaults")
#: Columns of the table of marks by hand.
BY_HAND = ("student", "late_days", "points", "comment")
#: s that the tests of a submission may take: Gradescope's 10 minutes less one.
SECONDS = 540.0


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
        Whether students get it: they see its numbers and pictures, and can run it. Its seeds are
        those of the public key, the same for all.
    limits : mapping of str to ScoreLimit
        Those of the scores, by name; empty until they are calibrated.
    stale : str
        Why the limits were not calibrated for this task, or these solutions; "" = they were, or
        nobody knows.
    provisional : str
        Why the limits are provisional; "" = they are not.
    reference : Solution or None
        What its scores are relative to.
    reference_values : mapping of str to tuple of float
        The numbers of the reference in each run, by score, of a public test in a folder for
        students; empty elsewhere.
    """

    name: str
    title: str
    number: str = ""
    task: Task
    points: float
    public: bool = True
    limits: Mapping[str, ScoreLimit] = field(default_factory=dict)
    stale: str = ""
    provisional: str = ""
    reference: Solution | None = field(default=None, repr=False)
    reference_values: Mapping[str, tuple[float, ...]] = field(default_factory=dict, repr=False)


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
class LateRule:
    """The rule for late days.

    Attributes
    ----------
    per_day : float
        The share of the points that a day takes, 0 to 1.
    free_days, most_days : float
        How many days take nothing, and after how many there are no points.
    """

    per_day: float
    free_days: float = 0.0
    most_days: float = math.inf


@dataclass(frozen=True, kw_only=True)
class Assignment:
    """What is graded, by which rules: the content of a folder.

    Attributes
    ----------
    folder : Path
        The folder.
    name, title : str
        Its name, and its title.
    slots, functions, imports, masked : tuple of str
        What a submission may fill, may define for the teacher's own tests, may import (None = all),
        and cannot have; as for `robsim.teach.Submission`.
    defaults : bool
        Whether stages and objects of robsim may fill slots; else they are not handed in.
    given : str
        What it gets at each step: ``"frames"``, ``"blobs"`` or ``"pose"``.
    given_files : mapping of str to bytes
        What lies beside each submission when it is run, by name: the files of ``given/``.
    own_seeds : bool
        Whether each student has scenarios of their own in tests that are not public; else all
        have the same.
    key : Key or None
        What the seeds of tests that are not public come from; None = there is none.
    isolation : str
        How submissions are shut in.
    limits : robsim.teach.WorkerLimits
        What a run may take.
    points : float or None
        How many all tests give together, also those that are not in this folder; None = not known.
    seconds : float
        What all tests of a submission may take together (s).
    tests : tuple of TaskTest
        The tests by tasks.
    files : tuple of FileTests
        The teacher's own.
    hidden_from : datetime or None
        The time until which hidden tests are not run.
    late : LateRule or None
        The rule for late days.
    by_hand : mapping of str to float
        Points that a teacher gives, such as those for style, by name: how many there are.
    leaderboard : str
        The score on Gradescope's leaderboard, ``"TEST.SCORE"``; "" = there is no leaderboard.
    """

    folder: Path
    name: str
    title: str
    slots: tuple[str, ...]
    functions: tuple[str, ...] = ()
    imports: tuple[str, ...] | None = None
    masked: tuple[str, ...] = ()
    defaults: bool = False
    given: str
    given_files: Mapping[str, bytes] = field(default_factory=dict, repr=False)
    own_seeds: bool = True
    key: Key | None = None
    isolation: Isolation = "auto"
    limits: WorkerLimits = field(default_factory=WorkerLimits)
    points: float | None = None
    seconds: float = SECONDS
    tests: tuple[TaskTest, ...] = ()
    files: tuple[FileTests, ...] = ()
    hidden_from: datetime | None = None
    late: LateRule | None = None
    by_hand: Mapping[str, float] = field(default_factory=dict)
    leaderboard: str = ""

    @property
    def all_tests(self) -> tuple[TaskTest | FileTests, ...]:
        """Those by tasks, and files of the teacher's own, in the order in which they are run."""
        return (*self.tests, *self.files)

    @property
    def files_of_all(self) -> Mapping[str, bytes]:
        """What lies beside a submission: the given files, and the module ``task``.

        Its values are those of the first test by a task, but in the other tests by tasks.
        """
        task = {f"{MODULE}.py": module_source(test.task) for test in self.tests[:1]}
        return {**self.given_files, **task}

    @property
    def _frames(self) -> Frames:
        return "blobs" if self.given == "blobs" else self.given == "frames"

    def _rules(self, slots: tuple[str, ...] | None = None) -> Rules:
        """Return the rules of a submission for all or some slots; raise TypeError or ValueError."""
        functions = self.functions if slots is None else ()
        wanted = self.slots if slots is None else slots
        return rules_of(wanted, functions, self.imports, self.masked, self.defaults, self.limits)


def check_is_assignment(assignment: Any) -> None:
    check_kind("assignment", assignment, Assignment)
