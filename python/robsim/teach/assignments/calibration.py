"""`calibrate_assignment`: limits for the tests of an assignment, and their basis."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator
from concurrent.futures import Executor
from os import PathLike
from typing import Any

from robsim.base.checks import check_bool, check_callable
from robsim.base.text import one_line
from robsim.campaigns.engines.executors import DaskClient
from robsim.teach.assignments import limits_file
from robsim.teach.assignments.assignment import Assignment, TaskTest
from robsim.teach.assignments.assignment_file import SOLUTIONS, load_assignment, solutions_for
from robsim.teach.assignments.marking.references import key_for
from robsim.teach.errors import AssignmentError
from robsim.teach.tasks.definition import Task
from robsim.teach.tasks.marks.calibrate import calibrate_task, calibration_seconds, check_solutions
from robsim.teach.tasks.marks.calibration import TaskCalibration, solutions_digest, task_digest
from robsim.teach.tasks.solutions import Solution

#: Runs of a cancelled calibration, in the folder of the assignment.
_KEPT = ".calibrating"


def calibrate_assignment(
    folder: str | PathLike[str],
    *,
    false_fail: float = 0.01,
    confidence: float = 0.95,
    provisional: bool = False,
    executor: int | str | Executor | DaskClient | None = None,
    progress: bool = True,
    on_begin: Callable[[float, bool], Any] | None = None,
) -> dict[str, TaskCalibration]:
    """Calibrate the limits of an assignment by its solutions, and write its ``limits.json``.

    The folder keeps the runs until exact limits are written. So the same call continues a cancelled
    calibration, and exact limits reuse the runs of provisional limits.

    Parameters
    ----------
    folder : path
        The folder of the assignment. The seeds of the runs come from the assignment's key.
    false_fail, confidence, provisional, executor, progress
        See `robsim.teach.calibrate_task`.
    on_begin : callable, optional
        Called with the estimated duration (s), and whether kept runs are reused.

    Returns
    -------
    dict of str to TaskCalibration
        The calibration of each test by a task; tests with the same task share one.

    Raises
    ------
    AssignmentError
        If the assignment is unreadable, has no key, or lacks suitable solutions.
    OSError
        If the limits cannot be written.
    TypeError, ValueError
        If an argument is wrong.

    Examples
    --------
    >>> assignment = robsim.teach.new_assignment("measure", "hw1", seed=1)
    >>> file = assignment.folder / "assignment.toml"
    >>> short = file.read_text().replace("steps = 60", "steps = 2").replace("runs = 10", "runs = 1")
    >>> size = file.write_text(short)
    >>> found = robsim.teach.calibrate_assignment("hw1", provisional=True, progress=False)
    >>> {name: (one.tests, one.provisional) for name, one in found.items()}
    {'public': (40, 'few tests'), 'hidden': (40, 'few tests')}
    """
    assignment = load_assignment(folder)
    check_bool("progress", progress)
    kept = assignment.folder / _KEPT
    check_callable("on_begin", on_begin)
    options: list[dict[str, Any]] = []
    for test, _ in _by_task(assignment):
        solutions = _usable(assignment, test.task)
        options.append(
            {
                "task": test.task,
                "solutions": solutions,
                "false_fail": false_fail,
                "confidence": confidence,
                "provisional": provisional,
                "seed": key_for(assignment, public=False).world_seed(
                    "", f"calibration {test.name}", 0
                ),
                "store": kept / f"{task_digest(test.task)}-{solutions_digest(solutions)}",
            }
        )
    if on_begin is not None:
        goes_on = kept.is_dir()
        processes = executor if isinstance(executor, int) else 1
        on_begin(sum(calibration_seconds(processes=processes, **one) for one in options), goes_on)
    found: dict[str, TaskCalibration] = {}
    for one, (_, names) in zip(options, _by_task(assignment), strict=True):
        made = calibrate_task(**one, executor=executor, progress=progress)
        found |= dict.fromkeys(names, made)
    limits_file.write_limits(
        assignment.folder, {test.name: found[test.name] for test in assignment.tests}
    )
    if not provisional:
        shutil.rmtree(kept, ignore_errors=True)
    return found


def _usable(assignment: Assignment, task: Task) -> tuple[Solution, ...]:
    place = f"{SOLUTIONS}/{task.name}"
    found = solutions_for(assignment.folder, task)
    try:
        check_solutions(found)
    except ValueError as error:
        raise AssignmentError(f"{place}: {error}", file=place) from None
    return found


def _by_task(assignment: Assignment) -> Iterator[tuple[TaskTest, list[str]]]:
    if not assignment.tests:
        raise AssignmentError(f"{one_line(assignment.folder)} has no test with a task")
    tests: dict[str, list[TaskTest]] = {}
    for test in assignment.tests:
        tests.setdefault(task_digest(test.task), []).append(test)
    for same in tests.values():
        yield same[0], [test.name for test in same]
