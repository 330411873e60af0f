"""Groups: students with a common submission."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from robsim.base.text import listed, one_line
from robsim.teach.assignments.classes.table import Table
from robsim.teach.errors import SubmissionError
from robsim.teach.reports.words import OF_MOODLE, person
from robsim.teach.submissions import Rules
from robsim.teach.submissions.reading import open_submission

if TYPE_CHECKING:
    from robsim.teach.assignments.classes.submissions import Handed

FILE = "groups.csv"  # next to the submissions
_COLUMNS = ["group", "student"]
# Further columns of a grading worksheet of Moodle
_FULL_NAME, _IDENTIFIER = "full name", "identifier"


def read_groups(file: Path) -> dict[str, list[str]]:
    """Return the students by group from a table with the columns group and student.

    A grading worksheet of Moodle with a column group is such a table. Its students have numbers.
    Raise ValueError if a column is missing, or if students are in two groups.
    """
    table = Table.read(file)
    columns = {name.lower(): name for name in table.columns}
    if _FULL_NAME in columns:
        columns.setdefault("student", columns[_FULL_NAME])
    if missing := [name for name in _COLUMNS if name not in columns]:
        raise ValueError(
            f"{one_line(file)} must have the columns group and student, got no {missing[0]}"
        )
    groups: dict[str, list[str]] = {}
    for row in table.rows:
        group, student = (row[columns[name]].strip() for name in _COLUMNS)
        identifier = row[columns[_IDENTIFIER]] if _IDENTIFIER in columns else ""
        if group and student:
            groups.setdefault(group, []).append(_as_in_moodle(student, identifier))
    known = [student for students in groups.values() for student in students]
    if twice := [student for student in dict.fromkeys(known) if known.count(student) > 1]:
        raise ValueError(f"{one_line(file)} has these students more than once: {listed(twice)}")
    return groups


def _as_in_moodle(student: str, identifier: str) -> str:
    """Return the name of a submission whose identifier is a participant's of Moodle."""
    match = re.fullmatch(r"Participant (\d+)", identifier.strip())
    return f"{student}_{match[1]}_assignsubmission_file" if match else student


def _key(student: str) -> str:
    """Return the number of a student in Moodle, where names differ; else the name."""
    match = OF_MOODLE.fullmatch(student)
    return f"Participant {match['number']}" if match else student


def in_groups(
    handed: Sequence[Handed],
    table: Mapping[str, Sequence[str]] | None,
    rules: Rules,
    tell: Callable[[str], None],
) -> tuple[list[Handed], list[str]]:
    """Return the submissions of groups and of others, and a sentence for each problem.

    The submission of a group has the name of the group or of a member. Moodle puts a copy into a
    folder of each member, ``GROUP-NAME_...``. Without a table, equal copies are a group.
    """
    groups = _of_moodle(handed, rules, tell) if table is None else table
    where = {
        _key(name): group
        for group, ones in groups.items()
        for name in (*ones, *(f"{group}-{one}" for one in ones), group)
    }
    found: dict[str, list[Handed]] = {}
    alone: list[Handed] = []
    for one in handed:
        name = person(one.student)
        group = where.get(_key(one.student)) or where.get(name) or name.partition("-")[0]
        (found.setdefault(group, []) if group in groups else alone).append(one)
    if table is not None and (missing := [group for group in groups if group not in found]):
        tell(f"these groups have no submission: {listed(missing)}")
    if table is not None and alone:
        tell(f"graded alone, because they are in no group: {listed(one.student for one in alone)}")
    problems = [
        f"{len(ones)} submissions of the group {one_line(group)}, "
        f"{listed(one.student for one in ones)}: keep the one that counts"
        for group, ones in found.items()
        if not _are_same(ones, rules)
    ]
    together = [_of_group(group, ones, groups[group]) for group, ones in found.items()]
    return sorted([*alone, *together], key=lambda one: one.student), problems


def _of_group(group: str, ones: Sequence[Handed], students: Sequence[str]) -> Handed:
    # The names of platforms have numbers, which their tables need.
    names = [one.student.removeprefix(f"{group}-") for one in ones]
    of = {
        one: [name for name in names if _key(one) in (_key(name), person(name))] or [one]
        for one in students
    }
    members = tuple(one_line(name) for student in students for name in of[student])
    return replace(ones[0], student=one_line(group), members=members)


def _of_moodle(
    handed: Sequence[Handed], rules: Rules, tell: Callable[[str], None]
) -> dict[str, list[str]]:
    """Return groups by their names; without groups Moodle has students with no "-", too."""
    named = [one for one in handed if OF_MOODLE.fullmatch(one.student)]
    if not all("-" in person(one.student) for one in named):
        return {}
    groups = {
        group: [one.student.removeprefix(f"{group}-") for one in ones]
        for group, ones in _by_files(named, rules, 1).items()
    }
    if groups:
        tell(f"graded as groups, because their members have the same files: {listed(groups)}")
    return groups


def _by_files(handed: Sequence[Handed], rules: Rules, dashes: int) -> dict[str, list[Handed]]:
    """Return groups with the same files; the name of a group may have a "-", as in Team-1."""
    found: dict[str, list[Handed]] = {}
    for one in handed:
        *parts, _ = person(one.student).split("-")
        if len(parts) >= dashes:
            found.setdefault("-".join(parts[:dashes]), []).append(one)
    groups: dict[str, list[Handed]] = {}
    for group, ones in found.items():
        if len(ones) > 1:
            same = _are_same(ones, rules)
            groups |= {group: ones} if same else _by_files(ones, rules, dashes + 1)
    return groups


def _are_same(handed: Sequence[Handed], rules: Rules) -> bool:
    if len(handed) == 1:
        return True
    try:
        first, *others = (open_submission(h.path, rules, h.files).files for h in handed)
    except SubmissionError:
        return False
    return all(files == first for files in others)
