"""The origin of a callback's exception, and errors of results that its slot cannot use.

The C++ core calls `failed`, `refused` and `check_estimator`.
"""

from __future__ import annotations

import contextlib
import dis
import re
import sys
from dataclasses import dataclass
from typing import TypeVar

from robsim._core import Sample, Step
from robsim.base import source_line
from robsim.base.spelling import closest, with_article
from robsim.simulation.callbacks.signatures import accepts, where_defined

_MOST_NOTES = 8


@dataclass(frozen=True)
class FailedCallback:
    """The origin of a callback's exception, stored in the exception's attribute ``callback``.

    Attributes
    ----------
    slot : str
        The slot; ``"frames"`` or ``"send"`` for these arguments of an `Experiment`.
    k : int or None
        The step; None = at the start, or on loading its file.
    source : SourceLine or None
        The line of your code that raised it, or the callback's definition; None = unknown.

    Examples
    --------
    >>> def control(step):
    ...     return 1 / 0
    >>> try:
    ...     robsim.Simulation(control=control, seed=1).run(2)
    ... except ZeroDivisionError as error:
    ...     print(error.callback.slot, error.callback.k)
    control 0
    """

    slot: str
    k: int | None
    source: source_line.SourceLine | None

    @property
    def when(self) -> str:
        """``"at step 5"`` or ``"at the start"``."""
        return "at the start" if self.k is None else f"at step {self.k}"


class CallbackError(Exception):
    """A callback returned a result that its slot cannot use.

    It is also a TypeError or a ValueError.

    Parameters
    ----------
    message : str
        The expected and the actual result.

    Attributes
    ----------
    callback : FailedCallback
        Slot, step and line.
    """

    callback: FailedCallback

    def __init__(self, message: str) -> None:
        super().__init__(message)


E = TypeVar("E", bound=CallbackError)


class CallbackTypeError(CallbackError, TypeError):
    """A `CallbackError`: the result has the wrong type."""


class CallbackValueError(CallbackError, ValueError):
    """A `CallbackError`: the result has the wrong shape or value."""


def callback_of(error: BaseException) -> FailedCallback | None:
    """Return the origin of an exception; None if no callback raised it."""
    found = getattr(error, "callback", None)
    return found if isinstance(found, FailedCallback) else None


def failed(error: BaseException, slot: str, what: str, k: int, function: object) -> None:
    """Note on an exception that the callback `what` raised it at step k; -1 = at the start."""
    inner = callback_of(error)  # of a simulation inside the callback, which comes first
    source = (
        None
        if inner
        else source_line.line_of_error(error) or source_line.users_line_of_callable(function)
    )
    record = FailedCallback(slot, None if k < 0 else k, source)
    # A class of the user's own may refuse either: the exception itself is what counts.
    if inner is None:
        with contextlib.suppress(Exception):
            error.callback = record  # type: ignore[attr-defined]
    # Simulations may be nested without limit; some notes are enough.
    with contextlib.suppress(Exception):
        if inner is None or len(error.__notes__) < _MOST_NOTES:
            error.add_note(f"in {what} {record.when}")


def note_failed_file(error: BaseException, slot: str, file: str) -> None:
    """Record on an exception that a callback's file could not be loaded."""
    source = source_line.line_of_error(error)
    if isinstance(error, SyntaxError) and error.filename:
        source = source_line.SourceLine(error.filename, error.lineno or 1, "<module>")
    with contextlib.suppress(Exception):
        source = source or source_line.SourceLine(file, 1, "<module>")
        error.callback = FailedCallback(slot, None, source)  # type: ignore[attr-defined]


def refused(
    error: BaseException, slot: str, what: str, k: int, function: object
) -> CallbackTypeError | CallbackValueError:
    """Return the exception for a result that its slot cannot use, with the message of `error`."""
    source = source_line.line_of_callable(function)
    record = FailedCallback(
        slot, None if k < 0 else k, source_line.users_line_of_callable(function)
    )
    place = f"of {_type_name(function)}" if source is None else traceback_line(source)
    kind = CallbackTypeError if isinstance(error, TypeError) else CallbackValueError
    return _recorded(kind(f"in {what} {record.when}: {error}\n  {place}"), record)


def check_estimator(estimator: object) -> None:
    """Raise CallbackTypeError unless an object can be updated with samples."""
    update = getattr(estimator, "update", None)
    if callable(update) and accepts(update, 2):
        return
    source = source_line.users_line_of_callable(update if callable(update) else type(estimator))
    came = f"method update{where_defined(update)}" if callable(update) else "none"
    what = f"the estimator that it returned, of class {_type_name(estimator)}, must have a method"
    message = f"{what} update(phi, y), got {came}"
    if isinstance(estimator, type):
        name = estimator.__name__
        message = f"it returned the class {name}, not an object of it: return {name}(...)"
    message = f"in the callback init_parameter_estimator at the start: {message}"
    raise _recorded(
        CallbackTypeError(message), FailedCallback("init_parameter_estimator", None, source)
    )


def _recorded(error: E, record: FailedCallback) -> E:
    error.callback = record
    return error


def _type_name(value: object) -> str:
    return type(value).__qualname__.rpartition("<locals>.")[2]


def traceback_line(source: source_line.SourceLine) -> str:
    """Return a line in the format of a traceback, which editors and consoles know."""
    return f'File "{source.file}", line {source.number}, in {source.function}'


_READ_ONLY = "the arguments of a callback are read-only: change a copy, and return the result"
_OF_ROBSIM = re.compile(r"\b(robsim(?:\.\w+)+)(?:'| object|$)")


def note_misuse(error: BaseException, step: Step) -> None:
    """Add a note to a callback's exception that comes from the wrong use of a step's value."""
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
    """Return the place of an attribute that a value of robsim does not have."""
    kind = type(value)
    if name is None or not kind.__module__.startswith("robsim"):
        return None
    if isinstance(value, Step) and "true" in name.split("_"):
        return f"the robot's software has no access to the truth: {_members(kind)}"
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
