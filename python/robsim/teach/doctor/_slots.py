"""The two kinds of estimators: how the simulation calls them and what they have to return."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np

from robsim._core import Estimate, Frame, RecursiveLeastSquares, RobotModel, RobotParameters, Step
from robsim.base.checks import Floats
from robsim.simulation import Experiment, Simulation
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


def _replay_state(situation: Situation, callback: Callable[[Step], Any]) -> Experiment:
    """Return an experiment that replays the measurements of a situation, without its truth."""
    frame = Frame(np.zeros((1, 1, 3), np.uint8))
    return Experiment(
        [frame] * len(situation.u),
        robot=_robot(),
        area=_AREA,
        define_model=lambda: RobotModel(RobotParameters(dt=situation.dt)),
        measure=lambda step: situation.measurements[step.k],
        estimate_state=callback,
        control=lambda step: situation.u[step.k],
        time_limit=TIME_LIMIT,
    )


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
        return step.sample and estimator.update(step.sample.phi, step.sample.y)

    return update


def _read_parameters(result: Any, before: Floats | None) -> Floats:
    if result is None:  # no update
        return np.full(15, np.nan) if before is None else before
    expected = (
        "the parameters, an array of shape (3, 5): rows x, y, heading, columns a1, a2, b1, b2, d1"
    )
    return finite_numbers(result, (3, 5), expected, "all parameters must be finite").ravel()


def _simulate_parameters(situation: Situation, callback: Callable[[Step], Any]) -> Simulation:
    return Simulation(
        robot=_robot(),
        area=_AREA,
        boundary="unlimited",
        start=situation.poses[0],
        define_model=lambda: RobotModel(RobotParameters(dt=situation.dt)),
        evaluate_model=lambda world: situation.poses[world.k],
        estimate_parameters=callback,
        control=lambda step: situation.u[step.k],
        time_limit=TIME_LIMIT,
    )


STATE = Slot(entry=_state_entry, read=_read_state, simulate=_replay_state, file="estimate_state")
PARAMETERS = Slot(
    entry=_parameter_entry,
    callback=_parameter_callback,
    read=_read_parameters,
    simulate=_simulate_parameters,
    file="init_parameter_estimator",
    from_file=lambda callback: callback(RobotModel(RobotParameters(dt=DT))),
)
