"""`pack_students`, `pack_feedback`: the students' files before and after the grading."""

from __future__ import annotations

from os import PathLike
from pathlib import Path

from robsim.base.checks import check_kind
from robsim.base.files import as_path
from robsim.base.text import listed, one_line
from robsim.base.warn import warn_user
from robsim.teach.assignments.assignment import Assignment, check_is_assignment
from robsim.teach.assignments.assignment_file import FILE
from robsim.teach.assignments.class_result import ClassResult
from robsim.teach.assignments.making import write_below
from robsim.teach.assignments.packing.gradescope import write_zip
from robsim.teach.assignments.packing.public_part import public_part
from robsim.teach.assignments.sheet import SHEET, compare_sheet
from robsim.teach.errors import AssignmentError
from robsim.teach.reports.words import OF_MOODLE
from robsim.teach.reports.writing import PAGE, TEXT, folder_name


def pack_students(assignment: Assignment, path: str | PathLike[str]) -> Path:
    """Write the students' files: the sheet, initial files, and the public tests with their limits.

    The files form an assignment without the key, hidden tests and solutions. Its ``limits.json``
    has the numbers of the reference in the public runs.

    Parameters
    ----------
    assignment : Assignment
        The assignment.
    path : path
        A zip, which is overwritten, or a folder, which must not exist.

    Returns
    -------
    Path
        The zip or the folder.

    Raises
    ------
    AssignmentError
        If the assignment has no public test, its limits are not calibrated for it, or a hidden part
        would be public. If the sheet has other numbers than the tests.
    FileExistsError
        If the folder exists.

    Examples
    --------
    >>> assignment = robsim.teach.new_assignment("park", "hw1", seed=1)
    >>> robsim.teach.pack_students(assignment, "hw1.zip").name
    'hw1.zip'
    """
    check_is_assignment(assignment)
    target = as_path(path)
    files = public_part(assignment)
    if wrong := compare_sheet(assignment)[0]:
        raise AssignmentError(f"{SHEET} differs from {FILE}: {wrong}", file=SHEET)
    if target.suffix == ".zip":
        write_zip(target, {f"{assignment.folder.name}/{name}": files[name] for name in files})
        return target
    try:
        target.mkdir(parents=True)
    except FileExistsError:
        raise FileExistsError(f"{one_line(target)} exists: give another name") from None
    write_below(target, files)
    return target


def pack_feedback(result: ClassResult, out: str | PathLike[str], path: str | PathLike[str]) -> Path:
    """Write the pages of students, without hidden parts, into one zip.

    If Moodle has named the submissions, it accepts this zip (Upload multiple feedback files in a
    zip). Other students get a folder with their name.

    Parameters
    ----------
    result : ClassResult
        The class.
    out, path : path
        The folder with its results, and the zip; an old zip is overwritten.

    Raises
    ------
    OSError
        If a page is missing, or the zip cannot be written.

    Warns
    -----
    UserWarning
        If only some folders have names from Moodle.

    Examples
    --------
    >>> import pathlib
    >>> assignment = robsim.teach.new_assignment("measure", "hw1", seed=1)
    >>> pathlib.Path("class/ann").mkdir(parents=True)
    >>> size = pathlib.Path("class/ann/measure.py").write_text("def measure(step): return None")
    >>> graded = robsim.teach.grade_class(assignment, "class", "marks", public=True)
    >>> robsim.teach.pack_feedback(graded, "marks", "feedback.zip").name
    'feedback.zip'
    """
    check_kind("result", result, ClassResult)
    place, target = as_path(out, "out"), as_path(path)
    students = [name for one in result.results for name in one.members or [one.student]]
    of_moodle = [name for name in students if OF_MOODLE.fullmatch(name)]
    if of_moodle and (others := [name for name in students if name not in of_moodle]):
        warn_user(
            f"Moodle does not know the folders of {listed(others)} in {one_line(target)}: use its "
            f"grading worksheet with a column group as groups.csv, and grade again"
        )
    files = {
        f"{_recipient(student)}/{name}": (place / folder_name(one.student) / name).read_bytes()
        for one in result.results
        for student in one.members or [one.student]
        for name in (PAGE, TEXT)
    }
    write_zip(target, files)
    return target


def _recipient(student: str) -> str:
    """Return the folder of a student in the zip."""
    match = OF_MOODLE.fullmatch(student)
    if match is None:
        return folder_name(student)
    end = f"_{match['number']}_assignsubmission_file_"  # Moodle reads the part after the first "_"
    named = match["name"].replace("_", " ") + end
    return named if folder_name(named) == named else f"student{end}"
