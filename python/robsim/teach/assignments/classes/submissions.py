"""What there is to grade: a class of submissions, or a single one."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from os import PathLike
from pathlib import Path

from robsim.base.files import as_path
from robsim.base.text import listed, one_line, quoted
from robsim.simulation.slots import SLOTS
from robsim.teach.assignments.assignment import Assignment
from robsim.teach.errors import AssignmentError, SubmissionError
from robsim.teach.submissions import read_submission
from robsim.teach.submissions.folder import ARCHIVES
from robsim.teach.tasks.solutions import MODULE

_FORMS = (".zip", ".py", ".ipynb")
_SENT = (*_FORMS, *ARCHIVES)  # other archives than zips are refused in a sentence


@dataclass(frozen=True)
class Handed:
    """What a student has handed in: the name, which is that of its folder or file, and its path."""

    student: str
    path: str


def one_submission(path: str | PathLike[str], name: str = "submission") -> Handed:
    """Return a submission by its path, which may end in the student's name without a file's suffix.

    Messages call the argument `name`. Raise FileNotFoundError if it is missing.
    """
    place = Path(os.path.abspath(as_path(path, name)))
    if not os.path.lexists(place):
        found = [file for form in _FORMS if (file := Path(f"{place}{form}")).is_file()]
        if len(found) != 1:
            raise FileNotFoundError(2, "there is no such submission", str(path))
        (place,) = found
    return Handed(_student_of(place), str(place))


def check_is_one(handed: Handed, assignment: Assignment) -> None:
    """Raise ValueError for a folder that is no submission, but has those of a class."""
    try:
        found = submissions_in(handed.path, assignment)
    except FileNotFoundError:  # it is empty
        return
    if len(found) == 1:
        return
    is_read = [_can_be_read(one, assignment) for one in found]
    if sum(is_read) > 1 or not _can_be_read(handed, assignment):
        folder = Path(handed.path).name
        raise ValueError(
            f"{one_line(folder)} is no submission, but has {len(found)}: name one of them, such as "
            f"{one_line(folder)}/{one_line(Path(found[0].path).name)}"
        )


def _can_be_read(handed: Handed, assignment: Assignment) -> bool:
    try:
        read_submission(handed.path, assignment._rules(), assignment.files_of_all)
    except SubmissionError:
        return False
    return True


def submissions_in(
    path: str | PathLike[str],
    assignment: Assignment,
    tell: Callable[[str], None] = lambda sentence: None,
) -> list[Handed]:
    """Return all submissions of a folder by name, or the only one of a path.

    A folder is one submission if it has a file of a slot, or a given file. `tell` gets a sentence
    on other files. Raise FileNotFoundError for an empty folder, AssignmentError with all impossible
    names and all students with several submissions.
    """
    first = one_submission(path, "submissions")
    place = Path(first.path)
    given = {*assignment.given_files, f"{MODULE}.py", *(f"{slot}.py" for slot in SLOTS)}
    if not place.is_dir() or any((place / name).is_file() for name in given):
        return [first]
    # Hidden files are those of tools.
    names = [name for name in sorted(os.listdir(place)) if not name.startswith((".", "__"))]
    found: dict[str, list[str]] = {}
    others = []
    for name in names:
        if (place / name).is_file() and not name.lower().endswith(_SENT):
            others.append(name)
        else:
            found.setdefault(_student_of(place / name), []).append(name)
    if not found:
        raise FileNotFoundError(2, "there are no submissions in this folder", str(path))
    if others:
        tell(f"not graded, because they are no submissions: {listed(others)}")
    problems = problems_of_names(found) + [
        f"{len(files)} submissions of {student}, {listed(files)}: keep the one that counts"
        for student, files in found.items()
        if len(files) > 1
    ]
    if problems:
        raise AssignmentError("; ".join(problems))
    return [Handed(student, str(place / found[student][0])) for student in sorted(found)]


def problems_of_names(students: Iterable[str]) -> list[str]:
    """Return a sentence for each name that no folder can have."""
    return [
        f"no submission can have the name {quoted(student)}: rename it"
        for student in students
        if student in ("", ".", "..") or "/" in student or "\\" in student
    ]


def _student_of(path: Path) -> str:
    is_packed = path.suffix.lower() in _SENT and not path.is_dir()
    return one_line(path.stem if is_packed else path.name)
