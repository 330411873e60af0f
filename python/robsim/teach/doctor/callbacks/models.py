"""`check_model` and `check_motion`: the checks of define_model and evaluate_model."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from os import PathLike
from typing import Any

import numpy as np

from robsim._core import RobotModel, RobotParameters, WorldState, wrap_angle
from robsim.base.check_report import CheckReport, Problem
from robsim.base.checks import Floats
from robsim.base.text import quoted
from robsim.simulation.slots import RobotSlots, WorldSlots
from robsim.teach.doctor._run_checks import BUDGET
from robsim.teach.doctor._situations import DT
from robsim.teach.doctor._trial import BadResult, finite_numbers
from robsim.teach.doctor.callbacks.scenes import CENTRE
from robsim.teach.doctor.callbacks.single_calls import CallbackCalls, check_calls

_STEPS = 100  # until the speed is steady
_SPEEDS = (1.0, 1000.0)  # px/s with 1 V, between which a robot of this size is plausible
_TURNS = (math.radians(1), math.radians(2000))  # rad/s with 1 V and -1 V.
_FAST = 100.0  # px in a step, from rest with 1 V

_INPUTS = {  # V
    "both motors forwards": (1.0, 1.0),
    "left motor only": (1.0, 0.0),
    "right motor only": (0.0, 1.0),
}
_HEADINGS = (0.0, math.pi / 2, math.pi, -math.pi / 2, -math.pi + 1e-9, 0.7)


def check_model(make: Callable[[], Any] | str | PathLike[str]) -> CheckReport:
    """Check the result of ``define_model`` and report its problems.

    Parameters
    ----------
    make : callable or path
        ``make() -> define_model``; for a plain function, ``lambda: define_model``. The path of a
        file ``define_model.py``, or of its callback folder, is also accepted.

    Returns
    -------
    CheckReport
        True if all checks pass.

    Raises
    ------
    TypeError, ValueError
        If `make` is not callable.

    Examples
    --------
    >>> robsim.teach.check_model(lambda: lambda: None).verdict
    'failed'
    """
    return check_calls(make, RobotSlots.define_model, _model_checks, BUDGET)


def _model_checks(calls: CallbackCalls) -> Iterator[Problem | str]:
    model = calls.call("the start of a run", read=_read_model)
    if not np.array_equal(model.theta, calls.call("a second run").theta):
        yield calls.problem(
            "not reproducible",
            "a second call returns another model; use robsim.Simulation(mismatch=...) for random "
            "parameters of the world, which repeat with the seed",
        )
    yield from _motion_problems(
        calls, lambda world: model.predict(world.pose_1, world.pose_2, world.last_u), model
    )
    speed, turn = (_steady(model, u) for u in ((1.0, 1.0), (1.0, -1.0)))
    if not (_SPEEDS[0] <= abs(speed[0]) <= _SPEEDS[1] and _TURNS[0] <= abs(turn[1]) <= _TURNS[1]):
        yield (
            f"with 1 V on both motors its robot drives at {speed[0]:.3g} px/s, with 1 V and -1 V "
            f"it turns at {np.degrees(turn[1]):.3g} degrees/s: are the units kg, m, N, s, V?"
        )


def _read_model(model: Any) -> RobotModel:
    if isinstance(model, RobotModel):
        return model
    is_inside = isinstance(model, RobotParameters)
    hint = ": the return is missing" if model is None else ""
    hint = ": write robsim.RobotModel(...) around it" if is_inside else hint
    raise BadResult("output type", f"it returns {quoted(model)}, not a RobotModel{hint}")


def _steady(model: RobotModel, u: tuple[float, float]) -> tuple[float, float]:
    before = pose = np.zeros(3)
    for _ in range(_STEPS):
        before, pose = pose, np.asarray(model.predict(pose, before, u))
        turn = wrap_angle(pose[2] - before[2])
        # Heading 0 again: the equation does not depend on where the robot is.
        way, shift = pose - before, pose.copy()
        shift[2] = pose[2]
        before, pose = before - shift, pose - shift
    return float(way[0]) / model.dt, float(turn) / model.dt


def check_motion(
    make: Callable[[], Any] | str | PathLike[str], *, budget: float = BUDGET
) -> CheckReport:
    """Check ``evaluate_model``, the motion of the simulated robot, and report its problems.

    Parameters
    ----------
    make : callable or path
        ``make() -> evaluate_model``; for a plain function, ``lambda: evaluate_model``. The path of
        a file ``evaluate_model.py``, or of its callback folder, is also accepted.
    budget : float
        Maximum of the median time per call (s).

    Returns
    -------
    CheckReport
        True if all checks pass.

    Raises
    ------
    TypeError, ValueError
        If `make` is not callable, or `budget` is out of range.

    Examples
    --------
    >>> robsim.teach.check_motion(robsim.Unicycle).verdict
    'passed'
    """
    return check_calls(make, WorldSlots.evaluate_model, _pose_checks, budget)


def _pose_checks(calls: CallbackCalls) -> Iterator[Problem | str]:
    model = RobotModel()
    for name, world in _worlds(model):
        calls.call(name, world, read=_read_pose)
    again = [[np.array(calls.call(n, w), float) for n, w in _worlds(model)] for _ in range(2)]
    if not np.array_equal(again[0], again[1]):
        yield (
            "the same motion gives another pose each time; use "
            "robsim.Simulation(process_noise=...) for a disturbance that repeats with the seed"
        )
        return
    yield from _motion_problems(calls, lambda world: calls.call("", world), model)


def _read_pose(result: Any) -> Floats:
    hint = "look for a division by 0, or an overflow"
    return finite_numbers(result, (3,), "the new pose: return (x, y, heading)", hint)


def _world(model: RobotModel, heading: float, u: tuple[float, float]) -> WorldState:
    pose = (*CENTRE[:2], heading)
    return WorldState(k=1, t=DT, dt=DT, model=model, pose_1=pose, pose_2=pose, last_u=u)


def _worlds(model: RobotModel) -> Iterator[tuple[str, WorldState]]:
    for name, u in {"robot stands, 0 V": (0.0, 0.0), **_INPUTS}.items():
        for heading in _HEADINGS:
            facing = f"heading {math.degrees(heading):.0f} degrees"
            yield f"{name}, {facing}", _world(model, heading, u)


def _motion_problems(
    calls: CallbackCalls, move: Callable[[WorldState], Any], model: RobotModel
) -> Iterator[Problem | str]:
    moved = {}
    for name, u in _INPUTS.items():
        ahead, turns = [], []
        for heading in _HEADINGS:
            rest = np.array(move(_world(model, heading, (0.0, 0.0))), dtype=float)
            pose = np.array(move(_world(model, heading, u)), dtype=float)
            way = pose - rest  # the effect of the voltages
            ahead.append(way[0] * math.cos(heading) + way[1] * math.sin(heading))
            turns.append(wrap_angle(way[2]))
        moved[name] = (np.array(ahead), np.array(turns))
    both, left, right = moved.values()
    if (both[0] < 0).all():
        yield calls.problem(
            "drives backwards", "with 1 V on both motors it drives backwards", "both motors"
        )
    elif (both[0] < 0).any() and (both[0] > 0).any():
        worst = _HEADINGS[int(both[0].argmin())]
        yield calls.problem(
            "drives another way",
            f"with the heading {math.degrees(worst):.0f} degrees and 1 V on both motors it drives "
            "backwards, with others ahead: x changes by cos(heading), y by sin(heading), and y "
            "points down",
            "both motors",
        )
    if (left[1] < 0).all() and (right[1] > 0).all():
        yield calls.problem(
            "left and right exchanged",
            "a faster left wheel turns it to the left: u1 is the left motor, and turns the robot "
            "to the right, to larger headings",
            "left motor only",
        )
    if max(abs(both[0])) > _FAST:
        yield f"with 1 V it moves by {max(abs(both[0])):.0f} px in the first step"
