"""The slots: one table of all there is to know about each, and the descriptors that fill them."""

from __future__ import annotations

import inspect
import reprlib
import textwrap
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Generic, ParamSpec, TypedDict, TypeVar, overload

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
from robsim.imaging._images import Pixels

if TYPE_CHECKING:
    from robsim.simulation._slotted import Slotted

#: What each slot takes.
DefineModel = Callable[[], RobotModel]
InitParameterEstimator = Callable[[RobotModel], object]
AdjustBackground = Callable[[Pixels], Pixels]
EvaluateModel = Callable[[WorldState], ArrayLike] | Unicycle
EstimateParameters = Callable[[Step], ArrayLike | None] | bool
Measure = Callable[[Step], Measurement | None] | bool
EstimateState = Callable[[Step], Estimate]
Control = Callable[[Step], Sequence[float]] | Controller

P = ParamSpec("P")
T = TypeVar("T")
F = TypeVar("F", bound=Callable[..., object])

ONCE, STEP = "once", "step"  # when the callback of a slot is called
ROBOT, WORLD = "robot", "world"  # the halves

#: What asks for the default of a slot, whatever a folder has for it.
DEFAULT = "default"

_MISSING: Any = object()


class SlotHandle(Generic[T]):
    """A slot of a simulation: ``sim.control``.

    It is the decorator that fills the slot, ``@sim.control``; `callback` is what the slot holds.
    A handle equals its callback, and is false where the slot is empty or off.

    Attributes
    ----------
    callback : callable, bool or None
        What is in the slot: your callback or a ready component, as it was given; True = the default
        of a stage that may be off; None = the default, or off.
    """

    __hash__ = None  # type: ignore[assignment]

    def __init__(self, runner: Slotted, slot: Slot[T]) -> None:
        self._runner = runner
        self._slot = slot
        self.__doc__ = slot.__doc__

    @property
    def callback(self) -> T | None:
        """What is in the slot."""
        value: T | None = self._runner._callbacks[self._slot.name]
        return value

    def __call__(self, callback: F = _MISSING, /) -> F:
        """Fill the slot with a callback and return it: the decorator.

        Raises
        ------
        TypeError
            If it is no callable, or cannot be called with the argument of the slot.
        """
        name = self._slot.name
        if callback is _MISSING:
            raise TypeError(f"use @sim.{name}, without brackets")
        if not callable(callback):
            raise TypeError(
                f"{name} must be callable, got {reprlib.repr(callback)}: the decorator "
                f"sim.{name} fills the slot, sim.{name}.callback is what is in it"
            )
        self._runner._set_slot(name, callback)
        return callback

    def __eq__(self, other: object) -> bool:
        callback = self.callback
        if isinstance(other, SlotHandle):
            other = other.callback
        return callback is other or bool(callback == other)

    def __bool__(self) -> bool:
        return self.callback is not None and self.callback is not False

    def __repr__(self) -> str:
        return f"<slot {self._slot.name}: {self.callback!r}>"


class Slot(Generic[T]):
    """A slot: a row of the table, and the descriptor ``sim.control``.

    Parameters
    ----------
    half : str
        `ROBOT` or `WORLD`.
    when : str
        `ONCE`, at the start, or `STEP`.
    argument : str
        Name of the callback's argument; empty = it has none.
    result : str
        Type of its result.
    doc : str
        What it does, for the documentation.
    is_optional : bool
        Whether it may stay empty: then the stage is off.
    is_switch : bool
        Whether True is the default stage.
    native : tuple of type
        Values that are taken as they are, and run without the interpreter.
    result_types : tuple of type
        Classes that may be the callback themselves, since they make the result.
    other_names : tuple of str
        What a file for the slot may be called by mistake, first in the program of 2008.
    """

    name: str

    def __init__(
        self,
        half: str,
        when: str,
        argument: str,
        result: str,
        doc: str,
        *,
        is_optional: bool = False,
        is_switch: bool = False,
        native: tuple[type, ...] = (),
        result_types: tuple[type, ...] = (),
        other_names: tuple[str, ...] = (),
    ) -> None:
        self.half = half
        self.when = when
        self.argument = argument
        self.result = result
        self.doc = doc
        self.is_optional = is_optional
        self.is_switch = is_switch
        self.native = native
        self.result_types = result_types
        self.other_names = other_names

    def __set_name__(self, owner: type, name: str) -> None:
        self.name = name
        self.__doc__ = f"{self.call}: {self.doc}"

    @property
    def call(self) -> str:
        """How the callback is called, such as ``control(step) -> (u1, u2)``."""
        return f"``{self.name}({self.argument}) -> {self.result}``"

    @property
    def n_arguments(self) -> int:
        """How many arguments the callback gets."""
        return 1 if self.argument else 0

    @property
    def arguments(self) -> str:
        """The same in words."""
        return f"one argument, {self.argument}" if self.argument else "no argument"

    @overload
    def __get__(self, runner: None, owner: type) -> Slot[T]: ...

    @overload
    def __get__(self, runner: Slotted, owner: type) -> SlotHandle[T]: ...

    def __get__(self, runner: Slotted | None, owner: type) -> Slot[T] | SlotHandle[T]:
        return self if runner is None else SlotHandle(runner, self)

    def __set__(self, runner: Slotted, value: T | str | None) -> None:
        runner._set_slot(self.name, value)


