"""Writing the reports of a submission and of a class into folders."""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict
from os import PathLike
from pathlib import Path
from types import MappingProxyType

from robsim.base.files import as_folder, write_whole
from robsim.teach.reports.pages import Paths, class_page, student_page
from robsim.teach.reports.similarity import Program, compared, read_comparison
from robsim.teach.reports.student_text import for_student, pseudonymous, student_text
from robsim.teach.reports.tables import marks_table
from robsim.teach.results import SubmissionResult
from robsim.teach.submissions.names import problem_of

RESULT, PAGE, TEXT, TEACHERS = "result.json", "index.html", "result.txt", "teacher.html"
CLASS, MARKS, TABLE = "class.html", "class.csv", "by_hand.csv"
SIMILAR = "similar.json"
_KEPT = 40  # characters of a name that some systems refuse


def folder_name(student: str) -> str:
    """Return the name of a student's folder: the student's, or one that all systems accept."""
    is_free = not student.lower().endswith((".csv", ".html", ".json", ".xml", ".zip"))
    if student and is_free and not {"/", "\\"} & set(student) and problem_of(student) is None:
        return student
    digest = hashlib.sha256(student.encode("utf-8", "surrogatepass")).hexdigest()[:8]
    kept = re.sub(r"[^\w ()-]", "_", student)[:_KEPT]
    return f"__{kept}_{digest}"


def write_student(
    folder: str | PathLike[str],
    result: SubmissionResult,
    *,
    pictures: Mapping[str, bytes] | None = None,
    teacher_page: bool = False,
) -> None:
    """Write the reports of a submission: each file is complete or unchanged.

    ``index.html`` and ``result.txt`` are for the student, with points and a sentence of hidden
    tests. ``teacher.html`` and ``result.json`` have all, and pictures have the names of their
    tests. `teacher_page` requests ``teacher.html``; an old one is always overwritten.

    New pictures are PNG files by test; others are read from the folder.
    """
    folder = as_folder(folder)
    folder.mkdir(parents=True, exist_ok=True)
    files = {test.name: test.picture for test in result.tests if test.picture}
    for name, png in (pictures or {}).items():
        write_whole(folder / files[name], png)
    places = {name: folder / file for name, file in files.items()}
    found = {name: file.read_bytes() for name, file in places.items() if file.is_file()}
    theirs = for_student(result)
    write_whole(folder / PAGE, _utf8(student_page(theirs, found)))
    write_whole(folder / TEXT, _utf8(student_text(theirs)))
    if teacher_page or (folder / TEACHERS).exists():
        write_whole(folder / TEACHERS, _utf8(student_page(result, found, for_teacher=True)))
    # Last: a folder with a result has its pages.
    write_whole(folder / RESULT, _utf8(result.to_json() + "\n"))


def write_class(
    folder: str | PathLike[str],
    results: Iterable[SubmissionResult],
    *,
    paths: Paths | None = None,
    area: tuple[float, float] = (1200.0, 1200.0),
    programs: Mapping[str, Program] | None = None,
    given: Iterable[Program] = (),
    others: Mapping[str, Program] = MappingProxyType({}),
    pseudonym: Callable[[str], str] | None = None,
    columns: str = "robsim",
    title: str | None = None,
) -> None:
    """Write the reports of a class, ``class.html`` and ``class.csv``, next to its submissions.

    The paths of the best runs are in the unit of `area`, by test and student. The page compares the
    programs by student (`program_of`) with each other and with `others`, without given text. If
    `programs` is None, it shows the last comparison, from ``similar.json``. It links to an existing
    ``teacher.html``, else to ``index.html``. With pseudonyms the page shows no text and no
    program. `marks_table` documents columns and title. Raise OSError, or ValueError for
    no result and for unknown columns.
    """
    folder = as_folder(folder)
    shown = sorted(results, key=lambda result: result.student)
    if not shown:
        raise ValueError("results must have at least one result of a submission")
    folder.mkdir(parents=True, exist_ok=True)
    if programs is None:
        found = read_comparison(folder / SIMILAR)
    else:
        found = compared(programs, given, others)
        write_whole(folder / SIMILAR, json.dumps(asdict(found)).encode())
    links = {result.student: _link(folder, folder_name(result.student)) for result in shown}
    if pseudonym is not None:
        shown = sorted(pseudonymous(shown, pseudonym), key=lambda result: result.student)
        found = found and found.renamed(pseudonym)
        paths = {
            test: {pseudonym(who): path for who, path in drawn.items() if who in links}
            for test, drawn in (paths or {}).items()
        }
        links = {}
    table = marks_table(shown, columns=columns, title=title)
    write_whole(folder / MARKS, _utf8(table))
    content = class_page(shown, paths=paths, area=area, found=found, links=links)
    write_whole(folder / CLASS, _utf8(content))


def _link(folder: Path, name: str) -> str:
    return f"{name}/{TEACHERS if (folder / name / TEACHERS).exists() else PAGE}"


def _utf8(text: str) -> bytes:
    return text.encode("utf-8", "backslashreplace")
