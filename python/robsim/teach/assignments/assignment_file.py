"""Reading `assignment.toml` and the other files of its folder."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields, replace
from datetime import date, datetime, time
from functools import partial
from os import PathLike
from pathlib import Path
from types import MappingProxyType
from typing import Any

from robsim.base.checks import check_choice, check_float, check_name, check_text
from robsim.base.files import as_folder, codec, content_of, read_text
from robsim.base.spelling import check_names
from robsim.base.text import one_line, quoted
from robsim.teach.assignments.assignment import (
    BY_HAND,
    SECONDS,
    SEEDS,
    Assignment,
    FileTests,
    LateRule,
    TaskTest,
)
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
_GIVEN = ("pose", "blobs", "frames")  # each includes the previous ones
_MOST_POINTS, _MOST_SECONDS, _MOST_GIVEN = 1e6, 1e6, 2**24


def _title(name: str, value: Any) -> str:
    if not check_text(name, value):
        raise ValueError(f"{name} must be a text, got an empty one")
    return str(value)


def _path(name: str, value: Any) -> str:
    path = Path(_title(name, value))
    if path.is_absolute() or ".." in path.parts or path.suffix != ".py":
        raise ValueError(
            f"{name} must be the path of a Python file in the folder, got {quoted(value)}"
        )
    return str(value)


def _test_name(name: str, value: Any) -> str:
    if not check_text(name, value).isidentifier():  # it is part of the names of files
        raise ValueError(f"{name} must have only letters, digits and _, got {quoted(value)}")
    return str(value)


def _slots(name: str, value: Any) -> tuple[str, ...]:
    slots = codec.names(name, value)
    check_names(f"{name}: unknown slot", slots, ROBOT_SLOTS, ValueError)
    return slots


def _limits(submission: float = SECONDS, **limits: Any) -> tuple[float, WorkerLimits]:
    return submission, WorkerLimits(**limits)


def _time(name: str, value: Any) -> datetime:
    """Return a time, or the start of a date; without a zone, in this machine's zone."""
    if not isinstance(value, date):
        expected = "a date or a time, such as 2026-12-01T08:00:00+01:00"
        raise TypeError(f"{name} must be {expected}, got {codec.in_words(value)}")
    when = value if isinstance(value, datetime) else datetime.combine(value, time())
    return when if when.tzinfo else when.astimezone()


_POINTS = partial(check_float, minimum=0, maximum=_MOST_POINTS)
_SECONDS = partial(check_float, minimum=0, maximum=_MOST_SECONDS)
_LIMITS = codec.Table(
    _limits, dict.fromkeys(WorkerLimits.__dataclass_fields__, "") | {"submission": _SECONDS}
)
_DAYS = partial(check_float, minimum=0)
_SHARE = partial(check_float, minimum=0, maximum=1)
_LATE = codec.Table(LateRule, {"per_day": _SHARE, "free_days": _DAYS, "most_days": _DAYS})


def _by_hand(name: str, value: Any) -> Mapping[str, float]:
    for key in (points := codec.named(_POINTS).read(name, value)):
        if _test_name(name, key) in BY_HAND:
            raise ValueError(f"{key} is already a column of by_hand.csv: choose another name")
    return dict(points)


def _table(folder: Path) -> codec.Table:
    """Return the table of the file in a folder."""
    tests = codec.Table(
        partial(_test, folder, read_limits(folder)),
        {
            "name": _test_name,
            "title": _title,
            "number": _title,
            "task": partial(check_choice, choices=tuple(TASKS)),
            "points": _POINTS,
            "public": codec.flag,
            "parameters": codec.as_table,
        },
        needed=("points", "public"),
    )
    files = codec.Table(partial(_file_tests, folder), {"path": _path, "public": codec.flag})
    return codec.Table(
        partial(_assignment, folder),
        {
            "name": check_name,
            "title": _title,
            "slots": _slots,
            "functions": codec.names,
            "given": partial(check_choice, choices=_GIVEN),
            "imports": codec.names,
            "masked": codec.names,
            "defaults": codec.flag,
            "seeds": partial(check_choice, choices=SEEDS),
            "isolation": partial(check_choice, choices=LEVELS),
            "points": _POINTS,
            "limits": _LIMITS,
            "hidden_from": _time,
            "leaderboard": check_text,
            "late": _LATE,
            "by_hand": _by_hand,
            "tests": codec.listed(tests),
            "files": codec.listed(files),
        },
        needed=("name", "title"),
    )


