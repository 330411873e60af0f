"""Reading `assignment.toml`, and what lies beside it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from os import PathLike
from pathlib import Path
from typing import Any

from robsim.base.checks import check_name
from robsim.base.files import as_folder, read_toml
from robsim.base.spelling import check_names
from robsim.base.text import one_line, quoted
from robsim.teach.assignments._reading.limits_file import RecordedTest, read_limits
from robsim.teach.assignments._reading.table import Keys
from robsim.teach.assignments.assignment import SECONDS, SEEDS, Assignment, FileTests, TaskTest
from robsim.teach.errors import AssignmentError
from robsim.teach.grading.keys import Key
from robsim.teach.grading.robot_half import ROBOT_SLOTS
from robsim.teach.isolation.limits import Limits
from robsim.teach.isolation.request import LEVELS
from robsim.teach.submissions.names import checked_path
from robsim.teach.tasks.by_name import TASKS, task
from robsim.teach.tasks.definition import Task
from robsim.teach.tasks.solutions import MODULE, Solution, solutions_in

FILE, KEY, GIVEN, SOLUTIONS = "assignment.toml", "key", "given", "solutions"

_KEYS = (
    *("name", "title", "slots", "functions", "given", "imports", "masked", "seeds", "isolation"),
    *("points", "limits", "tests", "files"),
)
_TEST_KEYS = ("name", "title", "number", "task", "points", "public", "parameters")
_FILE_KEYS = ("path", "public")
#: What files of version 0.1 may mask, by the names of then.
_OLD_MASKS = {
    "robsim.reference": "robsim.estimation.reference",
    **{f"robsim.{room}": f"robsim.teach.{room}" for room in ("tasks", "grading", "assignments")},
}
_LIMIT_KEYS = (*Limits.__dataclass_fields__, "submission")
_GIVEN = ("pose", "blobs", "frames")  # each has what those before it have
_MOST_POINTS, _MOST_SECONDS, _MOST_GIVEN = 1e6, 1e6, 2**24


def read_assignment(path: str | PathLike[str]) -> Assignment:
    """Read an assignment; see `Assignment.load`."""
    folder = as_folder(path)
    keys = Keys(_toml(folder), FILE, _KEYS)
    tests = _tests(keys, folder)
    files = tuple(
        _file_tests(values, number, folder) for number, values in _numbered(keys, "files")
    )
    if not tests and not files:
        keys.refuse("it has no tests: add some, each below a line [[tests]] or [[files]]")
    seconds, limits = _limits(keys)
    assignment = Assignment(
        folder=folder.absolute(),
        name=_name(keys),
        title=keys.text("title"),
        slots=_slots(keys, tests),
        functions=keys.names("functions", ()) or (),
        imports=keys.names("imports", None),
        masked=_renamed(keys.names("masked", _masked(tests)) or ()),
        given=_given(keys, tests),
        given_files=_given_files(folder),
        own_seeds=keys.choice("seeds", SEEDS, SEEDS[0]) == SEEDS[0],
        key=Key.read(folder / KEY) if (folder / KEY).exists() else None,
        isolation=keys.choice("isolation", LEVELS, "auto"),
        limits=limits,
        points=keys.number("points", most=_MOST_POINTS) if "points" in keys else None,
        seconds=seconds,
        tests=tests,
        files=files,
    )
    _check_rules(keys, assignment)
    return assignment


def _toml(folder: Path) -> dict[str, Any]:
    file = folder / FILE
    try:
        return read_toml(file)
    except FileNotFoundError:
        what = "there is no such folder" if not folder.exists() else f"it has no {FILE}"
        message = f"{one_line(folder)} is not an assignment: {what}"
    except (OSError, ValueError) as error:
        message = str(error)
    raise AssignmentError(message, file=FILE) from None


def _numbered(keys: Keys, key: str) -> list[tuple[int, Mapping[str, Any]]]:
    return list(enumerate(keys.tables(key), 1))


def _name(keys: Keys) -> str:
    try:
        return check_name("name", keys.text("name"))
    except ValueError as error:
        keys.refuse(error)


def _tests(keys: Keys, folder: Path) -> tuple[TaskTest, ...]:
    recorded = read_limits(folder)
    tests: dict[str, TaskTest] = {}
    for number, values in _numbered(keys, "tests"):
        test = _test(Keys(values, FILE, _TEST_KEYS, f"[[tests]] {number}"), folder, recorded)
        if test.name in tests:
            keys.refuse(f"two tests have the name {quoted(test.name)}")
        tests[test.name] = test
    return tuple(tests.values())


def _test(keys: Keys, folder: Path, recorded: Mapping[str, RecordedTest]) -> TaskTest:
    name = keys.text("name")
    if not name.isidentifier():  # it is part of the names of files
        keys.refuse(f"name must be of letters, digits and _, got {quoted(name)}")
    made = _task(keys)
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
        title=keys.text("title", made.title),
        number=keys.text("number", ""),
        task=made,
        points=keys.number("points", most=_MOST_POINTS),
        public=keys.flag("public"),
        limits=known.limits,
        stale=stale or "",
        reference=solutions[0],
        reference_values=known.reference,
    )


def _task(keys: Keys) -> Task:
    parameters = {key: _frozen(value) for key, value in keys.table("parameters").items()}
    name = keys.choice("task", tuple(TASKS))
    known = [field.name for field in fields(TASKS[name])]
    check_names(f"{keys.place}: the task {name} has no", parameters, known, _refused)
    try:
        return task(name, **parameters)
    except (TypeError, ValueError) as error:
        keys.refuse(error)


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


def _file_tests(values: Mapping[str, Any], number: int, folder: Path) -> FileTests:
    keys = Keys(values, FILE, _FILE_KEYS, f"[[files]] {number}")
    name = keys.text("path")
    path = folder / name
    if Path(name).is_absolute() or ".." in Path(name).parts or path.suffix != ".py":
        keys.refuse(f"path must be that of a Python file in the folder, got {quoted(name)}")
    if not path.is_file():
        keys.refuse(f"there is no file {one_line(name)}")
    return FileTests(path=path.absolute(), public=keys.flag("public"))


def _slots(keys: Keys, tests: tuple[TaskTest, ...]) -> tuple[str, ...]:
    needed = tuple(dict.fromkeys(slot for test in tests for slot in test.task.slots))
    slots = keys.names("slots") if "slots" in keys or not needed else needed
    assert slots is not None
    check_names(f"{FILE}: slots: the robot has no", slots, ROBOT_SLOTS, _refused)
    if missing := [slot for slot in needed if slot not in slots]:
        keys.refuse(f"slots must have {', '.join(missing)}, which its tasks need")
    return slots


def _given(keys: Keys, tests: tuple[TaskTest, ...]) -> str:
    most = max((_GIVEN.index(test.task.given) for test in tests), default=0)
    given = keys.choice("given", _GIVEN, _GIVEN[most])
    if _GIVEN.index(given) < most:
        keys.refuse(f"given must be {_GIVEN[most]!r}, as its tasks need it, got {quoted(given)}")
    return given


def _masked(tests: tuple[TaskTest, ...]) -> tuple[str, ...]:
    names = [name for test in tests for name in test.task.masked]
    return tuple(dict.fromkeys([*(names or Task.masked), "robsim.teach.assignments"]))


def _renamed(masked: tuple[str, ...]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(_OLD_MASKS.get(name, name) for name in masked))


def _limits(keys: Keys) -> tuple[float, Limits]:
    values = dict(keys.table("limits"))
    own = Keys(values, FILE, _LIMIT_KEYS, "[limits]")
    seconds = own.number("submission", SECONDS, most=_MOST_SECONDS)
    values.pop("submission", None)
    try:
        return seconds, Limits(**values)
    except (TypeError, ValueError) as error:
        own.refuse(error)


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
        raise _refused(f"{GIVEN}/ must have files alone: {error}") from None
    except Exception as error:
        raise _refused(f"{GIVEN}/: {error}") from None
    if sum(map(len, found.values())) > _MOST_GIVEN:
        raise _refused(f"{GIVEN}/ must have at most {_MOST_GIVEN >> 20} MB")
    return found


def _refused(message: str) -> AssignmentError:
    return AssignmentError(message, file=FILE)


def _check_rules(keys: Keys, assignment: Assignment) -> None:
    try:
        assignment._rules()
    except (TypeError, ValueError) as error:
        keys.refuse(error)
