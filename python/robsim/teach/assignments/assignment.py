"""`Assignment`: the tests and rules of a grading, from a folder."""

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

#: Whether hidden tests have seeds per student; public tests are the same for all.
SEEDS = ("student", "class")
#: The attributes that restrict a submission, see `robsim.teach.Submission`.
RULES = ("slots", "functions", "imports", "masked", "defaults")
#: Columns of the table of marks by hand.
BY_HAND = ("student", "late_days", "points", "comment")
#: Maximum duration of a submission's tests (s): Gradescope's 10 minutes less one.
SECONDS = 540.0


@dataclass(frozen=True, kw_only=True)
class TaskTest:
    """A test of an assignment: a task, which is run several times, and its points.

    Attributes
    ----------
    name, title, number : str
        Its name in files and for the key, its title for people, and its number such as "3.1".
    task : Task
        The task, with its parameters.
    points : float
        Its points.
    public : bool
        Whether students get it: they see its numbers and pictures, and can run it. The seeds of a
        public test come from the public key, which is the same for all students.
    limits : mapping of str to ScoreLimit
        The limits of its scores, by name; empty before the calibration.
    stale : str
        The reason why the limits do not fit this task or these solutions; "" = they fit, or
        unknown.
    provisional : str
        The reason why the limits are provisional; "" = they are exact.
    reference : Solution or None
        The solution that its scores are relative to.
    reference_values : mapping of str to tuple of float
        The numbers of the reference in each run, by score. Only public tests in a folder for
        students have these numbers.

    Examples
    --------
    >>> test = robsim.teach.new_assignment("park", "hw1", seed=1).tests[0]
    >>> test.task.name, test.points
    ('park', 3.0)
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
    """Tests of the teacher: a pytest file with points for its test functions.

    Attributes
    ----------
    path : Path
        The file.
    public : bool
        Whether students get the file.

    Examples
    --------
    >>> assignment = robsim.teach.new_assignment("park", "hw1", seed=1)
    >>> [(tests.path.name, tests.public) for tests in assignment.files]
    [('own_tests.py', True)]
    """

    path: Path
    public: bool


@dataclass(frozen=True, kw_only=True)
class LateRule:
    """The rule for late days.

    Attributes
    ----------
    per_day : float
        The share of the points that a day costs, 0 to 1.
    free_days, most_days : float
        The number of days without a cost, and the number after which a submission has no points.

    Examples
    --------
    >>> rule = robsim.teach.LateRule(per_day=0.1, free_days=1.0, most_days=3.0)
    >>> rule.free_days
    1.0
    """

    per_day: float
    free_days: float = 0.0
    most_days: float = math.inf


@dataclass(frozen=True, kw_only=True)
class Assignment:
    """The tests and the grading rules of an assignment, read from its folder.

    Attributes
    ----------
    folder : Path
        The folder.
    name, title : str
        Its name, and its title.
    slots, functions, imports, masked : tuple of str
        The slots that a submission may fill, the functions for the teacher's own tests, the
        allowed imports (None = all), and the forbidden names; see `robsim.teach.Submission`.
    defaults : bool
        Whether stages and objects of robsim may fill slots; else a slot counts as empty.
    given : str
        The submission's input at each step: ``"frames"``, ``"blobs"`` or ``"pose"``.
    given_files : mapping of str to bytes
        Files for each submission when it runs, by name: the files of ``given/``.
    own_seeds : bool
        Whether each student has separate scenarios in hidden tests; else all have the same.
    key : Key or None
        The source of the seeds of hidden tests; None = no key.
    isolation : str
        The isolation of submissions.
    limits : robsim.teach.WorkerLimits
        The limits of a run.
    points : float or None
        The points of all tests, also outside this folder; None = unknown.
    seconds : float
        The time limit for all tests of a submission (s).
    tests : tuple of TaskTest
        The tests by tasks.
    files : tuple of FileTests
        The teacher's own tests.
    hidden_from : datetime or None
        The time from which hidden tests run.
    late : LateRule or None
        The rule for late days.
    by_hand : mapping of str to float
        Maximum points that a teacher gives by hand, such as for style, by name.
    leaderboard : str
        The score on Gradescope's leaderboard, ``"TEST.SCORE"``; "" = there is no leaderboard.

    Examples
    --------
    >>> assignment = robsim.teach.new_assignment("park", "hw1", seed=1)
    >>> [(test.name, test.points, test.public) for test in assignment.tests]
    [('public', 3.0, True), ('hidden', 6.0, False)]
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
        """The tests with tasks, then the teacher's own test files, in the order of execution."""
        return (*self.tests, *self.files)

    @property
    def files_of_all(self) -> Mapping[str, bytes]:
        """The files for submissions: the given files, and the module ``task``.

        Here the module ``task`` has the values of the first test with a task. During grading, each
        test uses its own values.
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
