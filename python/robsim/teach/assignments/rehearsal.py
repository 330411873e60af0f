"""A class of all known right, wrong and hostile submissions, with their expected results."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from robsim.campaigns.engines.engine import Engine
from robsim.simulation.slots import SLOTS, STEP
from robsim.teach.assignments.assignment import Assignment
from robsim.teach.assignments.assignment_file import solutions_for
from robsim.teach.assignments.classes.class_run import grade_all
from robsim.teach.assignments.classes.plan import Plan
from robsim.teach.assignments.classes.progress import Schedule
from robsim.teach.assignments.classes.store import ResultFolder
from robsim.teach.assignments.classes.submissions import Handed
from robsim.teach.assignments.from_notebook import names_of_tests
from robsim.teach.assignments.making import START, write_below
from robsim.teach.exercises.shipped import solved, sources
from robsim.teach.results import SubmissionResult
from robsim.teach.submissions.imports import masked_in
from robsim.teach.submissions.python_text import decoded
from robsim.teach.tasks.definition import Task
from robsim.teach.tasks.solutions import Solution

_FILES = Path(__file__).parent / "templates/hostile"
#: The result without any work, of slots that are called at each step.
_NOTHING = {"control": "(0.0, 0.0)"}


def hostile_submissions(names: tuple[str, ...]) -> Iterator[tuple[str, dict[str, bytes]]]:
    """Yield the name of each submission, and its files by name, for slots or functions."""
    at_each_step = [name for name in names if name in SLOTS and SLOTS[name].when == STEP] or names
    for file in sorted(_FILES.glob("*.py")):
        text = file.read_text(encoding="utf-8")
        yield file.stem, {f"{slot}.py": _for_slot(text, slot) for slot in at_each_step}


def _for_slot(text: str, slot: str) -> bytes:
    return text.replace("SLOT", slot).replace("NOTHING", _NOTHING.get(slot, "None")).encode()


#: The expected result of a submission.
FULL, LESS, NOTHING = "all points", "fewer points", "no points"

_RIGHT = "from right_SLOT import SLOT as right\n\n"
_KEPT = f"{_RIGHT}kept = []\n\n\ndef SLOT(step):\n    if ASKED:\n        kept[:] = [right(step)]\n"
_KEPT += "    return kept[0]\n"
#: Submissions without any work, by name: the file of a slot, and the right result.
_GAMED = {
    "robsim's own": ("SLOT = True\n", NOTHING),
    "always nothing": ("def SLOT(*given):\n    return NOTHING\n", NOTHING),
    "one step in 60": (
        f"{_RIGHT}\ndef SLOT(step):\n    return right(step) if step.k % 60 == 30 else NOTHING\n",
        NOTHING,
    ),
    "each tenth answer held": (_KEPT.replace("ASKED", "step.k % 10 == 0"), LESS),
    "the first answer held": (_KEPT.replace("ASKED", "not kept or kept[0] is None"), LESS),
}


def gamed_submissions(
    right: Solution, slots: Sequence[str], masked: Sequence[str]
) -> Iterator[tuple[str, dict[str, bytes], str]]:
    """Yield the name of each, its files, and the right result; `right` uses no masked name."""
    at_each_step = [slot for slot in slots if SLOTS[slot].when == STEP and slot in right.files]
    others = {name: text for name, text in right.files.items() if name not in at_each_step}
    moved = {f"right_{slot}": right.files[slot] for slot in at_each_step}
    for name, (text, expected) in _GAMED.items():
        own = {slot: _for_slot(text, slot) for slot in at_each_step}
        helpers = moved | others if "right_SLOT" in text else {}
        yield name, _sources(helpers | own), expected
    templates = {slot: SLOTS[slot].template.read_bytes() for slot in at_each_step}
    on = {slot: text.replace(b"ENABLED = False", b"") for slot, text in templates.items()}
    yield "the template of robsim new", _sources(on), NOTHING
    for mask in masked:
        package, _, name = mask.rpartition(".")
        if package == "robsim" and name[0].islower():  # a function, by another name
            text = (
                f"from robsim import {name} as other\n\n\ndef SLOT(*given):\n    return other()\n"
            )
            own = {slot: _for_slot(text, slot) for slot in at_each_step}
            yield f"{mask} by another name", _sources(own), NOTHING


@dataclass(frozen=True)
class Part:
    """A submission of the class."""

    name: str  # of its author
    files: Mapping[str, bytes]  # by name
    expected: str  # the right result
    tests: tuple[str, ...]  # the names of the tests with this result
    is_free: bool = False  # may use masked modules


def cast_of(assignment: Assignment) -> list[Part]:
    parts: list[Part] = []
    tests = tuple(test.name for test in assignment.tests)
    for task in {test.task.name: test.task for test in assignment.tests}.values():
        own = tuple(one.name for one in assignment.tests if one.task.name == task.name)
        solutions = solutions_for(assignment.folder, task)
        ruled = _ruled(solutions, assignment.masked)
        for one in solutions:
            kind, expected = ("right", FULL) if one.is_right else ("wrong", LESS)
            files, is_free = _sources(one.files), one != ruled
            parts.append(Part(f"{kind}: {one.name}", files, expected, own, is_free=is_free))
        parts.append(_as_notebook(ruled, task, own))
        for name, files, expected in gamed_submissions(ruled, task.slots, task.masked):
            parts.append(Part(f"gamed: {name}", files, expected, own))
    own_tests = names_of_tests(assignment.functions)
    for file in sorted((assignment.folder / START).glob("*.ipynb")):
        if file.stem in sources():
            begun, right = {file.name: file.read_bytes()}, {file.name: solved(file.stem)}
            parts.append(Part("right: the notebook with its answers", right, FULL, own_tests))
            parts.append(Part("the notebook as students get it", begun, NOTHING, own_tests))
    tests += own_tests
    parts.append(Part("empty submission", {"notes.txt": b"to do\n"}, NOTHING, tests))
    hostile = hostile_submissions(assignment.slots or assignment.functions)
    parts += (Part(f"hostile: {name}", files, NOTHING, tests) for name, files in hostile)
    return parts


def _ruled(solutions: Sequence[Solution], masked: tuple[str, ...]) -> Solution:
    right = [one for one in solutions if one.is_right]
    for one in right:
        if not masked_in(one.files, masked):
            return one
    return right[0]


def _sources(files: Mapping[str, bytes]) -> dict[str, bytes]:
    return {f"{name}.py": content for name, content in files.items()}


def _as_notebook(solution: Solution, task: Task, tests: tuple[str, ...]) -> Part:
    slots = [slot for slot in task.slots if slot in solution.files]
    modules = {name: code for name, code in solution.files.items() if name not in slots}
    sources = [decoded(solution.files[slot], f"{slot}.py") for slot in slots]
    cells = [{"cell_type": "code", "source": source} for source in sources]
    notebook = {"cells": cells, "metadata": {}, "nbformat": 4, "nbformat_minor": 5}
    files = {f"{task.name}.ipynb": json.dumps(notebook).encode(), **_sources(modules)}
    return Part(f"right: {solution.name}, as a notebook", files, FULL, tests)


def graded(
    plan: Plan,
    parts: list[Part],
    folder: Path,
    *,
    executor: Engine,
    tell: Callable[[], None],
    again: int = 0,
) -> dict[str, SubmissionResult]:
    """Grade parts of a class in an empty folder, and return their results by name.

    The number of the repetition, `again`, changes the seeds. `tell` is called after each part.
    """
    if not parts:
        return {}
    handed = []
    for number, part in enumerate(parts):
        place = folder / f"handed/{number}"
        write_below(place, part.files)
        handed.append(Handed(f"{number} {again}", str(place)))
    out = ResultFolder(folder / "out")
    schedule = Schedule(plan, handed, out, lambda result, changed: tell())
    found = {one.student: one for one in grade_all(schedule, executor).results}
    return {part.name: found[one.student] for part, one in zip(parts, handed, strict=True)}
