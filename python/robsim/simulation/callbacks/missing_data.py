"""Reasons for missing data in a step: the second note of a callback's exception."""

from __future__ import annotations

import traceback
from collections.abc import Callable
from dataclasses import dataclass

from robsim._core import Step
from robsim.base import source_line
from robsim.simulation.callbacks.errors import callback_of
from robsim.simulation.slots import SLOTS


@dataclass(frozen=True)
class _Datum:
    """A datum that a step may lack: its slot, and the reasons with the slot off and on."""

    slot: str
    off: str
    absent: str


_NO_MEASUREMENT = "the measurement is off; give measure=True, or --measure in the shell"

_DATA = {
    "measurement": _Datum("measure", _NO_MEASUREMENT, "the robot was not seen in this step"),
    "detection": _Datum(
        "measure", _NO_MEASUREMENT, "only the default measurement, measure=True, makes one"
    ),
    "estimate": _Datum(
        "estimate_state",
        "there is no state estimator; give estimate_state=...",
        "there is no estimate in this step",
    ),
    "parameters": _Datum(
        "estimate_parameters",
        "no parameter estimator is on; give estimate_parameters=True, or "
        "--estimate-parameters in the shell",
        "no parameters have been estimated yet",
    ),
}
# Data without a slot.
_OTHERS = {
    "sample": "there is no sample at the start, after a bounce or lost frames, and if the robot "
    "was not seen",
    "frame": "no frame came in this step",
}


def note_missing_data(error: BaseException, step: Step, is_on: Callable[[str], bool]) -> None:
    """Add a note to an exception of a callback that used a datum that its step lacks."""
    failed = callback_of(error)
    if failed is None or failed.k != step.k or not comes_of_none(error):
        return
    for name in names_in(error):
        reason = _reason(name, step, failed.slot, is_on)
        if reason is not None:
            note = f"step.{name} is None: {reason}"
            if note not in error.__notes__:
                error.add_note(note)


def _reason(name: str, step: Step, slot: str, is_on: Callable[[str], bool]) -> str | None:
    """Return the reason for missing data of a step; None if the step has them."""
    if _has(step, name):
        return None
    if name in _OTHERS:
        return _OTHERS[name]
    datum = _DATA[name]
    if not is_on(datum.slot):
        return datum.off
    order = list(SLOTS)
    if order.index(slot) < order.index(datum.slot):
        return f"{datum.slot} comes after {slot} in a step"
    if slot == datum.slot and name in ("measurement", "estimate"):
        return "this callback itself returns it"
    if name == "measurement" and step.detection is not None:
        return f"{datum.absent}: {step.detection.explanation}"
    return datum.absent


def _has(step: Step, name: str) -> bool:
    try:
        return getattr(step, name) is not None
    except RuntimeError:  # not available, with its own message
        return True


def unmet_needs(slot: str, callback: object, is_on: Callable[[str], bool]) -> str | None:
    """Return a sentence on data that a callback needs and does not get; None = nothing is missing.

    Its attribute ``needs`` is ``"measurement"``, ``"estimate"`` or ``"parameters"``, or a tuple of
    alternatives.
    """
    needs = getattr(callback, "needs", ())
    wanted = [_DATA[name] for name in as_names(needs) if name in _DATA]
    if not wanted or any(map(is_on, needed_slots(callback))):
        return None
    name = getattr(callback, "__name__", f"{type(callback).__name__}(...)")
    return f"{slot}={name} needs step.{' or step.'.join(as_names(needs))}: {wanted[0].off}"


def needed_slots(callback: object) -> tuple[str, ...]:
    """Return the slots that could serve a callback, at least one; empty = it needs no slot."""
    needs = as_names(getattr(callback, "needs", ()))
    return tuple(_DATA[name].slot for name in needs if name in _DATA)


def as_names(needs: object) -> tuple[str, ...]:
    """Return the names in an attribute ``needs``; empty for another type."""
    names = (needs,) if isinstance(needs, str) else needs
    if isinstance(names, (tuple, list)):
        return tuple(name for name in names if isinstance(name, str))
    return ()


def comes_of_none(error: BaseException) -> bool:
    """Return whether an exception may result from a None used like a value."""
    if isinstance(error, AttributeError):
        return error.name is not None and error.obj is None
    # Python's TypeError has no attribute for the operand.
    return isinstance(error, TypeError) and "NoneType" in str(error)


def names_in(error: BaseException) -> list[str]:
    """Return the names of a step's data that the user's code in a traceback reads."""
    codes = [frame.f_code for frame, _ in traceback.walk_tb(error.__traceback__)]
    users = [
        code for code in codes if source_line.SourceLine(code.co_filename, 0, code.co_name).is_users
    ]
    read = {name for code in users for name in code.co_names}
    if isinstance(error, AttributeError):
        read.discard(error.name or "")  # the attribute sought in None is not None itself
    return [name for name in (*_DATA, *_OTHERS) if name in read]
