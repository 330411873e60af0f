"""`Assignment`: what is graded, by which rules, as its folder says."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path

from robsim.grading import Key, Limits
from robsim.tasks import Limit, Solution, Task

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
    reference : Solution or None
        What its scores are relative to; None in a folder for students.
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
    slots, imports, masked : tuple of str
        What a submission may fill, may import (None = all), and cannot have; as for
        `robsim.grading.Submission`.
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
    limits : robsim.grading.Limits
        What a run may take.
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
    imports: tuple[str, ...] | None = None
    masked: tuple[str, ...] = ()
    given: str
    given_files: Mapping[str, bytes] = field(default_factory=dict, repr=False)
    own_seeds: bool = True
    key: Key | None = None
    isolation: str = "auto"
    limits: Limits = field(default_factory=Limits)
    seconds: float = SECONDS
    tests: tuple[TaskTest, ...] = ()
    files: tuple[FileTests, ...] = ()

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
        from robsim.assignments._reading.assignment_file import read_assignment

        return read_assignment(folder)
