"""The submissions to grade: a class, or a single one."""

from __future__ import annotations

import os
import unicodedata
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from itertools import takewhile
from os import PathLike
from pathlib import Path

from robsim.base.files import as_path
from robsim.base.text import listed, one_line
from robsim.simulation.slots import SLOTS
from robsim.teach.assignments.assignment import Assignment
from robsim.teach.assignments.classes.groups import FILE, in_groups, read_groups
from robsim.teach.errors import AssignmentError, SubmissionError
from robsim.teach.reports.words import OF_BLACKBOARD, OF_CANVAS, OF_MOODLE
from robsim.teach.reports.writing import folder_name
from robsim.teach.submissions.archive import paths_in
from robsim.teach.submissions.folder import ARCHIVES, FORMS
from robsim.teach.submissions.names import same_for_all
from robsim.teach.submissions.reading import arranged, open_submission
from robsim.teach.tasks.solutions import MODULE

_SENT = (*FORMS, *ARCHIVES)  # a sentence refuses archives other than zips


@dataclass(frozen=True)
class Handed:
    """The submission of a student or of a group.

    Attributes
    ----------
    student : str
        The name of the student or of the group.
    path : str
        The folder or file; with `files` the folder or zip of the class.
    files : tuple of (str, str)
        Pairs of a place in the class and its name in the submission. A folder ends in "/".
    members : tuple of str
        The students of a group.
    """

    student: str
    path: str
    files: tuple[tuple[str, str], ...] = ()
    members: tuple[str, ...] = ()


def one_submission(
    path: str | PathLike[str], assignment: Assignment, name: str = "submission"
) -> Handed:
    """Return a submission by its path, which may end in the student's name without a file's suffix.

    The path may lead into the zip of a class. Messages call the argument `name`. Raise
    FileNotFoundError if it is missing.
    """
    place = Path(os.path.abspath(as_path(path, name)))
    found = [place]
    if not os.path.lexists(place):
        if _is_zip(place.parent):
            for one in submissions_in(place.parent, assignment):
                if one.student == place.name:
                    return one
        found = [file for form in FORMS if (file := Path(f"{place}{form}")).is_file()]
        if len(found) != 1:
            raise FileNotFoundError(2, "the submission is missing", str(path))
    (place,) = found
    student, _, _ = _whose(f"{place.name}/" if place.is_dir() else place.name)
    return Handed(student, str(place))


def _is_zip(place: Path) -> bool:
    return place.suffix.lower() == ".zip" and place.is_file()


def check_is_one(handed: Handed, assignment: Assignment) -> None:
    """Raise ValueError for a folder or zip with several submissions."""
    if handed.files:
        return
    try:
        found = submissions_in(handed.path, assignment)
    except FileNotFoundError:  # it is empty
        return
    if len(found) == 1:
        return
    is_read = [_can_be_read(one, assignment) for one in found]
    if sum(is_read) > 1 or not _can_be_read(handed, assignment):
        folder, first = Path(handed.path).name, found[0]
        inside = first.student if first.files else Path(first.path).name
        raise ValueError(
            f"{one_line(folder)} is a folder of {len(found)} submissions: name a single "
            f"submission, such as {one_line(folder)}/{one_line(inside)}"
        )


def _can_be_read(handed: Handed, assignment: Assignment) -> bool:
    rules = assignment._rules()
    try:
        contents = open_submission(handed.path, rules, handed.files)
        arranged(contents, rules, assignment.files_of_all)
    except SubmissionError:
        return False
    return True


def submissions_in(
    path: str | PathLike[str],
    assignment: Assignment,
    tell: Callable[[str], None] = lambda sentence: None,
    groups: Path | None = None,
) -> list[Handed]:
    """Return all submissions of a folder or of a zip by name, or the only one of a path.

    A folder or zip is one submission if it has a file of a slot, or a given file. So is a zip
    without several folders or archives. `tell` gets sentences on ignored files, on names
    and on groups. Their table is `groups`, by default ``groups.csv`` next to the submissions.

    Raise FileNotFoundError for an empty folder. Raise AssignmentError with all students that have
    several submissions or a common folder of results.
    """
    first = one_submission(path, assignment, "submissions")
    place = Path(first.path)
    given = {*assignment.given_files, f"{MODULE}.py", *(f"{slot}.py" for slot in SLOTS)}
    inside, tops = "", {""}
    if place.is_dir():
        # Tools make hidden files.
        names = [name for name in os.listdir(place) if not _is_hidden(name) and name != FILE]
        tops = {name if (place / name).is_file() else f"{name}/" for name in names}
    elif _is_zip(place) and not first.files:
        inside, tops = _class_in(place)
    if first.files or not tops.isdisjoint(given | {""}):
        return [first]
    found, problems = _by_student(tops, tell)
    if not found:
        raise FileNotFoundError(2, "no submissions in this folder", str(path))
    handed = [_handed(student, place, inside, found[student]) for student in sorted(found)]
    beside = (place if place.is_dir() else place.parent) / FILE
    table = groups or (beside if beside.is_file() else None)
    students = None if table is None else read_groups(table)
    handed, more = in_groups(handed, students, assignment._rules(), tell)
    if problems := [*problems, *more, *_problems_of_folders(handed)]:
        raise AssignmentError("; ".join(problems))
    folders = [(one.student, folder_name(one.student)) for one in handed]
    if renamed := [f"{student} in {folder}" for student, folder in folders if student != folder]:
        tell(f"results are in folders of other names: {'; '.join(renamed)}")
    return handed


