"""Tasks by the names that commands and assignment files use."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from robsim.base.checks import check_text
from robsim.base.spelling import check_names
from robsim.teach.tasks.definition import Task
from robsim.teach.tasks.kinds.estimate import EstimateTask
from robsim.teach.tasks.kinds.follow import FollowTask
from robsim.teach.tasks.kinds.identify import IdentifyTask
from robsim.teach.tasks.kinds.measure import MeasureTask
from robsim.teach.tasks.kinds.park import ParkTask

_KINDS = (ParkTask, FollowTask, IdentifyTask, MeasureTask, EstimateTask)

#: The kinds of tasks by name.
TASKS: Mapping[str, type[Task]] = MappingProxyType({kind.name: kind for kind in _KINDS})


def task(name: str, /, **parameters: Any) -> Task:
    """Return a task by name.

    Parameters
    ----------
    name : str
        One of `TASKS`, such as ``"measure"``.
    **parameters
        Values that differ from the defaults; the task's class documents them.

    Returns
    -------
    Task
        The task.

    Raises
    ------
    TypeError, ValueError
        If a task or a parameter is unknown, or a value is invalid; the message names the problem
        and suggests a similar name.

    Examples
    --------
    >>> robsim.teach.task("measure", noise=20).noise
    20
    """
    check_names("unknown task", [check_text("name", name)], TASKS, ValueError)
    return TASKS[name](**parameters)
