"""Reading `assignment.toml`, and what lies beside it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, replace
from functools import partial
from os import PathLike
from pathlib import Path
from typing import Any

from robsim.base.checks import check_choice, check_name
from robsim.base.files import as_folder, codec, parse_toml, read_text
from robsim.base.spelling import check_names
from robsim.base.text import one_line, quoted
from robsim.teach.assignments.assignment import SECONDS, SEEDS, Assignment, FileTests, TaskTest
from robsim.teach.assignments.limits_file import RecordedTest, read_limits
from robsim.teach.errors import AssignmentError
from robsim.teach.grading import keys
from robsim.teach.grading.robot_half import ROBOT_SLOTS
from robsim.teach.isolation.limits import LEVELS, Isolation, WorkerLimits
from robsim.teach.submissions.names import checked_path
from robsim.teach.tasks.by_name import TASKS, task
from robsim.teach.tasks.definition import Task
from robsim.teach.tasks.solutions import MODULE, Solution, solutions_in

FILE, KEY, GIVEN, SOLUTIONS = "assignment.toml", "key", "given", "solutions"
#: What files of version 0.1 may mask, by the names of then.
_OLD_MASKS = {
    "robsim.reference": "robsim.estimation.reference",
    **{f"robsim.{room}": f"robsim.teach.{room}" for room in ("tasks", "grading", "assignments")},
}
_GIVEN = ("pose", "blobs", "frames")  # each has what those before it have
_MOST_POINTS, _MOST_SECONDS, _MOST_GIVEN = 1e6, 1e6, 2**24


def _title(name: str, value: Any) -> str:
    if not codec.text(name, value):
        raise ValueError(f"{name} must be a text, got none")
    return str(value)


def _path(name: str, value: Any) -> str:
    path = Path(_title(name, value))
    if path.is_absolute() or ".." in path.parts or path.suffix != ".py":
        raise ValueError(f"{name} must lead to a Python file in the folder, got {quoted(value)}")
    return str(value)


def _test_name(name: str, value: Any) -> str:
    if not codec.text(name, value).isidentifier():  # it is part of the names of files
        raise ValueError(f"{name} must be of letters, digits and _, got {quoted(value)}")
    return str(value)


def _limits(**limits: Any) -> tuple[float, WorkerLimits]:
    return limits.pop("submission", SECONDS), WorkerLimits(**limits)


def _slots(name: str, value: Any) -> tuple[str, ...]:
    slots = codec.names(name, value)
    check_names(f"{name}: the robot has no", slots, ROBOT_SLOTS, ValueError)
    return slots


_POINTS = codec.Entry(codec.up_to(_MOST_POINTS))
_PUBLIC = codec.Entry(codec.flag, is_needed=True)
_LIMITS = codec.Table(
    _limits,
    {name: codec.Entry(codec.anything) for name in WorkerLimits.__dataclass_fields__}
    | {"submission": codec.Entry(codec.up_to(_MOST_SECONDS))},
)
_TEST = codec.Table(
    dict,
    {
        "name": codec.Entry(_test_name, is_needed=True),
        "title": codec.Entry(_title),
        "number": codec.Entry(_title),
        "task": codec.Entry(codec.choice(*TASKS), is_needed=True),
        "points": replace(_POINTS, is_needed=True),
        "public": _PUBLIC,
        "parameters": codec.Entry(codec.as_table),
    },
)
_FILE_TESTS = codec.Table(dict, {"path": codec.Entry(_path, is_needed=True), "public": _PUBLIC})
_ASSIGNMENT = codec.Table(
    dict,
    {
        "name": codec.Entry(check_name, is_needed=True),
        "title": codec.Entry(_title, is_needed=True),
        "slots": codec.Entry(_slots),
        "functions": codec.Entry(codec.names),
        "given": codec.Entry(codec.choice(*_GIVEN)),
        "imports": codec.Entry(codec.names),
        "masked": codec.Entry(codec.names),
        "seeds": codec.Entry(codec.choice(*SEEDS)),
        "isolation": codec.Entry(codec.choice(*LEVELS)),
        "points": _POINTS,
        "limits": codec.Entry(_LIMITS.read),
        "tests": codec.Entry(partial(codec.listed_tables, read=_TEST.read)),
        "files": codec.Entry(partial(codec.listed_tables, read=_FILE_TESTS.read)),
    },
)


def load_assignment(
    folder: str | PathLike[str], *, isolation: Isolation | None = None
) -> Assignment:
    """Read the folder of an assignment; nothing in it is run.

    Parameters
    ----------
    folder : path
        The folder, with ``assignment.toml`` and, as far as there are such, ``limits.json``,
        ``key``, ``given/`` and, for each kind of task, ``solutions/TASK/right`` and
        ``wrong``. Without these solutions those that ship with robsim are the references.
    isolation : {"auto", "strict", "process", "none"}, optional
        How submissions are shut in. Default: as the folder says.

    Raises
    ------
    AssignmentError
        If something in it is missing or wrong; the message names file and key.
    TypeError, ValueError
        If an argument is wrong; the message names it.
    """
    if isolation is not None:
        check_choice("isolation", isolation, LEVELS)
    folder = as_folder(folder)
    try:
        written = _text_in(folder)
        with codec.telling(FILE, written):
            values = _ASSIGNMENT.read(FILE, parse_toml(written))
            return _assignment(values, folder, isolation)
    except ValueError as error:
        raise AssignmentError(str(error), file=FILE) from None


def _text_in(folder: Path) -> str:
    try:
        return read_text(folder / FILE)
    except FileNotFoundError:
        what = "there is no such folder" if not folder.exists() else f"it has no {FILE}"
        raise ValueError(f"{one_line(folder)} is not an assignment: {what}") from None
    except OSError as error:
        raise ValueError(str(error)) from None


def _assignment(values: dict[str, Any], folder: Path, isolation: Isolation | None) -> Assignment:
    tests = _tests(values.get("tests", []), folder)
    files = tuple(
        _file_tests(one, folder, number) for number, one in enumerate(values.get("files", []), 1)
    )
    if not tests and not files:
        raise ValueError("it has no tests: add some, each below a line [[tests]] or [[files]]")
    seconds, limits = values.get("limits", (SECONDS, WorkerLimits()))
    assignment = Assignment(
        folder=folder.absolute(),
        name=values["name"],
        title=values["title"],
        slots=_slots_for(values, tests),
        functions=values.get("functions", ()),
        imports=values.get("imports"),
        masked=_masked(values, tests),
        given=_given(values, tests),
        given_files=_given_files(folder),
        own_seeds=values.get("seeds", SEEDS[0]) == SEEDS[0],
        key=keys.Key.load(folder / KEY) if (folder / KEY).exists() else None,
        isolation=isolation or values.get("isolation", "auto"),
        limits=limits,
        points=values.get("points"),
        seconds=seconds,
        tests=tests,
        files=files,
    )
    assignment._rules()
    return assignment


def _tests(tables: list[dict[str, Any]], folder: Path) -> tuple[TaskTest, ...]:
    recorded = read_limits(folder)
    tests: dict[str, TaskTest] = {}
    for number, values in enumerate(tables, 1):
        with codec.within("tests", str(number)):
            test = _test(values, folder, recorded)
        if test.name in tests:
            raise ValueError(f"two tests have the name {quoted(test.name)}")
        tests[test.name] = test
    return tuple(tests.values())


def _test(values: dict[str, Any], folder: Path, recorded: Mapping[str, RecordedTest]) -> TaskTest:
    name, made = values["name"], _task(values["task"], values.get("parameters", {}))
    known = recorded.get(name, RecordedTest())
    check_names(
        f"limits.json, {name}: the task has no score",
        known.limits,
        [score.name for score in made.scores],
        lambda message: AssignmentError(message, file="limits.json"),
    )
    solutions = solutions_for(folder, made)
    stale = None if known.calibration is None else known.calibration.stale(made, solutions)
    return TaskTest(
        name=name,
        title=values.get("title", made.title),
        number=values.get("number", ""),
        task=made,
        points=values["points"],
        public=values["public"],
        limits=known.limits,
        stale=stale or "",
        reference=solutions[0],
        reference_values=known.reference,
    )


def _task(name: str, parameters: Mapping[str, Any]) -> Task:
    known = [field.name for field in fields(TASKS[name])]
    for key in parameters:
        codec.check_key(key, known, f"the task {name} has no")
    return task(name, **{key: _frozen(value) for key, value in parameters.items()})


def _frozen(value: Any) -> Any:
    """Return an array of TOML as a tuple, as tasks have them."""
    return tuple(map(_frozen, value)) if isinstance(value, list) else value


def solutions_for(folder: Path, made: Task) -> tuple[Solution, ...]:
    """Return the assignment's own solutions of a task, else those that ship with robsim."""
    place = folder / SOLUTIONS / made.name
    try:
        return solutions_in(place, made.slots) if place.exists() else made.solutions
    except (OSError, ValueError) as error:
        raise AssignmentError(f"{SOLUTIONS}/{made.name}: {error}", file=SOLUTIONS) from None


