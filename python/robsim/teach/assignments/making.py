"""`new_assignment`: the folder of a new assignment."""

from __future__ import annotations

import shutil
import string
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from robsim.base.checks import check_int, check_name, check_text
from robsim.base.files import as_folder, codec, write_whole
from robsim.base.spelling import check_names
from robsim.base.text import one_line
from robsim.teach.assignments import limits_file
from robsim.teach.assignments.assignment import Assignment
from robsim.teach.assignments.assignment_file import (
    FILE,
    KEY,
    SOLUTIONS,
    load_assignment,
    solutions_for,
)
from robsim.teach.assignments.from_notebook import notebook_files
from robsim.teach.assignments.sheet import SHEET, sheet_for
from robsim.teach.exercises.shipped import sources
from robsim.teach.grading.keys import Key
from robsim.teach.tasks.by_name import task
from robsim.teach.tasks.definition import Task
from robsim.teach.tasks.marks.calibration import shipped_calibrations
from robsim.teach.tasks.solutions import helpers, starting_files


@dataclass(frozen=True)
class Range:
    """The range of a random number: uniform, and rounded."""

    least: float
    most: float
    digits: int = 0  # decimal places


_HEADING = Range(3.12, 3.14, 2)  # rad; far from pi angles need no wrapping
_DRIVING = {
    "noise": Range(8, 12, 1),
    "dropout": Range(0.12, 0.18, 2),
    "mismatch": Range(0.08, 0.12, 2),
}
#: The random numbers of each task. Their ranges keep the parameters fair: the limits separate
#: robsim's right and wrong solutions everywhere in the ranges.
TEMPLATES: Mapping[str, Mapping[str, Any]] = MappingProxyType(
    {
        "park": {"goal": (Range(250, 550), Range(250, 550), _HEADING), **_DRIVING},
        "follow": {
            "waypoints": (
                (Range(400, 460), Range(190, 250)),
                (Range(190, 240), Range(190, 250)),
                (Range(190, 240), Range(370, 430)),
            ),
            **_DRIVING,
        },
        "identify": {
            "mismatch": Range(0.2, 0.3, 2),
            "slip": Range(0.08, 0.12, 3),
            "turn": Range(0.0024, 0.0036, 4),
        },
        "measure": {"noise": Range(26, 34, 1), "dropout": Range(0.1, 0.2, 2)},
        "estimate": {
            "dropout": Range(0.16, 0.24, 2),
            "slip": Range(0.24, 0.36, 2),
            "turn": Range(0.008, 0.012, 3),
        },
    }
)


def draw(name: str, rng: np.random.Generator) -> Task:
    return task(name, **{key: _drawn(one, rng) for key, one in TEMPLATES[name].items()})


def _drawn(ranges: Range | tuple[Any, ...], rng: np.random.Generator) -> Any:
    if isinstance(ranges, Range):
        return round(float(rng.uniform(ranges.least, ranges.most)), ranges.digits)
    return tuple(_drawn(one, rng) for one in ranges)


START, OWN_TESTS = "start", "own_tests.py"
_FILES = Path(__file__).with_name("templates")
_MOST_SEED = 2**63 - 1


def new_assignment(
    template: str, folder: str | PathLike[str], *, name: str | None = None, seed: int | None = None
) -> Assignment:
    """Make the folder of an assignment, with a new key and random numbers in the task.

    The limits of a task are provisional: they come from robsim's default task.
    `calibrate_assignment` makes exact limits. A notebook is graded by its exercises, without
    limits.

    Parameters
    ----------
    template : str
        A task, such as ``"park"``, or a notebook with exercises, such as ``"02_park"``; see
        `notebook_exercises`.
    folder : path
        The new folder.
    name : str, optional
        The name of the assignment. Default: the folder's name.
    seed : int, optional
        Seed of the numbers of a task; the key is always new. Default: an unpredictable one.

    Returns
    -------
    Assignment
        The new assignment.

    Raises
    ------
    FileExistsError
        If the folder or a file of this name exists.
    TypeError, ValueError
        If an argument is wrong; the message names it.

    Examples
    --------
    >>> assignment = robsim.teach.new_assignment("park", "hw1", seed=1)
    >>> assignment.title, assignment.slots
    ('Park the robot', ('control',))
    """
    known = [*TEMPLATES, *sources()]
    check_names("unknown template", [check_text("template", template)], known, ValueError)
    place = as_folder(folder)
    title = check_name("name", place.absolute().name if name is None else name)
    if seed is not None:
        check_int("seed", seed, minimum=0, maximum=_MOST_SEED)
    task = draw(template, np.random.default_rng(seed)) if template in TEMPLATES else None
    try:
        place.mkdir(parents=True)
    except FileExistsError:
        raise FileExistsError(
            f"{one_line(place)} exists: give another name, or remove it first"
        ) from None
    try:
        Key.new().save(place / KEY)
        if task is None:
            write_below(place, notebook_files(template, title))
        else:
            _fill(place, task, title)
        return load_assignment(place)
    except BaseException:
        shutil.rmtree(place, ignore_errors=True)
        raise


def _fill(folder: Path, task: Task, name: str) -> None:
    values = {
        "name": _toml(name),
        "title": _title(task),
        "folder": one_line(folder),
        "task": task.name,
    }
    files = {
        FILE: _filled("assignment.toml", values | _rules(task)),
        "README.md": _filled("README.md", values),
        OWN_TESTS: (_FILES / f"tests/{task.slots[-1]}.py").read_bytes(),
        **{f"{START}/{path}": content for path, content in starting_files(task).items()},
    }
    write_below(folder, files | dict(_solution_files(task)))
    made = load_assignment(folder)
    known = shipped_calibrations()[task.name].for_task(task, solutions_for(folder, task))
    limits_file.write_limits(folder, {test.name: known for test in made.tests})
    write_whole(folder / SHEET, sheet_for(made).encode())


def write_below(folder: Path, files: Mapping[str, bytes]) -> None:
    """Write files by their paths in a folder."""
    for path, content in files.items():
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        write_whole(folder / path, content)


def _solution_files(task: Task) -> Iterator[tuple[str, bytes]]:
    shared: dict[str, bytes] = {}
    for one in task.solutions:
        place = f"{SOLUTIONS}/{task.name}/{'right' if one.is_right else 'wrong'}/{one.name}"
        for name, content in one.files.items() - shared.items():
            yield f"{place}/{name}.py", content
        shared = helpers(task.solutions[0])


def _rules(task: Task) -> dict[str, str]:
    kind = type(task)
    set_values = [(key, value) for key, value in task.parameters.items() if value is not None]
    return {
        "title": _toml(_title(task)),
        "slots": _toml(list(kind.slots)),
        "given": _toml(kind.given),
        "masked": _toml([*kind.masked, "robsim.teach.assignments"]),
        "task": _toml(task.name),
        "class": f"robsim.teach.{kind.__name__}",
        "public_title": _toml(f"{kind.title[0].upper()}{kind.title[1:]}"),
        "hidden_title": _toml(f"{kind.title[0].upper()}{kind.title[1:]}, in other worlds"),
        "parameters": "\n".join(f"{key} = {_toml(value)}" for key, value in set_values),
    }


def _title(task: Task) -> str:
    return task.sheet.splitlines()[0].removeprefix("# ")


def _toml(value: Any) -> str:
    import tomlkit

    return str(tomlkit.item(codec.plain(value)).as_string())


def _filled(name: str, values: Mapping[str, str]) -> bytes:
    text = (_FILES / name).read_text(encoding="utf-8")
    return string.Template(text).substitute(values).encode()
