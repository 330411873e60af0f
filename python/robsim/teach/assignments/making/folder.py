"""`new_assignment`: the folder of a new assignment."""

from __future__ import annotations

import shutil
import string
from collections.abc import Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from robsim.base.checks import check_int, check_name, check_text
from robsim.base.files import as_folder, write_whole
from robsim.base.spelling import check_names
from robsim.base.text import one_line
from robsim.teach.assignments._reading.assignment_file import FILE, KEY, SOLUTIONS
from robsim.teach.assignments.assignment import Assignment
from robsim.teach.assignments.making.sheet import sheet_for
from robsim.teach.assignments.making.template import TEMPLATES, draw
from robsim.teach.grading.keys import Key
from robsim.teach.tasks.definition import Task
from robsim.teach.tasks.solutions import Solution, helpers, starting_files

SHEET, START, OWN_TESTS = "sheet.md", "start", "own_tests.py"

_FILES = Path(__file__).parents[1] / "templates"
_MOST_SEED = 2**63 - 1


def new_assignment(
    template: str,
    folder: str | PathLike[str],
    *,
    name: str | None = None,
    seed: int | None = None,
) -> Assignment:
    """Make the folder of an assignment, with a new key and numbers of its own.

    Its limits are not calibrated yet: see `calibrate_assignment`.

    Parameters
    ----------
    template : str
        One of `TEMPLATES`, such as ``"park"``.
    folder : path
        The folder, which is made.
    name : str, optional
        The name of the assignment. Default: that of the folder.
    seed : int, optional
        What the numbers are drawn from; the key is always new. Default: an unpredictable one.

    Returns
    -------
    Assignment
        What was made.

    Raises
    ------
    FileExistsError
        If there is such a folder or file.
    TypeError, ValueError
        If an argument is wrong; the message names it.
    """
    check_names("there is no template", [check_text("template", template)], TEMPLATES, ValueError)
    place = as_folder(folder)
    title = check_name("name", place.absolute().name if name is None else name)
    if seed is not None:
        check_int("seed", seed, minimum=0, maximum=_MOST_SEED)
    task = draw(template, np.random.default_rng(seed))
    try:
        place.mkdir(parents=True)
    except FileExistsError:
        raise FileExistsError(
            f"{one_line(place)} exists: give another name, or remove it first"
        ) from None
    try:
        _fill(place, task, title)
        return Assignment.load(place)
    except BaseException:
        shutil.rmtree(place, ignore_errors=True)
        raise


def _fill(folder: Path, task: Task, name: str) -> None:
    """Write the files; the sheet last, which is of what is read then."""
    values = {
        "name": _toml(name),
        "title": _title(task),
        "folder": one_line(folder),
        "task": task.name,
    }
    Key.new().write(folder / KEY)
    _write(folder / FILE, _filled("assignment.toml", values | _rules(task)))
    _write(folder / "README.md", _filled("README.md", values))
    _write(folder / OWN_TESTS, (_FILES / f"tests/{task.name}.py").read_text(encoding="utf-8"))
    (folder / START).mkdir()
    for path, content in starting_files(task).items():
        write_whole(folder / START / path, content)
    _write_solutions(folder / SOLUTIONS / task.name, task.solutions)
    _write(folder / SHEET, sheet_for(Assignment.load(folder)))


def _write_solutions(folder: Path, solutions: Sequence[Solution]) -> None:
    """Write solutions; all can import the helpers of the reference, the first, without a copy."""
    shared: dict[str, bytes] = {}
    for one in solutions:
        place = folder / ("right" if one.is_right else "wrong") / one.name
        place.mkdir(parents=True)
        for name, content in one.files.items() - shared.items():
            write_whole(place / f"{name}.py", content)
        shared = helpers(solutions[0])


def _rules(task: Task) -> dict[str, str]:
    kind = type(task)
    return {
        "title": _toml(_title(task)),
        "slots": _toml(list(kind.slots)),
        "given": _toml(kind.given),
        "masked": _toml([*kind.masked, "robsim.teach.assignments"]),
        "task": _toml(task.name),
        "class": f"robsim.teach.{kind.__name__}",
        "public_title": _toml(f"{kind.title[0].upper()}{kind.title[1:]}"),
        "hidden_title": _toml(f"{kind.title[0].upper()}{kind.title[1:]}, in other worlds"),
        "parameters": "\n".join(_parameters(task.parameters)),
    }


def _title(task: Task) -> str:
    return task.sheet.splitlines()[0].removeprefix("# ")


def _parameters(values: Mapping[str, Any]) -> list[str]:
    return [f"{key} = {_toml(value)}" for key, value in values.items() if value is not None]


def _toml(value: Any) -> str:
    import tomlkit

    return str(tomlkit.item(_listed(value)).as_string())


def _listed(value: Any) -> Any:
    """Return a value with lists for tuples, as TOML has them."""
    return [_listed(one) for one in value] if isinstance(value, (tuple, list)) else value


def _filled(name: str, values: Mapping[str, str]) -> str:
    text = (_FILES / name).read_text(encoding="utf-8")
    return string.Template(text).substitute(values)


def _write(file: Path, text: str) -> None:
    write_whole(file, text.encode())