def load_assignment(
    folder: str | PathLike[str], *, isolation: Isolation | None = None
) -> Assignment:
    """Read the folder of an assignment without running any code.

    Parameters
    ----------
    folder : path
        The folder, with ``assignment.toml`` and, optionally, ``limits.json``, ``key``, ``given/``
        and, for each kind of task, ``solutions/TASK/right`` and ``wrong``. Without these solutions,
        robsim's own solutions are the references.
    isolation : {"auto", "strict", "process", "none"}, optional
        The isolation of submissions. Default: the value in the folder.

    Raises
    ------
    AssignmentError
        If a part is missing or wrong; the message names file and key.
    TypeError, ValueError
        If an argument is wrong; the message names it.

    Examples
    --------
    >>> made = robsim.teach.new_assignment("park", "hw1", seed=1)
    >>> robsim.teach.load_assignment("hw1").slots
    ('control',)
    """
    if isolation is not None:
        check_choice("isolation", isolation, LEVELS)
    folder = as_folder(folder)
    try:
        made: Assignment = codec.read_table(
            _text_in(folder), lambda table: _table(folder).read(FILE, table), FILE
        )
    except ValueError as error:
        raise AssignmentError(str(error), file=FILE) from None
    return made if isolation is None else replace(made, isolation=isolation)


def _text_in(folder: Path) -> str:
    try:
        return read_text(folder / FILE)
    except FileNotFoundError:
        what = "the folder is missing" if not folder.exists() else f"{FILE} is missing"
        raise ValueError(f"{one_line(folder)} is not an assignment: {what}") from None
    except OSError as error:
        raise ValueError(str(error)) from None


def _assignment(
    folder: Path,
    slots: tuple[str, ...] | None = None,
    given: str | None = None,
    masked: tuple[str, ...] | None = None,
    seeds: str = SEEDS[0],
    limits: tuple[float, WorkerLimits] = (SECONDS, WorkerLimits()),
    tests: Sequence[TaskTest] = (),
    files: Sequence[FileTests] = (),
    **others: Any,
) -> Assignment:
    names = [test.name for test in tests]
    if twice := next((name for name in names if names.count(name) > 1), None):
        raise ValueError(f"duplicate test {quoted(twice)}: rename one")
    if not tests and not files:
        raise ValueError("there are no tests: add tests, each below a line [[tests]] or [[files]]")
    assignment = Assignment(
        folder=folder.absolute(),
        slots=_slots_for(slots, tests),
        masked=_masked(masked, tests),
        given=_given_for(given, tests),
        given_files=_given_files(folder),
        own_seeds=seeds == SEEDS[0],
        key=keys.Key.load(folder / KEY) if (folder / KEY).exists() else None,
        seconds=limits[0],
        limits=limits[1],
        tests=tuple(tests),
        files=tuple(files),
        **others,
    )
    assignment._rules()
    public = [test for test in tests if test.public]
    scores = [f"{test.name}.{score.name}" for test in public for score in test.task.scores]
    asked = filter(None, [assignment.leaderboard])
    check_names("leaderboard: no public test has the score", asked, scores, ValueError)
    return assignment


