"""The students' part of an assignment: all public files, and nothing else."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import Any

from robsim.base.files import codec
from robsim.base.text import one_line
from robsim.teach.assignments import limits_file
from robsim.teach.assignments._own_tests.listing import list_own_tests
from robsim.teach.assignments.assignment import Assignment, TaskTest
from robsim.teach.assignments.assignment_file import FILE, GIVEN, KEY, SOLUTIONS
from robsim.teach.assignments.making import START
from robsim.teach.assignments.marking.marking import limit_of
from robsim.teach.assignments.marking.references import References
from robsim.teach.assignments.sheet import SHEET, told_task
from robsim.teach.errors import AssignmentError
from robsim.teach.results import finite
from robsim.teach.tasks.solutions import MODULE, NAIVE, module_source

_SHORTEST = 12  # bytes of a solution; shorter ones may occur anywhere


def public_part(assignment: Assignment) -> dict[str, bytes]:
    """Return the files for students, by their paths in the folder.

    Raise AssignmentError if a public test, its limits or the sheet is missing, or if a hidden part
    would be public.
    """
    files = dict(_files(assignment))
    if found := leaks(assignment, files):
        raise AssignmentError(f"students would get a hidden part: {found[0]}")
    return files


def _files(assignment: Assignment) -> Iterator[tuple[str, bytes]]:
    if not any(test.public for test in assignment.all_tests):
        raise AssignmentError(f"{FILE} has no public test, which students can run", file=FILE)
    sheet = assignment.folder / SHEET
    if not sheet.is_file():
        raise AssignmentError(f"{one_line(assignment.folder)} has no {SHEET}", file=SHEET)
    yield SHEET, sheet.read_bytes()
    yield FILE, _public_toml(assignment).encode()
    yield limits_file.FILE, _public_limits(assignment).encode()
    for file in assignment.files:
        if file.public:
            yield str(file.path.relative_to(assignment.folder).as_posix()), file.path.read_bytes()
    for name in (START, GIVEN):
        yield from _below(assignment.folder, name)
    if assignment.tests:  # from the parameters, instead of an older one
        yield f"{START}/{MODULE}.py", module_source(told_task(assignment))


def _public_toml(assignment: Assignment) -> str:
    import tomlkit

    values = codec.load_table(assignment.folder / FILE)
    for key in ("tests", "files"):
        values[key] = [one for one in values.get(key, []) if one["public"]]
    values = {"points": _all_points(assignment)} | {k: v for k, v in values.items() if v != []}
    return f"# Try it: robsim grade . mine --public\n{tomlkit.dumps(values)}"


def _all_points(assignment: Assignment) -> float:
    own = (list_own_tests(assignment, file) for file in assignment.files)
    points = [test.points for test in assignment.tests]
    return sum(points) + sum(one.points for tests in own for one in tests)


def _public_limits(assignment: Assignment) -> str:
    """Return limits and the numbers of the reference, because students do not have its code."""
    references = References(assignment)
    tests = {}
    for test in (one for one in assignment.tests if one.public):
        runs = [references.numbers(test, "", run) for run in range(test.task.runs)]
        columns = {name: [finite(run[name]) for run in runs] for name in runs[0]}
        tests[test.name] = {**_limits(test), "reference": columns}
    return json.dumps({"format": limits_file.FORMAT, "tests": tests}, indent=1)


def limits_alone(assignment: Assignment) -> str:
    tests = {test.name: _limits(test) for test in assignment.tests}
    return json.dumps({"format": limits_file.FORMAT, "tests": tests}, indent=1)


def _limits(test: TaskTest) -> dict[str, Any]:
    limits = {s.name: asdict(limit_of(test, s)) for s in test.task.scores}
    return {"limits": limits, "provisional": test.provisional}


def _below(folder: Path, name: str) -> Iterator[tuple[str, bytes]]:
    for file in sorted((folder / name).rglob("*")):
        path = file.relative_to(folder)
        is_hidden = any(part.startswith((".", "__")) for part in path.parts)
        if file.is_file() and not is_hidden:
            yield path.as_posix(), file.read_bytes()


def leaks(assignment: Assignment, files: dict[str, bytes]) -> list[str]:
    everything = b"\n".join(files.values())
    return [
        f"{name} has {what}"
        for what, secret in _secrets(assignment)
        if secret in everything
        for name, content in files.items()
        if secret in content
    ]


def _secrets(assignment: Assignment) -> Iterator[tuple[str, bytes]]:
    key = assignment.folder / KEY
    if key.is_file():
        yield "the key", key.read_bytes().split()[-1]
    for file in assignment.files:
        if not file.public:
            yield f"the hidden {file.path.name}", file.path.read_bytes()
    for solution in sorted((assignment.folder / SOLUTIONS).rglob("*.py")):
        content = solution.read_bytes().strip()
        is_start = solution.parent.name == NAIVE  # the source of the students' first files
        if len(content) > _SHORTEST and not is_start:
            path = solution.relative_to(assignment.folder).as_posix()
            yield f"the solution {path}", content
