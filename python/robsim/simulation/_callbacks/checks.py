"""What is wrong with the value of a slot, told when it is set."""

from __future__ import annotations

import reprlib
from typing import Any

from robsim.simulation._callbacks.signatures import (
    accepts,
    place_of,
    signature_of,
    where_defined,
)
from robsim.simulation._callbacks.slot import Slot
from robsim.simulation._slots import SLOTS, switches


def check_callback(name: str, value: object) -> None:
    """Raise TypeError if a slot cannot be filled with a value.

    What cannot be inspected, such as compiled code, is accepted.

    Parameters
    ----------
    name : str
        The slot.
    value : object
        A callable, a native component, a bool; None passes.
    """
    slot = SLOTS[name]
    if value is None or type(value) in slot.native:
        return
    if isinstance(value, bool):
        if not (slot.is_switch or (slot.is_optional and not value)):
            raise TypeError(f"{name} must be callable, got {value}: True is for {switches()} only")
    elif isinstance(value, type):
        _check_class(slot, value)
    elif not callable(value):
        raise TypeError(f"{name} must be callable, got {reprlib.repr(value)}")
    elif not accepts(value, slot.n_arguments):
        raise TypeError(f"{name} must take {slot.arguments}, got {name}{where_defined(value)}")


def _check_class(slot: Slot[Any], kind: type) -> None:
    """Raise TypeError for a class, unless calling it makes the result of the slot."""
    makes_result = issubclass(kind, slot.result_types)
    if makes_result and accepts(kind, slot.n_arguments):
        return
    if makes_result:
        raise TypeError(
            f"{slot.name} must take {slot.arguments}, got {kind.__name__}{where_defined(kind)}"
        )
    signature = signature_of(kind)
    is_plain = signature is not None and accepts(kind, 0)
    raise TypeError(
        f"{slot.name} must be callable, but {kind.__name__} is a class: give an object of it, "
        f"such as {kind.__name__}({'' if is_plain else '...'}){place_of(kind)}"
    )