class RobotSlots:
    """The slots of the robot half."""

    define_model = Slot[DefineModel](
        ROBOT, ONCE, "", "RobotModel",
        "called once, at the start: the model that the robot's software believes in.",
        native=(RobotModel,), result_types=(RobotModel,), other_names=("robotModelDef",),
    )  # fmt: skip
    init_parameter_estimator = Slot[InitParameterEstimator](
        ROBOT, ONCE, "model", "estimator",
        "called once, at the start: the object whose ``update(phi, y)`` estimates the parameters.",
        result_types=(object,), other_names=("myParameterEstimatorInit",),
    )  # fmt: skip
    estimate_parameters = Slot[EstimateParameters](
        ROBOT, STEP, "step", "(3, 5) or None",
        "called at each step: the parameters; None = no update. True: that of the estimator.",
        is_optional=True, is_switch=True, result_types=(np.ndarray,),
        other_names=("myParameterEstimator",),
    )  # fmt: skip
    measure = Slot[Measure](
        ROBOT, STEP, "step", "Measurement or None",
        "called at each step with a frame: the pose seen in it; None = not seen. True: the two "
        "markers are located.",
        is_optional=True, is_switch=True, result_types=(Measurement, tuple, list, np.ndarray),
        other_names=("measurePosNOrientation", "measurement"),
    )  # fmt: skip
    estimate_state = Slot[EstimateState](
        ROBOT, STEP, "step", "Estimate", "called at each step: the pose and its covariance.",
        is_optional=True, result_types=(Estimate,), other_names=("stateEstimator",),
    )  # fmt: skip
    control = Slot[Control](
        ROBOT, STEP, "step", "(u1, u2)",
        "called at each step, as the last stage: the voltages of the left and the right motor (V).",
        native=(Spin, DriveAround, Replay), result_types=(tuple, list, np.ndarray),
        other_names=("robotController",),
    )  # fmt: skip


class WorldSlots:
    """The slots of the simulated world half."""

    adjust_background = Slot[AdjustBackground](
        WORLD, ONCE, "background", "background",
        "called once, at the start, with the work area as an image, uint8 (H, W, 3): the changed "
        "image.",
        result_types=(np.ndarray,), other_names=("background",),
    )  # fmt: skip
    evaluate_model = Slot[EvaluateModel](
        WORLD, STEP, "world", "(3,)",
        "called at each step from step 1 on, as the first stage: the new pose of the robot.",
        native=(Unicycle,), result_types=(tuple, list, np.ndarray),
        other_names=("robotModelEval",),
    )  # fmt: skip


class RobotCallbacks(TypedDict, total=False):
    """What `Experiment` takes for its slots."""

    define_model: DefineModel | None
    init_parameter_estimator: InitParameterEstimator | None
    estimate_parameters: EstimateParameters | None
    measure: Measure | None
    estimate_state: EstimateState | None
    control: Control | None


class AllCallbacks(RobotCallbacks, total=False):
    """What `Simulation` takes for its slots."""

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
    """Return the names of the slots of a half, or of those called at a time, in their order."""
    return tuple(
        name
        for name, slot in SLOTS.items()
        if half in (None, slot.half) and when in (None, slot.when)
    )


def switches() -> str:
    """Return the names of the slots that take True, for messages."""
    return " and ".join(name for name, slot in SLOTS.items() if slot.is_switch)


def is_default(value: object) -> bool:
    """Return whether a slot's value asks for the default."""
    return isinstance(value, str) and value == DEFAULT


def checked_slots(slots: str | Iterable[str], known: tuple[str, ...]) -> tuple[str, ...]:
    """Return names of slots as a tuple, after a check that they are known."""
    wanted = (slots,) if isinstance(slots, str) else tuple(slots)
    for name in wanted:
        if name not in known:
            raise ValueError(f"slots must be among {', '.join(known)}, got {name!r}")
    return wanted


def documented(slots: Iterable[str]) -> str:
    """Return the documentation of arguments that fill slots, as part of a class's docstring."""
    entries = []
    for slot in (SLOTS[name] for name in slots):
        kind = "callable or bool" if slot.is_switch else "callable"
        text = textwrap.fill(f"{slot.call}, {slot.doc}", 92, break_on_hyphens=False)
        entries.append(f"{slot.name} : {kind}, optional\n{textwrap.indent(text, '    ')}\n")
    return textwrap.indent("".join(entries), "    ")


def shows_slots(
    callbacks: type, defaults: Mapping[str, object]
) -> Callable[[Callable[P, None]], Callable[P, None]]:
    """Return a decorator that shows the slots in the signature of an ``__init__``.

    Parameters
    ----------
    callbacks : type
        The TypedDict of its ``**callbacks``.
    defaults : mapping
        The defaults of slots; those of the others are None.
    """

    def show(function: Callable[P, None]) -> Callable[P, None]:
        signature = inspect.signature(function)
        types = inspect.get_annotations(callbacks)
        shown = [
            inspect.Parameter(
                name,
                inspect.Parameter.KEYWORD_ONLY,
                default=defaults.get(name),
                annotation=types[name].__forward_arg__,
            )
            for name in SLOTS
            if name in types
        ]
        others = [p for p in signature.parameters.values() if p.kind is not p.VAR_KEYWORD]
        function.__signature__ = signature.replace(  # type: ignore[attr-defined]
            parameters=[*others, *shown]
        )
        return function

    return show