def _file_tests(values: dict[str, Any], folder: Path, number: int) -> FileTests:
    path = folder / values["path"]
    if not path.is_file():
        raise codec.WrongTable(
            f"there is no file {one_line(values['path'])}", ("files", str(number))
        )
    return FileTests(path=path.absolute(), public=values["public"])


def _slots_for(values: dict[str, Any], tests: tuple[TaskTest, ...]) -> tuple[str, ...]:
    needed = tuple(dict.fromkeys(slot for test in tests for slot in test.task.slots))
    slots: tuple[str, ...] = values.get("slots", needed)
    if not slots and "slots" not in values:
        raise ValueError("slots is missing")
    if missing := [slot for slot in needed if slot not in slots]:
        raise codec.WrongTable(f"slots must have {', '.join(missing)}, which its tasks need")
    return slots


def _given(values: dict[str, Any], tests: tuple[TaskTest, ...]) -> str:
    most = max((_GIVEN.index(test.task.given) for test in tests), default=0)
    given: str = values.get("given", _GIVEN[most])
    if _GIVEN.index(given) < most:
        raise codec.WrongTable(
            f"given must be {_GIVEN[most]!r}, as its tasks need it, got {quoted(given)}"
        )
    return given


def _masked(values: dict[str, Any], tests: tuple[TaskTest, ...]) -> tuple[str, ...]:
    of_tests = [name for test in tests for name in test.task.masked]
    names = values.get("masked", [*(of_tests or Task.masked), "robsim.teach.assignments"])
    return tuple(dict.fromkeys(_OLD_MASKS.get(name, name) for name in names))


def _given_files(folder: Path) -> dict[str, bytes]:
    """Return the files of ``given/`` by name."""
    place = folder / GIVEN
    if not place.exists():
        return {}
    try:
        files = [file for file in sorted(place.iterdir()) if not file.name.startswith((".", "__"))]
        found = {file.name: file.read_bytes() for file in files if file.name != f"{MODULE}.py"}
        for name in found:
            checked_path(name, GIVEN)
    except OSError as error:
        raise ValueError(f"{GIVEN}/ must have files alone: {error}") from None
    except Exception as error:
        raise ValueError(f"{GIVEN}/: {error}") from None
    if sum(map(len, found.values())) > _MOST_GIVEN:
        raise ValueError(f"{GIVEN}/ must have at most {_MOST_GIVEN >> 20} MB")
    return found
