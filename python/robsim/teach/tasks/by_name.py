"""Tasks by name, as commands and files of assignments have them."""

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
        What differs from its defaults, as of its class.

    Returns
    -------
    Task
        The task.

    Raises
    ------
    TypeError, ValueError
        If there is no such task or parameter, or a value is wrong; the message names it, and what
        was meant.

    Examples
    --------
    >>> robsim.teach.task("measure", noise=20).noise
    20
    """
    check_names("there is no task", [check_text("name", name)], TASKS, ValueError)
    return TASKS[name](**parameters)