def _is_hidden(name: str) -> bool:
    is_student = OF_MOODLE.fullmatch(name) is not None
    return name.startswith((".", "__")) and name != ".." and not is_student


def _class_in(zipped: Path) -> tuple[str, set[str]]:
    """Return the folder of a class in a zip, and the names in it: "" if it is no class."""
    try:
        paths = [path for path in paths_in(zipped) if not any(map(_is_hidden, path.split("/")))]
    except SubmissionError:  # grading reports it
        return "", {""}
    inside = ""
    while len(tops := {_top(path, inside) for path in paths}) == 1:
        (around,) = tops
        if not around.endswith("/") or OF_MOODLE.fullmatch(around[:-1]):
            break
        inside += around
    tops = {_place_of(path, inside) for path in paths}
    sent = {_place_of(path, inside) for path in paths if path.lower().endswith(_SENT)}
    files = {top for top in sent if not top.endswith("/")}
    is_class = (
        any(OF_MOODLE.fullmatch(top.removesuffix("/")) for top in tops)
        or any(_whose(file)[1] != file for file in files)
        or (len(sent) > 1 and any(file.lower().endswith(ARCHIVES) for file in files))
        or (len(sent - files) > 1 and len(files) != 1)
    )
    return (inside, tops) if is_class else ("", {""})


def _top(path: str, inside: str) -> str:
    return "".join(path[len(inside) :].partition("/")[:2])


def _place_of(path: str, inside: str) -> str:
    """Return the file or folder of a student; Moodle's may be in another folder."""
    start = max(path.find("_assignsubmission_", len(inside)), len(inside))
    return path[len(inside) : start] + _top(path, path[:start])


def _by_student(
    tops: Iterable[str], tell: Callable[[str], None]
) -> tuple[dict[str, list[tuple[str, str]]], list[str]]:
    """Return the files of each student, and a sentence on each student with several submissions."""
    found: dict[str, dict[str, list[tuple[str, str]]]] = {}
    title = _title_of(tops)
    for place in sorted(tops):
        student, name, attempt = _whose(place, title)
        found.setdefault(student, {}).setdefault(attempt, []).append((place, name))
    newest, others, old, problems = {}, [], [], []
    for student, attempts in found.items():
        files = attempts.pop(max(attempts))
        places = [place for place, _ in files]
        file_of = student.removesuffix("onlinetext") + "file"  # next to the text of Moodle
        if not any(map(_can_be_graded, places)) or (file_of != student and file_of in found):
            others += places
            continue
        newest[student] = files
        old += [place for older in attempts.values() for place, _ in older]
        if len(files) > 1 and any(name in ("", place) for place, name in files):
            problems.append(
                f"{len(files)} submissions of {student}, {listed(places)}: keep the one that counts"
            )
    for reason, left in (("they are no submissions", others), ("newer attempts count", old)):
        if left:
            tell(f"not graded, because {reason}: {listed(left)}")
    return newest, problems


def _can_be_graded(place: str) -> bool:
    return place.lower().endswith((*_SENT, "/"))


def _title_of(places: Iterable[str]) -> str:
    """Return the common start of a class's files from Blackboard, whose names may have "_"."""
    starts = [one.partition("_attempt_")[0] for one in places if OF_BLACKBOARD.fullmatch(one)]
    parts = zip(*(start.split("_")[:-1] for start in starts), strict=False)
    return "".join(f"{same[0]}_" for same in takewhile(lambda part: len({*part}) == 1, parts))


def _whose(place: str, title: str = "") -> tuple[str, str, str]:
    """Return the student of a file or a folder, its name in the submission, and the attempt."""
    is_folder = place.endswith("/")
    full = place.removesuffix("/")
    for pattern in (OF_MOODLE,) if is_folder else (OF_MOODLE, OF_CANVAS, OF_BLACKBOARD):
        if match := pattern.fullmatch(full):
            known = match.groupdict(default="")
            file = known["file"] + known.get("ending", "") or place
            student = _named(known["student"].replace("_LATE_", "_").replace("/", " "))
            if title and pattern is OF_BLACKBOARD:
                student = _named(place.removeprefix(title).partition("_attempt_")[0])
            return student, "" if is_folder else file, known.get("attempt", "")
    if is_folder:
        return _named(full), "", ""
    stem, suffix = os.path.splitext(place)
    return _named(stem if suffix.lower() in _SENT else place), place, ""


def _named(name: str) -> str:
    return one_line(unicodedata.normalize("NFC", name)).strip() or "_"


def _handed(student: str, place: Path, inside: str, files: Sequence[tuple[str, str]]) -> Handed:
    graded = [file for file, _ in files if _can_be_graded(file)]
    is_packed = len(graded) == 1 and graded[0].lower().endswith(ARCHIVES)
    if place.is_dir() and (is_packed or files[0][1] in ("", files[0][0])):
        return Handed(student, str(place / graded[0]))
    return Handed(student, str(place), tuple((inside + file, name) for file, name in files))


def _problems_of_folders(handed: Iterable[Handed]) -> list[str]:
    same: dict[str, list[str]] = {}
    for one in handed:
        same.setdefault(same_for_all(folder_name(one.student)), []).append(one.student)
    return [
        f"{listed(names)} would share one folder of results on some systems: rename one"
        for names in same.values()
        if len(names) > 1
    ]
