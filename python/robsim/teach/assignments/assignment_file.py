"""Reading `assignment.toml`, and what lies beside it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from os import PathLike
from pathlib import Path
from typing import Any, NoReturn, TypeVar

from robsim.base.checks import check_choice, check_name, is_int
from robsim.base.files import as_folder, read_toml
from robsim.base.spelling import check_names
from robsim.base.text import one_line, quoted
from robsim.teach.assignments.assignment import SECONDS, SEEDS, Assignment, FileTests, TaskTest
from robsim.teach.assignments.limits_file import RecordedTest, read_limits
from robsim.teach.errors import AssignmentError
from robsim.teach.grading.keys import Key
from robsim.teach.grading.robot_half import ROBOT_SLOTS
from robsim.teach.isolation.limits import LEVELS, Isolation, WorkerLimits
from robsim.teach.submissions.names import checked_path
from robsim.teach.tasks.by_name import TASKS, task
from robsim.teach.tasks.definition import Task
from robsim.teach.tasks.solutions import MODULE, Solution, solutions_in

_NEEDED: Any = object()
_Text = TypeVar("_Text", bound=str)


class Keys:
    """A table of a file: each key is asked for once, with what it must be.

    Parameters
    ----------
    values : mapping of str to value
        The table.
    file : str
        The name of the file, for messages.
    known : tuple of str
        All keys that there may be.
    where : str
        Which table of the file it is, for messages; "" = the file itself.

    Raises
    ------
    AssignmentError
        If it has other keys.
    """

    def __init__(
        self, values: Mapping[str, Any], file: str, known: tuple[str, ...], where: str = ""
    ) -> None:
        self._values = values
        self.file = file
        self.place = f"{file}, {where}" if where else file
        check_names(f"{self.place}: there is no key", values, known, self._error)

    def __contains__(self, key: str) -> bool:
        return key in self._values

    def _error(self, message: str) -> AssignmentError:
        return AssignmentError(message, file=self.file)

    def refuse(self, message: object) -> NoReturn:
        raise self._error(f"{self.place}: {message}") from None

    def _got(self, key: str, expected: str) -> NoReturn:
        self.refuse(f"{key} must be {expected}, got {quoted(self._values[key])}")

    def _given(self, key: str, default: Any) -> bool:
        """Whether a key is there; raise AssignmentError if it is not, and must be."""
        if key not in self._values and default is _NEEDED:
            self.refuse(f"{key} is missing")
        return key in self._values

    def text(self, key: str, default: str = _NEEDED) -> str:
        """Return a text."""
        if not self._given(key, default):
            return default
        value = self._values[key]
        return value if isinstance(value, str) and value else self._got(key, "a text")

    def choice(self, key: str, choices: tuple[_Text, ...], default: _Text = _NEEDED) -> _Text:
        """Return one of some texts."""
        if not self._given(key, default):
            return default
        try:
            return check_choice(key, self._values[key], choices)
        except (TypeError, ValueError) as error:
            self.refuse(error)

    def flag(self, key: str, default: bool = _NEEDED) -> bool:
        """Return true or false."""
        if not self._given(key, default):
            return default
        value = self._values[key]
        return value if isinstance(value, bool) else self._got(key, "true or false")

    def number(self, key: str, default: float = _NEEDED, *, most: float) -> float:
        """Return a number from 0 to the most."""
        if not self._given(key, default):
            return default
        value = self._values[key]
        if not (is_int(value) or isinstance(value, float)) or not 0 <= value <= most:
            self._got(key, f"a number within 0..{most:g}")
        return float(value)

    def names(self, key: str, default: tuple[str, ...] | None = _NEEDED) -> tuple[str, ...] | None:
        """Return a list of texts."""
        if not self._given(key, default):
            return default
        value = self._values[key]
        if not isinstance(value, list) or not all(isinstance(one, str) for one in value):
            self._got(key, 'a list of names, such as ["numpy"]')
        return tuple(value)

    def table(self, key: str) -> Mapping[str, Any]:
        """Return a table; empty, where there is none."""
        value = self._values.get(key, {})
        return value if isinstance(value, dict) else self._got(key, f"a table, [{key}]")

    def tables(self, key: str) -> list[Mapping[str, Any]]:
        """Return a list of tables; empty, where there is none."""
        value = self._values.get(key, [])
        if not isinstance(value, list) or not all(isinstance(one, dict) for one in value):
            self._got(key, f"tables, each below a line [[{key}]]")
        return list(value)


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
_LIMIT_KEYS = (*WorkerLimits.__dataclass_fields__, "submission")
_GIVEN = ("pose", "blobs", "frames")  # each has what those before it have
_MOST_POINTS, _MOST_SECONDS, _MOST_GIVEN = 1e6, 1e6, 2**24


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
    keys = Keys(_toml(folder), FILE, _KEYS)
    tests = _tests(keys, folder)
    files = tuple(
        _file_tests(values, number, folder) for number, values in _numbered(keys, "files")
    )
    if not tests and not files:
        keys.refuse("it has no tests: add some, each below a line [[tests]] or [[files]]")
    seconds, limits = _limits(keys)
    level = keys.choice("isolation", LEVELS, "auto")
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
        isolation=isolation or level,
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


def _limits(keys: Keys) -> tuple[float, WorkerLimits]:
    values = dict(keys.table("limits"))
    own = Keys(values, FILE, _LIMIT_KEYS, "[limits]")
    seconds = own.number("submission", SECONDS, most=_MOST_SECONDS)
    values.pop("submission", None)
    try:
        return seconds, WorkerLimits(**values)
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
