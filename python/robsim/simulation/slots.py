"""The slots: one table with all facts about each."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any, TypedDict

import numpy as np
from numpy.typing import ArrayLike

from robsim._core import (
    Controller,
    DriveAround,
    Estimate,
    Measurement,
    Replay,
    RobotModel,
    Spin,
    Step,
    Unicycle,
    WorldState,
)
from robsim.base.checks import check_choice
from robsim.base.text import quoted
from robsim.simulation.callbacks.slot import Slot
from robsim.vision.imaging.images import Pixels

#: What each slot takes.
DefineModel = Callable[[], RobotModel]
InitParameterEstimator = Callable[[RobotModel], object]
AdjustBackground = Callable[[Pixels], Pixels]
EvaluateModel = Callable[[WorldState], ArrayLike] | Unicycle
EstimateParameters = Callable[[Step], ArrayLike | None] | bool
Measure = Callable[[Step], Measurement | None] | bool
EstimateState = Callable[[Step], Estimate]
Control = Callable[[Step], Sequence[float]] | Controller

ONCE, STEP = "once", "step"  # when the callback of a slot is called
ROBOT, WORLD = "robot", "world"  # the halves

#: Selects the default of a slot, also over a folder's file.
DEFAULT = "default"


class RobotSlots:
    """The slots of the robot half."""

    define_model = Slot[DefineModel](
        ROBOT, ONCE, "", "RobotModel",
        "called once, at the start: the model that the robot's software believes in.",
        native=(RobotModel,), result_types=(RobotModel,), other_names=("robotModelDef",),
        title="the model", default="RobotModel",
    )  # fmt: skip
    init_parameter_estimator = Slot[InitParameterEstimator](
        ROBOT, ONCE, "model", "estimator",
        "called once, at the start: the object whose ``update(phi, y)`` estimates the parameters.",
        result_types=(object,), other_names=("myParameterEstimatorInit",),
        title="the parameter estimator", default="RecursiveLeastSquares",
    )  # fmt: skip
    estimate_parameters = Slot[EstimateParameters](
        ROBOT, STEP, "step", "(3, 5) or None",
        "called at each step: the parameters, None = no update. True: the estimator updates them.",
        is_optional=True, is_switch=True, result_types=(np.ndarray,),
        other_names=("myParameterEstimator",),
        title="parameter estimation", default="step.estimator.update",
    )  # fmt: skip
    measure = Slot[Measure](
        ROBOT, STEP, "step", "Measurement or None",
        "called at each step with a frame: the pose seen in it, None = not seen. True: the two "
        "markers are located.",
        is_optional=True, is_switch=True, result_types=(Measurement, tuple, list, np.ndarray),
        other_names=("measurePosNOrientation", "measurement"),
        title="tracking", default="locate",
    )  # fmt: skip
    estimate_state = Slot[EstimateState](
        ROBOT, STEP, "step", "Estimate", "called at each step: the pose and its covariance.",
        is_optional=True, result_types=(Estimate,), other_names=("stateEstimator",),
        title="state estimation",
    )  # fmt: skip
    control = Slot[Control](
        ROBOT, STEP, "step", "(u1, u2)",
        "called at each step, as the last stage: the voltages of the left and the right motor (V).",
        native=(Spin, DriveAround, Replay), result_types=(tuple, list, np.ndarray),
        other_names=("robotController",),
        title="the controller",
    )  # fmt: skip


class WorldSlots:
    """The slots of the simulated world half."""

    adjust_background = Slot[AdjustBackground](
        WORLD, ONCE, "background", "background",
        "called once, at the start, with the work area as an image, uint8 (H, W, 3): the changed "
        "image.",
        result_types=(np.ndarray,), other_names=("background",),
        title="the background", default="draw_red_square",
    )  # fmt: skip
    evaluate_model = Slot[EvaluateModel](
        WORLD, STEP, "world", "(3,)",
        "called at each step from step 1 on, as the first stage: the new pose of the robot.",
        native=(Unicycle,), result_types=(tuple, list, np.ndarray),
        other_names=("robotModelEval",),
        title="the motion", default="RobotModel.predict",
    )  # fmt: skip


class AllCallbacks(TypedDict, total=False):
    """The callbacks of `Simulation`; `Experiment` has the ones of the robot half."""

    define_model: DefineModel | None
    init_parameter_estimator: InitParameterEstimator | None
    estimate_parameters: EstimateParameters | None
    measure: Measure | None
    estimate_state: EstimateState | None
    control: Control | None
    adjust_background: AdjustBackground | None
    evaluate_model: EvaluateModel | None


def _in_order(*tables: type) -> dict[str, Slot[Any]]:
    rows = [row for table in tables for row in vars(table).values() if isinstance(row, Slot)]
    # At the start the world comes last, since it takes its model from the robot half; at each step
    # it comes first.
    rows.sort(key=lambda row: (row.when == STEP, (row.half == WORLD) == (row.when == ONCE)))
    return {row.name: row for row in rows}


#: All slots by name, in the order in which they are called.
SLOTS = _in_order(RobotSlots, WorldSlots)


def names(*, half: str | None = None, when: str | None = None) -> tuple[str, ...]:
    """Return the names of the slots of a half, or of a calling time, in their order."""
    return tuple(
        name
        for name, slot in SLOTS.items()
        if half in (None, slot.half) and when in (None, slot.when)
    )


#: The stages of the robot half, and the slots that are called once, at the start.
STAGES, AT_START = names(half=ROBOT, when=STEP), names(when=ONCE)
#: The slots that get samples.
ESTIMATORS = frozenset({"init_parameter_estimator", "estimate_parameters"})


def are_samples_given(identify_from: str, slots: Iterable[str]) -> bool:
    """Return whether the callbacks of some slots may get samples: true samples reveal the pose."""
    return identify_from != "truth" or not ESTIMATORS.isdisjoint(slots)


def use_of(value: bool) -> str:
    """Return the slots that take True, or False, and its effect on them."""
    names = [n for n, slot in SLOTS.items() if (slot.is_switch if value else slot.is_optional)]
    does = "is the default stage of" if value else "switches off"
    return f"{value} {does} {', '.join(names[:-1])} and {names[-1]} only"


def is_default(slot: str, value: object) -> bool:
    """Return whether a value means the default of a slot; raise ValueError without a default."""
    asks = isinstance(value, str) and value == DEFAULT
    if asks and SLOTS[slot].is_optional and not SLOTS[slot].is_switch:
        raise ValueError(
            f"{slot} has no default, got {quoted(value)}: give a callback, such as "
            "robsim.estimation.reference.ExtendedKalmanFilter(model), or False to switch off"
        )
    return asks


def checked_slots(slots: Any, known: tuple[str, ...] = (*SLOTS,)) -> tuple[str, ...]:
    """Return names of slots as a tuple, after a check that they are known."""
    if not isinstance(slots, Iterable):
        raise TypeError(f"slots must be names of slots, such as ('control',), got {quoted(slots)}")
    names = (slots,) if isinstance(slots, str) else tuple(slots)
    for name in names:
        check_choice("slots", name, known)
    if not names:
        raise ValueError(f"slots must name at least one of {', '.join(known)}, got none")
    return names
