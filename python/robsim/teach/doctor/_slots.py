"""The two kinds of estimators: their calls in a simulation and their results."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager
from functools import cache
from typing import Any

import numpy as np

from robsim._core import Estimate, RecursiveLeastSquares, RobotModel, RobotParameters, Step
from robsim.base.checks import Floats
from robsim.simulation import Simulation
from robsim.simulation.time_limit import TimeLimit
from robsim.teach.doctor._situations import DT, Situation
from robsim.teach.doctor._trial import TIME_LIMIT, BadResult, Slot, described, finite_numbers
from robsim.vision.robots.definition import RobotDefinition
from robsim.vision.robots.lookup import load_robot

_AREA = (64, 64)
_POSE_AND_COVARIANCE = 12  # entries of an output before the state


@cache
def _robot() -> RobotDefinition:
    # Loading takes as long as a short trial.
    return load_robot("lab")


def _state_entry(estimator: Any) -> Callable[..., Any]:
    if not callable(estimator):
        raise BadResult(
            "not callable",
            f"make() returns {described(estimator)}, which cannot be called as "
            "estimate(step): give its class a method __call__(self, step)",
        )
    return estimator  # type: ignore[no-any-return]


def _read_state(result: Any, before: Floats | None) -> Floats:
    if not isinstance(result, Estimate):
        raise BadResult(
            "no Estimate",
            f"it returns {described(result)}, not an Estimate: end with "
            "return robsim.Estimate(pose, covariance)",
        )
    output = np.concatenate((result.pose, result.covariance.ravel(), result.state))
    if before is not None and len(output) != len(before):
        new, old = (len(values) - _POSE_AND_COVARIANCE for values in (output, before))
        raise BadResult(
            "state length",
            f"the state in its Estimate has {new} numbers after {old} at the previous step: it "
            "must have the same length at every step",
        )
    return output


class _Replay:
    """The same steps for each estimator, as a run of `Simulation` gives them."""

    trace: Any = None

    def __init__(self, steps: tuple[Step, ...], callback: Callable[[Step], Any]) -> None:
        self._steps = iter(steps)
        self._limit = TimeLimit(TIME_LIMIT)
        self._call = self._limit.limited(callback)

    def run(self, steps: int) -> None:
        with self._watched():
            for _ in range(steps):
                self.step()

    def step(self) -> None:
        self._call(next(self._steps))

    def _watched(self) -> AbstractContextManager[None]:
        return self._limit.watching()


def _replay(situation: Situation, callback: Callable[[Step], Any]) -> _Replay:
    return _Replay(situation.steps, callback)


def _parameter_entry(estimator: Any) -> Callable[..., Any]:
    entry: Callable[..., Any] = getattr(estimator, "update", estimator)
    if not callable(entry):
        raise BadResult(
            "not callable",
            f"make() returns {described(estimator)}, which has no method update(phi, y)",
        )
    _check_filters(estimator)
    return entry


def _check_filters(estimator: Any) -> None:
    if not isinstance(estimator, RecursiveLeastSquares):
        return
    try:
        Simulation(
            robot=_robot(),
            area=_AREA,
            boundary="unlimited",
            init_parameter_estimator=lambda model: estimator,
        ).run(1)
    except ValueError as error:
        reason = str(error).partition("\n")[0]
        raise BadResult("refused", f"the simulation refuses it: {reason}") from error


def _parameter_callback(estimator: Any) -> Callable[[Step], Any]:
    if not hasattr(estimator, "update"):
        return estimator  # type: ignore[no-any-return]

    def update(step: Step) -> Any:
        # As in the simulation: no sample, no update.
        sample = step.sample
        return sample and estimator.update(sample.phi, sample.y)

    return update


def _read_parameters(result: Any, before: Floats | None) -> Floats:
    if result is None:  # no update
        return np.full(15, np.nan) if before is None else before
    expected = (
        "the parameters, an array of shape (3, 5): rows x, y, heading, columns a1, a2, b1, b2, d1"
    )
    return finite_numbers(result, (3, 5), expected, "all parameters must be finite").ravel()


STATE = Slot(entry=_state_entry, read=_read_state, simulate=_replay, file="estimate_state")
PARAMETERS = Slot(
    entry=_parameter_entry,
    callback=_parameter_callback,
    read=_read_parameters,
    simulate=_replay,
    file="init_parameter_estimator",
    from_file=lambda callback: callback(RobotModel(RobotParameters(dt=DT))),
)
