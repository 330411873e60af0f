"""What a controller would do if it did one thing the other way round: the mistake undone."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from robsim.base.checks import Floats
from robsim.simulation.slots import RobotSlots
from robsim.teach.doctor.callbacks.steering import MISTAKES
from robsim.teach.tasks.definition import Task
from robsim.teach.tasks.solutions import Solution
from robsim.teach.tasks.trial import TaskTrial

_SLOT = RobotSlots.control.name
_OWN = "robsim_own_control"  # the module of the controller
_RUNS = 3
_ARRIVES = 40.0  # px, from the goal

_EXCHANGED = f"""
from {_OWN} import control as own


def control(step):
    left, right = own(step)
    return right, left
"""

# A robot in a mirror: the heading is another one, and left is right.
_MIRRORED = f"""
import robsim
from {_OWN} import control as own


def control(step):
    seen = step.measurement
    if seen is not None:
        x, y, heading = seen.pose
        seen = robsim.Measurement((x, y, {{heading}}), covariance=seen.covariance)
    left, right = own(
        robsim.Step(k=step.k, t=step.t, dt=step.dt, last_u=step.last_u[::-1], measurement=seen)
    )
    return right, left
"""

_LIMITED = f"""
import numpy as np
from {_OWN} import control as own


def control(step):
    return np.clip(own(step), -{{limit}}, {{limit}})
"""


@dataclass(frozen=True)
class _Undone:
    """A mistake, and the code that undoes it."""

    kind: str
    sentence: str
    code: str


_WAYS = (
    _Undone(
        "motors exchanged",
        "left and right are exchanged: u1 is the left motor, and a faster left wheel turns the "
        "robot to the right, to larger headings. With its two voltages the other way round it "
        "comes to the goal",
        _EXCHANGED,
    ),
    *(
        _Undone(
            kind,
            f"{sentence}. With that undone it comes to the goal",
            _MIRRORED.format(heading=heading),
        )
        for (_, kind, sentence), heading in zip(
            MISTAKES, ("-heading", f"{np.pi / 2} - heading"), strict=True
        )
    ),
)


def mistakes_undone(task: Task, solution: Solution, goal: Floats) -> Iterator[tuple[str, str]]:
    """Yield kind and sentence of the first mistake without which the robot comes to the goal."""
    for way in _WAYS:
        trial = _trial(task, solution, way.code)
        if trial.trace is not None and _comes_near(trial.trace.pose_true, goal):
            yield way.kind, way.sentence
            return


def limited(task: Task, solution: Solution, limit: float) -> TaskTrial:
    """Return the trial of a controller whose voltages are limited (V)."""
    return _trial(task, solution, _LIMITED.format(limit=limit))


def _comes_near(poses: Floats, goal: Floats) -> bool:
    return bool(np.hypot(*(poses[-1, :2] - goal[:2])) < _ARRIVES)


def _trial(task: Task, solution: Solution, code: str) -> TaskTrial:
    """Return the trial of a controller that is called by other code."""
    files = {**solution.files, _OWN: solution.files[_SLOT], _SLOT: code.encode()}
    return task.try_out(replace(solution, files=files), runs=_RUNS, progress=False)
