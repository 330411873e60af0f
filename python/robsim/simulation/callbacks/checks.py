"""Checks of the value of a slot when it is set."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

import numpy as np

from robsim._core import RobotParameters
from robsim.base.text import quoted
from robsim.simulation.callbacks.signatures import (
    accepts,
    forgets_self,
    name_of,
    place_of,
    signature_of,
    where_defined,
    why_not_a_function,
)
from robsim.simulation.callbacks.slot import Slot
from robsim.simulation.slots import SLOTS, use_of


def check_callback(name: str, value: object) -> None:
    """Raise TypeError if a value cannot fill a slot; None and opaque callables pass."""
    slot = SLOTS[name]
    if value is None or type(value) in slot.native:
        return
    if isinstance(value, bool):
        if not (slot.is_switch or (slot.is_optional and not value)):
            raise TypeError(f"{name} must be callable, got {value}: {use_of(value)}")
    elif isinstance(value, type):
        _check_class(slot, value)
    elif not callable(value):
        raise TypeError(
            f"{name} must be callable, got {_described(slot, value)}{_remedy(slot, value)}"
        )
    else:
        _check_function(slot, value)


def _is_plain(value: object) -> bool:
    return type(value).__module__ == "builtins" or isinstance(value, np.ndarray)


def _described(slot: Slot[Any], value: object) -> str:
    """Return a description of an uncallable value."""
    if _is_plain(value):
        return quoted(value)
    arguments = ", ".join(filter(None, ("self", slot.argument)))
    return f"an object of {type(value).__name__}, which has no method __call__({arguments})"


def _remedy(slot: Slot[Any], value: object) -> str:
    """Return the remedy for an uncallable value, as the end of a message."""
    if callable(getattr(value, "update", None)):
        return ": init_parameter_estimator(model) returns an estimator"
    if isinstance(value, RobotParameters):
        return ": use the option model"
    if callable(getattr(value, slot.name, None)):
        return f": use its method {slot.name}"
    if isinstance(value, str):
        return ": pass the function itself, not its name; from_folder reads files"
    return (
        f": pass the function {slot.signature} itself, not its result" if _is_plain(value) else ""
    )


def _check_function(slot: Slot[Any], function: Callable[..., object]) -> None:
    """Raise TypeError unless a callable takes the arguments of a slot, and returns a result."""
    name = slot.name
    if isinstance(function, functools.partial) and signature_of(function) is None:
        inner = function.func
        if signature_of(inner) is not None:
            raise TypeError(
                f"{name} must take {slot.arguments}, got a functools.partial with arguments that "
                f"{name_of(inner)} does not take: {name_of(inner)}{where_defined(inner)}"
            )
    if not accepts(function, slot.n_arguments):
        hint = ": a method needs self first" if forgets_self(function, slot.n_arguments) else ""
        raise TypeError(
            f"{name} must take {slot.arguments}, got {name_of(function)}"
            f"{where_defined(function)}{hint}"
        )
    if (problem := why_not_a_function(function)) is not None:
        raise TypeError(
            f"{name} must return its result, {slot.result}, but {name_of(function)} is "
            f"{problem}{place_of(function)}"
        )


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
        f"{slot.name} must be callable, but {kind.__name__} is a class: pass an instance, "
        f"such as {kind.__name__}({'' if is_plain else '...'}){place_of(kind)}"
    )