def _test(
    folder: Path,
    recorded: Mapping[str, RecordedTest],
    name: str,
    task: str,
    parameters: Mapping[str, Any] = MappingProxyType({}),
    **others: Any,
) -> TaskTest:
    made, known = _task(task, parameters), recorded.get(name, RecordedTest())
    check_names(
        f"limits.json, {name}: the task has no score",
        known.limits,
        [score.name for score in made.scores],
        lambda message: AssignmentError(message, file="limits.json"),
    )
    solutions = solutions_for(folder, made)
    stale = None if known.calibration is None else known.calibration.stale(made, solutions)
    rest = {"title": made.title, "stale": stale or "", **others}
    return TaskTest(
        name=name,
        task=made,
        limits=known.limits,
        provisional=known.provisional,
        reference=solutions[0],
        reference_values=known.reference,
        **rest,
    )


def _task(name: str, parameters: Mapping[str, Any]) -> Task:
    known = [field.name for field in fields(TASKS[name])]
    for key in parameters:
        codec.check_key(key, known, f"the task {name} has no")
    return task(name, **{key: _frozen(value) for key, value in parameters.items()})


def _frozen(value: Any) -> Any:
    """Return an array of TOML as a tuple, for parameters of tasks."""
    return tuple(map(_frozen, value)) if isinstance(value, list) else value


def solutions_for(folder: Path, made: Task) -> tuple[Solution, ...]:
    """Return the assignment's own solutions of a task, else robsim's own."""
    place = folder / SOLUTIONS / made.name
    try:
        return solutions_in(place, made.slots) if place.exists() else made.solutions
    except (OSError, ValueError) as error:
        raise AssignmentError(f"{SOLUTIONS}/{made.name}: {error}", file=SOLUTIONS) from None


def _file_tests(folder: Path, path: str, public: bool) -> FileTests:
    if not (folder / path).is_file():
        raise ValueError(f"file {one_line(path)} is missing")
    return FileTests(path=(folder / path).absolute(), public=public)


def _slots_for(slots: tuple[str, ...] | None, tests: Sequence[TaskTest]) -> tuple[str, ...]:
    needed = tuple(dict.fromkeys(slot for test in tests for slot in test.task.slots))
    if not needed and slots is None:
        raise ValueError("slots is missing")
    if missing := [slot for slot in needed if slots is not None and slot not in slots]:
        raise ValueError(f"slots must have {', '.join(missing)}, which the tasks of its tests need")
    return needed if slots is None else slots


def _given_for(given: str | None, tests: Sequence[TaskTest]) -> str:
    most = max((_GIVEN.index(test.task.given) for test in tests), default=0)
    if given is not None and _GIVEN.index(given) < most:
        raise ValueError(f"given must be {_GIVEN[most]!r} for the tasks here, got {given!r}")
    return given or _GIVEN[most]


def _masked(names: tuple[str, ...] | None, tests: Sequence[TaskTest]) -> tuple[str, ...]:
    of_tests = [name for test in tests for name in test.task.masked]
    default = (*(of_tests or Task.masked), "robsim.teach.assignments")
    return tuple(dict.fromkeys(default if names is None else names))


def _given_files(folder: Path) -> dict[str, bytes]:
    """Return the files of ``given/`` by name."""
    place = folder / GIVEN
    if not place.exists():
        return {}
    try:
        files = [file for file in sorted(place.iterdir()) if not file.name.startswith((".", "__"))]
        files = [file for file in files if file.name != f"{MODULE}.py"]
        if sum(file.stat().st_size for file in files) > _MOST_GIVEN:
            raise ValueError(f"maximum size {_MOST_GIVEN >> 20} MB exceeded")
        found = {file.name: content_of(file, _MOST_GIVEN) for file in files}
        for name in found:
            checked_path(name, GIVEN)
    except OSError as error:
        raise ValueError(f"{GIVEN}/ must have only files: {error}") from None
    except Exception as error:
        raise ValueError(f"{GIVEN}/: {error}") from None
    return found
