"""`check_controller`: the checks of a controller in simulated worlds."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from functools import partial
from os import PathLike
from typing import Any

import numpy as np

from robsim._core import Step
from robsim.base.check_report import CheckReport, Problem
from robsim.base.checks import Floats, check_bool
from robsim.base.text import quoted
from robsim.simulation import Simulation
from robsim.simulation.slots import RobotSlots
from robsim.teach.doctor._errors import problem_of
from robsim.teach.doctor._run_checks import (
    BUDGET,
    Done,
    replay_problem,
    run_checks,
    together_problem,
)
from robsim.teach.doctor._situations import Situation
from robsim.teach.doctor._trial import BadResult, EstimatorUnderTest, Trial, finite_numbers
from robsim.teach.doctor.callbacks.scenes import (
    CENTRE,
    LastPose,
    Scene,
    Setting,
    model_parameters,
    simulate,
)
from robsim.teach.doctor.callbacks.single_calls import under_test
from robsim.teach.doctor.callbacks.steering import steering_findings

MAXIMUM_VOLTAGE = 24.0  # V: no small robot has a larger battery voltage
_LONG = 800  # steps
_STARTS = {  # px, px, rad
    "robot starts at the top left, facing left": (150.0, 200.0, 3.1),
    "robot starts at the bottom left, facing left": (200.0, 1000.0, -3.1),
    "robot starts at the bottom right, facing down": (1050.0, 1000.0, 1.6),
    "robot starts at the wall, facing it": (1145.0, 300.0, 0.0),
}
_HIDDEN = range(30, 50)
_CHATTERING = 0.2  # V
_LAST = 200  # steps, in which chattering counts


def check_controller(
    make: Callable[[], Any] | str | PathLike[str],
    *,
    has_estimate: bool = True,
    has_parameters: bool = True,
    budget: float = BUDGET,
) -> CheckReport:
    """Check a controller in several situations and report its problems.

    The controller drives the default robot in a simulated world with a measured pose: from several
    positions and headings, at the wall, and for a long time. At times the robot is hidden, or is
    not seen at first. The check does not know the goal. If the steering always refers to a
    single position, the check reports this position, and whether the controller drives towards it
    or away. Otherwise the report has a remark.

    Parameters
    ----------
    make : callable or path
        ``make() -> control``: returns a new controller, ``control(step) -> (u1, u2)``. Examples are
        a class with ``__call__``, and ``lambda: robsim.GoToPoint(900, 300)``. The path of a file
        ``control.py``, or of its callback folder, is also accepted.
    has_estimate, has_parameters : bool
        Whether the controller gets ``step.estimate`` and ``step.parameters``.
    budget : float
        Maximum of the median time per call (s).

    Returns
    -------
    CheckReport
        True if all checks pass. In a test, call the report's ``raise_for_problems()``, which lists
        every problem.

    Raises
    ------
    TypeError, ValueError
        If `make` is not callable, or a number is out of range.

    Examples
    --------
    >>> print(robsim.teach.check_controller(lambda: robsim.GoToPoint(600, 300)))
    GoToPoint passed all checks
    """
    check_bool("has_estimate", has_estimate)
    check_bool("has_parameters", has_parameters)
    return controller_report(
        make,
        Setting.usual(),
        has_estimate=has_estimate,
        has_parameters=has_parameters,
        budget=budget,
    )


def controller_report(
    make: Callable[[], Any] | str | PathLike[str],
    setting: Setting,
    *,
    has_estimate: bool,
    has_parameters: bool,
    budget: float = BUDGET,
) -> CheckReport:
    """Check a controller in a setting; `check_controller` documents the other arguments."""
    simulated = partial(_simulate, has_estimate=has_estimate, has_parameters=has_parameters)
    slot = under_test(RobotSlots.control, "controller", read_input, simulated)
    return run_checks(make, slot, budget, partial(_checks, setting=setting))


def _simulate(
    scene: Situation, callback: Callable[[Step], Any], *, has_estimate: bool, has_parameters: bool
) -> Simulation:
    return simulate(
        scene,
        callback,
        RobotSlots.control.name,
        estimate_state=LastPose() if has_estimate else None,
        estimate_parameters=model_parameters if has_parameters else None,
    )


def read_input(result: Any, before: Floats | None) -> Floats:
    if result is None:
        raise BadResult(
            "no input",
            "it returns None, not the two voltages: every path through it must end with "
            "return u1, u2",
        )
    if isinstance(result, Iterable) and any(isinstance(u, (str, bytes)) for u in result):
        raise BadResult("output shape", f"it returns {quoted(result)}, texts, not numbers")
    expected = "(u1, u2), the voltages of the left and the right motor"
    hint = "look for a division by 0, or a square root or arccos out of its range"
    return finite_numbers(result, (2,), expected, hint, " V")


def _checks(controller: EstimatorUnderTest, setting: Setting) -> Iterator[Problem | str | Done]:
    usual = controller.try_in(
        setting.driven("robot starts in the middle, facing right", CENTRE, _LONG)
    )
    if not len(usual.outputs):
        yield problem_of(usual)
        return
    trials = [usual, *(controller.try_in(scene) for scene in _short_scenes(setting))]
    yield from _distinct(_fault(trial) for trial in trials)
    yield Done("drives from several places")
    # A repeatable result is a condition of the next checks.
    other = setting.driven("robot starts elsewhere", next(iter(_STARTS.values())), 60)
    cause = replay_problem(usual)
    if usual.error is not None:
        return
    if cause is not None:
        yield cause
        return
    yield from filter(None, (together_problem(usual, other),))
    yield Done("the same steps again, two at the same time")
    yield from _remarks(usual)
    if all(_is_same(usual, trial) for trial in trials[1:]):
        yield "it is open loop: its voltages do not depend on the robot's pose or visibility"
    else:
        yield from steering_findings(usual, setting)
    yield Done("steering")


def _short_scenes(setting: Setting) -> list[Scene]:
    return [
        setting.driven("robot not seen at first", CENTRE, 40, hidden=range(10)),
        setting.driven("robot out of sight for a while", CENTRE, 80, hidden=_HIDDEN),
        *(setting.driven(name, start, 60) for name, start in _STARTS.items()),
    ]


def _distinct(problems: Iterator[Problem | None]) -> Iterator[Problem]:
    known = set()
    for problem in problems:
        if problem is None:
            continue
        kind = "missing measurement" if problem.kind == "not seen yet" else problem.kind
        if (kind, problem.line) not in known:
            known.add((kind, problem.line))
            yield problem


def _fault(trial: Trial) -> Problem | None:
    size = abs(trial.outputs).max(axis=1) if len(trial.outputs) else np.zeros(1)
    if size.max() > MAXIMUM_VOLTAGE:
        k = int((size > MAXIMUM_VOLTAGE).argmax())
        u1, u2 = trial.outputs[k]
        sentence = f"it returns ({u1:g}, {u2:g}), which are volts: {_what_is_large(trial.outputs)}"
        return trial.problem("input too large", sentence, k)
    return None if trial.error is None else problem_of(trial)


def _what_is_large(u: Floats) -> str:
    used = abs(u[np.isfinite(u)])
    largest = used.max()
    is_whole = bool((used == used.round()).all())
    if is_whole and largest <= 255:
        return "robsim takes no 8-bit or percent values; 0.5 to 1.5 V drive the robot"
    if np.median(used) > 100:
        return "if these are millivolts, divide by 1000; 0.5 to 1.5 V drive the robot"
    return "limit them, such as numpy.clip(u, -1, 1)"


def _is_same(one: Trial, other: Trial) -> bool:
    steps = min(len(one.outputs), len(other.outputs))
    return bool(steps) and np.array_equal(one.outputs[:steps], other.outputs[:steps])


def _remarks(usual: Trial) -> Iterator[str]:
    if not usual.outputs.any():
        yield "it never drives: its voltages are (0, 0)"
    turn = np.diff(usual.outputs[-_LAST:, 0] - usual.outputs[-_LAST:, 1])
    # Each step reverses the turn of the previous step.
    alternates = (turn[1:] * turn[:-1] < 0) & (
        np.minimum(abs(turn[1:]), abs(turn[:-1])) > _CHATTERING
    )
    if alternates.mean() > 0.5:
        yield (
            f"it chatters: in {alternates.mean():.0%} of the last {_LAST} steps u1 - u2 jumps by "
            f"more than {_CHATTERING} V and back at the next"
        )
