"""How a callback is checked, and what is told of one that its slot would refuse."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from robsim.base.text import quoted
from robsim.simulation.callbacks.checks import check_callback
from robsim.simulation.callbacks.slot import Slot
from robsim.teach.doctor._trial import BadResult
from robsim.teach.doctor._trial import Slot as UnderTest


def under_test(
    slot: Slot[Any], noun: str, read: Callable[..., Any], simulate: Callable[..., Any]
) -> UnderTest:
    """Return how the callback of a slot is checked; the arguments are as of `UnderTest`."""
    return UnderTest(
        entry=partial(_entry, slot),
        read=read,
        simulate=simulate,
        file=slot.name,
        noun=noun,
        may_print=True,
    )


def _entry(slot: Slot[Any], callback: Any) -> Callable[..., Any]:
    """Return a callback; raises BadResult if its slot would refuse it.

    Parameters
    ----------
    slot : Slot
        The slot.
    callback : object
        What is to fill it.
    """
    try:
        if not callable(callback):  # None would mean the default
            raise TypeError(f"{slot.name} must be callable, got {quoted(callback)}")
        check_callback(slot.name, callback)
    except TypeError as error:
        raise BadResult("wrong callback", str(error)) from None
    entry: Callable[..., Any] = callback
    return entry
