"""`Assignment`: what is graded, by which rules, as its folder says."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from concurrent.futures import Executor
from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

from robsim.campaigns.engines.executors import DaskClient
from robsim.teach.assignments.results import SubmissionResult
from robsim.teach.grading.keys import Key
from robsim.teach.grading.task import Frames, rules_of
from robsim.teach.isolation.limits import Limits
from robsim.teach.submissions import Rules
from robsim.teach.tasks.definition import Task
from robsim.teach.tasks.score import Limit
from robsim.teach.tasks.solutions import MODULE, Solution, module_source

if TYPE_CHECKING:
    from robsim.teach.assignments.class_result import ClassResult
    from robsim.teach.assignments.grading.playing import PlayedRun

#: Who has the public tests has their key, too: they are the same for all.
SEEDS = ("student", "class")
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
    limits : mapping of str to Limit
        Those of the scores, by name; empty until they are calibrated.
    stale : str
        Why the limits were not calibrated for this task, or these solutions; "" = they were, or
        nobody knows.
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
    limits: Mapping[str, Limit] = field(default_factory=dict)
    stale: str = ""
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
    limits : robsim.teach.Limits
        What a run may take.
    points : float or None
        How many all tests give together, also those that are not in this folder; None = not known.
    seconds : float
        What all tests of a submission may take together (s).
    tests : tuple of TaskTest
        The tests by tasks.
    files : tuple of FileTests
        The teacher's own.
    """

    folder: Path
    name: str
    title: str
    slots: tuple[str, ...]
    functions: tuple[str, ...] = ()
    imports: tuple[str, ...] | None = None
    masked: tuple[str, ...] = ()
    given: str
    given_files: Mapping[str, bytes] = field(default_factory=dict, repr=False)
    own_seeds: bool = True
    key: Key | None = None
    isolation: str = "auto"
    limits: Limits = field(default_factory=Limits)
    points: float | None = None
    seconds: float = SECONDS
    tests: tuple[TaskTest, ...] = ()
    files: tuple[FileTests, ...] = ()

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
        """What a submission may see of the frames."""
        return "blobs" if self.given == "blobs" else self.given == "frames"

    def _rules(self, slots: tuple[str, ...] | None = None) -> Rules:
        """Return what a submission may fill, which is all or some slots alone, import and weigh.

        Raises
        ------
        TypeError, ValueError
            If there are no such slots, functions or modules.
        """
        functions = self.functions if slots is None else ()
        wanted = self.slots if slots is None else slots
        return rules_of(wanted, functions, self.imports, self.masked, self.limits)

    @classmethod
    def load(cls, folder: str | PathLike[str]) -> Assignment:
        """Read the folder of an assignment; nothing in it is run.

        Parameters
        ----------
        folder : path
            The folder, with ``assignment.toml`` and, as far as there are such, ``limits.json``,
            ``key``, ``given/`` and, for each kind of task, ``solutions/TASK/right`` and
            ``wrong``. Without these solutions those that ship with robsim are the references.

        Raises
        ------
        AssignmentError
            If something in it is missing or wrong; the message names file and key.
        TypeError
            If `folder` is not a path.
        """
        from robsim.teach.assignments.assignment_file import read_assignment

        return read_assignment(folder)

    def grade(
        self,
        submission: str | PathLike[str],
        *,
        student: str | None = None,
        public: bool = False,
        only: Iterable[str] | None = None,
    ) -> SubmissionResult:
        """Grade a submission.

        Parameters
        ----------
        submission : path
            A folder, a Python file, a notebook, or a zip of these.
        student : str, optional
            The student's name, which the worlds of tests that are not public come from. Default:
            that of the folder or file, without its ending.
        public : bool
            Only the tests that students have, too.
        only : sequence of str, optional
            The names of the tests to run. Default: all.

        Returns
        -------
        SubmissionResult
            Points, sentences and numbers. What is the submission's fault is in it; a test that
            failed by a fault of others has the status ``"error"``.

        Raises
        ------
        AssignmentError
            If the assignment is not complete, or broken: nothing is run then.
        FileNotFoundError
            If there is no such submission.
        TypeError, ValueError
            If an argument is wrong; the message names it.
        """
        from robsim.teach.assignments.classes.class_run import grade_one

        return grade_one(self, submission, student=student, public=public, only=only)

    def grade_class(
        self,
        submissions: str | PathLike[str],
        out: str | PathLike[str],
        *,
        executor: int | str | Executor | DaskClient | None = None,
        public: bool = False,
        only: Iterable[str] | None = None,
    ) -> ClassResult:
        """Grade a class, and write what came of it.

        Results are written after each test. What `out` has already of submissions and tests that
        have not changed is not run again: the same call goes on where one was ended.

        Parameters
        ----------
        submissions : path
            The folder with the submissions.
        out : path
            The folder for the results: one for each student, and those of the class.
        executor : int, "threads", concurrent.futures.Executor or Dask Client, optional
            What grades, as for `robsim.campaign`: so many processes, or others, which must see the
            same folders. Default: this process.
        public, only
            As for `grade`.

        Returns
        -------
        ClassResult
            The results of all.

        Raises
        ------
        AssignmentError, FileNotFoundError, TypeError, ValueError
            As `grade`.
        OSError
            If a result cannot be written.
        """
        from robsim.teach.assignments.classes.class_run import grade_class

        return grade_class(self, submissions, out, executor=executor, public=public, only=only)

    def regrade(self, out: str | PathLike[str]) -> ClassResult:
        """Mark results anew, after limits or points of this assignment have changed.

        Nothing is run: the numbers of the runs are those in the folder.

        Parameters
        ----------
        out : path
            The folder that `grade_class` has written, whose files are written anew.

        Returns
        -------
        ClassResult
            The results of all.

        Raises
        ------
        AssignmentError
            If the assignment is not complete, or broken.
        FileNotFoundError
            If there are no results.
        ValueError
            If more than limits and points has changed: nothing is written then.
        """
        from robsim.teach.assignments.classes.class_run import regrade

        return regrade(self, out)

    def play(
        self,
        submission: str | PathLike[str],
        test: str,
        run: int,
        *,
        student: str | None = None,
    ) -> PlayedRun:
        """Do a run of a test again, for an appeal: the same world, noise and numbers.

        Parameters
        ----------
        submission : path
            What was handed in.
        test : str
            The name of the test.
        run : int
            The number of the run, from 0.
        student : str, optional
            As for `grade`.

        Returns
        -------
        PlayedRun
            The run with its trace, beside that of the reference.

        Raises
        ------
        SubmissionError
            If the submission fails before there is a step, with slot and line. Where it fails
            later, the run is what there is of it: its `failed` says why.
        AssignmentError, FileNotFoundError, TypeError, ValueError
            As `grade`.
        """
        from robsim.teach.assignments.grading.playing import play

        return play(self, submission, test, run, student)
