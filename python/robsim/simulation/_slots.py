"""The slots: names, halves, arguments and order, for the runners and the callback folders."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeVar

if TYPE_CHECKING:
    from robsim.simulation._runner import Runner

F = TypeVar("F", bound=Callable[..., Any])

#: Each slot and the argument of its callback: those called once, at the start ...
ONCE = {
    "define_model": "",
    "init_parameter_estimator": "model",
    "adjust_background": "background",
}
#: ... and those called at each step, in this order.
STEP = {
    "evaluate_model": "world",
    "estimate_parameters": "step",
    "measure": "step",
    "estimate_state": "step",
    "control": "step",
}
ARGUMENTS = ONCE | STEP

#: The slots of the world half; the others are those of the robot half.
WORLD = ("adjust_background", "evaluate_model")
ROBOT = tuple(slot for slot in ARGUMENTS if slot not in WORLD)

#: Slots that may stay empty.
OPTIONAL = ("estimate_parameters", "measure", "estimate_state")

#: Slots that accept True for the default stage.
SWITCHES = ("estimate_parameters", "measure")

#: What asks for the default of a slot, whatever a folder has for it.
DEFAULT = "default"


def is_default(value: Any) -> bool:
    """Return whether a slot's value asks for the default."""
    return isinstance(value, str) and value == DEFAULT


class Slot:
    """Descriptor of a slot: ``@sim.control`` or ``sim.control = ...`` fills it."""

    def __init__(self, doc: str) -> None:
        self.__doc__ = doc

    def __set_name__(self, owner: type, name: str) -> None:
        self.name = name

    def __get__(self, runner: Runner | None, owner: type) -> Any:
        if runner is None:
            return self

        def register(callback: F) -> F:
            runner._set_slot(self.name, callback)
            return callback

        register.__name__ = self.name
        register.__doc__ = self.__doc__
        return register

    def __set__(self, runner: Runner, callback: Any) -> None:
        runner._set_slot(self.name, callback)


def checked_slots(slots: Any, known: tuple[str, ...]) -> tuple[str, ...]:
    """Return names of slots as a tuple, after a check that they are known."""
    names = (slots,) if isinstance(slots, str) else tuple(slots)
    for name in names:
        if name not in known:
            raise ValueError(f"slots must be among {', '.join(known)}, got {name!r}")
    return names
