"""What there is to grade: a class of submissions, or a single one."""

from __future__ import annotations

import os
from collections.abc import Iterable
from dataclasses import dataclass
from os import PathLike
from pathlib import Path

from robsim._base.files import as_path
from robsim._base.text import listed, one_line
from robsim.assignments._assignment import Assignment
from robsim.grading import AssignmentError
from robsim.simulation._slots import SLOTS
from robsim.tasks._solutions import MODULE

_FORMS = (".zip", ".py", ".ipynb")


@dataclass(frozen=True)
class Handed:
    """What a student has handed in: the name, which is that of its folder or file, and its path."""

    student: str
    path: str


def one_submission(path: str | PathLike[str], name: str = "submission") -> Handed:
    """Return a submission by its path; raise FileNotFoundError if there is none.

    Messages call the argument `name`.
    """
    place = Path(os.path.abspath(as_path(path, name)))
    if not os.path.lexists(place):
        raise FileNotFoundError(2, "there is no such submission", str(path))
    return Handed(_student_of(place), str(place))


def submissions_in(path: str | PathLike[str], assignment: Assignment) -> list[Handed]:
    """Return all submissions of a folder by name; of a path that is one submission, that one.

    A folder is one submission if there is a file of a slot in it, or one that is given to all.

    Raises
    ------
    FileNotFoundError
        If there is nothing.
    AssignmentError
        If two are of one student.
    """
    first = one_submission(path, "submissions")
    place = Path(first.path)
    if not place.is_dir() or _is_one(place, assignment):
        return [first]
    # Hidden files are those of tools.
    names = [name for name in sorted(os.listdir(place)) if not name.startswith((".", "__"))]
    if not names:
        raise FileNotFoundError(2, "there are no submissions in this folder", str(path))
    return sorted(_each_once(_handed(place / name) for name in names), key=lambda h: h.student)


def _is_one(folder: Path, assignment: Assignment) -> bool:
    given = {*assignment.given_files, f"{MODULE}.py", *(f"{slot}.py" for slot in SLOTS)}
    return any((folder / name).is_file() for name in given)


def _handed(path: Path) -> Handed:
    return Handed(_student_of(path), str(path))


def _student_of(path: Path) -> str:
    is_packed = path.suffix.lower() in _FORMS and not path.is_dir()
    return one_line(path.stem if is_packed else path.name)


def _each_once(found: Iterable[Handed]) -> Iterable[Handed]:
    seen: dict[str, Handed] = {}
    for handed in found:
        if handed.student in seen:
            names = [Path(one.path).name for one in (seen[handed.student], handed)]
            raise AssignmentError(
                f"two submissions of {handed.student}, {listed(names)}: keep the one that counts"
            )
        seen[handed.student] = handed
        yield handed
