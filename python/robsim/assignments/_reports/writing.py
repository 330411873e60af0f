"""Writing the reports of a submission and of a class into folders."""

from __future__ import annotations

from collections.abc import Mapping
from os import PathLike
from pathlib import Path

from robsim._base.files import as_folder, write_whole
from robsim.assignments._reports.pages.student import student_page
from robsim.assignments._reports.student_text import student_text
from robsim.assignments._reports.views import for_student
from robsim.assignments._results import SubmissionResult

RESULT, PAGE, TEXT, TEACHERS = "result.json", "index.html", "result.txt", "teacher.html"


def write_student(
    folder: str | PathLike[str],
    result: SubmissionResult,
    *,
    pictures: Mapping[str, bytes] | None = None,
) -> None:
    """Write the reports of a submission: each file whole, or as it was.

    ``index.html`` and ``result.txt`` are for the student: of hidden tests they have points and a
    sentence. ``teacher.html`` and ``result.json`` have all, and pictures lie beside them by the
    names of their tests.

    Parameters
    ----------
    folder : path
        The folder of this submission; made if there is none.
    result : SubmissionResult
        What came of it so far.
    pictures : mapping of str to bytes, optional
        New pictures as PNG by the names of their tests, which `result` has the files of. Others
        are read from the folder.

    Raises
    ------
    OSError
        If a file cannot be written.
    """
    folder = as_folder(folder)
    folder.mkdir(parents=True, exist_ok=True)
    files = {test.name: test.picture for test in result.tests if test.picture}
    for name, png in (pictures or {}).items():
        write_whole(folder / files[name], png)
    found = {name: png for name, file in files.items() if (png := _read(folder / file))}
    theirs = for_student(result)
    write_whole(folder / PAGE, _utf8(student_page(theirs, found)))
    write_whole(folder / TEXT, _utf8(student_text(theirs)))
    write_whole(folder / TEACHERS, _utf8(student_page(result, found, for_teacher=True)))
    # Last: where there is a result, its pages are there.
    write_whole(folder / RESULT, _utf8(result.to_json() + "\n"))


def _utf8(text: str) -> bytes:
    return text.encode("utf-8", "backslashreplace")


def _read(file: Path) -> bytes | None:
    try:
        return file.read_bytes()
    except FileNotFoundError:
        return None
