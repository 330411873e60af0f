"""What a value that a callback gets can do, where it was used wrongly: a note of its exception."""

from __future__ import annotations

import dis
import re
import sys

from robsim._core import Sample, Step
from robsim.base.spelling import closest, with_article
from robsim.simulation.callbacks.errors import CallbackError, callback_of

_READ_ONLY = "what a callback gets is read-only: change a copy of an array, and return the result"
_OF_ROBSIM = re.compile(r"\b(robsim(?:\.\w+)+)(?:'| object|$)")


def note_misuse(error: BaseException, step: Step) -> None:
    """Add a note to an exception of a callback that took a value for something that it is not.

    Parameters
    ----------
    error : BaseException
        The exception.
    step : Step
        The step.
    """
    failed = callback_of(error)
    if failed is None or isinstance(error, CallbackError):
        return
    note = None
    if isinstance(error, AttributeError):
        note = _READ_ONLY if _sets_attribute(error) else _attributes(error.obj, error.name)
    elif isinstance(error, TypeError):
        # Python's TypeError has no attribute for the operand.
        named = _OF_ROBSIM.search(str(error))
        note = None if named is None else _members(_class_of(named[1]))
    elif isinstance(error, ValueError) and "read-only" in str(error):  # of numpy
        note = _READ_ONLY
    elif isinstance(error, (ValueError, IndexError)) and failed.slot == "estimate_parameters":
        note = _shapes(step.sample)
    if note is not None and note not in getattr(error, "__notes__", ()):
        error.add_note(note)


def _sets_attribute(error: BaseException) -> bool:
    """Return whether the line at fault was about to set an attribute: ``step.u = 1, 1``."""
    last = error.__traceback__
    while last is not None and last.tb_next is not None:
        last = last.tb_next
    if last is None:
        return False
    return dis.opname[last.tb_frame.f_code.co_code[last.tb_lasti]] == "STORE_ATTR"


def _attributes(value: object, name: str | None) -> str | None:
    """Return where an attribute is that a value of robsim does not have."""
    kind = type(value)
    if name is None or not kind.__module__.startswith("robsim"):
        return None
    if isinstance(value, Step) and "true" in name.split("_"):
        return f"the truth is not for the robot's software: {_members(kind)}"
    inside = [one for one in _public(kind) if hasattr(_read(value, one), name)]
    if isinstance(value, Step) and inside:
        return f"did you mean step.{f'.{name} or step.'.join(inside)}.{name}?"
    meant = closest(name, _public(kind))
    return f"did you mean {meant!r}? {_members(kind)}" if meant else _members(kind)


def _read(value: object, name: str) -> object:
    try:
        return getattr(value, name)
    except RuntimeError:  # not decided yet
        return None


def _members(kind: type | None) -> str | None:
    if kind is None:
        return None
    return f"{with_article(kind.__name__)} has {', '.join(_public(kind))}"


def _public(kind: type) -> list[str]:
    return [name for name in dir(kind) if not name.startswith("_")]


def _class_of(path: str) -> type | None:
    """Return the class with a public path such as ``robsim.Measurement``."""
    module, _, name = path.rpartition(".")
    found = getattr(sys.modules.get(module), name, None)
    return found if isinstance(found, type) else None


def _shapes(sample: Sample | None) -> str | None:
    if sample is None:
        return None
    return (
        f"the sample of this step has phi of shape {sample.phi.shape}, a row for each of X, Y, "
        f"heading, and y of shape {sample.y.shape}"
    )
