"""What is told of a callback that its slot would refuse."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from robsim._base.text import quoted
from robsim.doctor._trial import BadResult
from robsim.simulation._callbacks.checks import check_callback
from robsim.simulation._callbacks.slot import Slot


def entry_of(slot: Slot[Any], callback: Any) -> Callable[..., Any]:
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
