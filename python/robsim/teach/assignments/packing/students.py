"""`pack_students`: what students get, as a zip or a folder."""

from __future__ import annotations

from os import PathLike
from pathlib import Path

from robsim.base.files import as_path
from robsim.base.text import one_line
from robsim.teach.assignments.assignment import Assignment, check_is_assignment
from robsim.teach.assignments.making import write_below
from robsim.teach.assignments.packing.gradescope import write_zip
from robsim.teach.assignments.packing.public_part import public_part


def pack_students(assignment: Assignment, path: str | PathLike[str]) -> Path:
    """Write what students get: sheet, files to begin with, public tests with their limits.

    They have an assignment of their own with it, without key, hidden tests and solutions: the
    numbers of the reference in the public runs stand in its ``limits.json``.

    Parameters
    ----------
    assignment : Assignment
        The assignment.
    path : path
        A zip, which is replaced, or a folder, which must not exist.

    Returns
    -------
    Path
        What was written.

    Raises
    ------
    AssignmentError
        If there is no public test, its limits are not calibrated, or something hidden would be in
        there.
    FileExistsError
        If there is such a folder.
    """
    check_is_assignment(assignment)
    target = as_path(path)
    files = public_part(assignment)
    if target.suffix == ".zip":
        write_zip(target, {f"{assignment.folder.name}/{name}": files[name] for name in files})
        return target
    try:
        target.mkdir(parents=True)
    except FileExistsError:
        raise FileExistsError(f"{one_line(target)} exists: give another name") from None
    write_below(target, files)
    return target
