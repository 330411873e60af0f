"""Where an exception of a callback came from, and what its slot cannot use of its result.

The C++ core calls `failed`, `refused` and `check_estimator`.
"""

from __future__ import annotations

import contextlib
from dataclasses import dataclass
from typing import TypeVar

from robsim.base.source_line import (
    SourceLine,
    line_of_callable,
    line_of_error,
    users_line_of_callable,
)
from robsim.simulation.callbacks.signatures import accepts, where_defined

_MOST_NOTES = 8


@dataclass(frozen=True)
class FailedCallback:
    """Where an exception came from: the attribute ``callback`` of every exception of a callback.

    Attributes
    ----------
    slot : str
        The slot; ``"frames"`` or ``"send"`` for those arguments of an `Experiment`.
    k : int or None
        The step; None = at the start, or when its file was loaded.
    source : SourceLine or None
        The line of your code that raised it, or where the callback is defined; None = unknown.
    """

    slot: str
    k: int | None
    source: SourceLine | None

    @property
    def when(self) -> str:
        """``"at step 5"`` or ``"at the start"``."""
        return "at the start" if self.k is None else f"at step {self.k}"


class CallbackError(Exception):
    """A callback returned what its slot cannot use.

    It is a TypeError or a ValueError, too.

    Parameters
    ----------
    message : str
        What was expected and what came.

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
    """Return where an exception came from; None if no callback raised it."""
    found = getattr(error, "callback", None)
    return found if isinstance(found, FailedCallback) else None


def failed(error: BaseException, slot: str, what: str, k: int, function: object) -> None:
    """Note on an exception which callback raised it; the same exception reaches the user.

    Parameters
    ----------
    error : BaseException
        The exception.
    slot : str
        The slot.
    what : str
        What a message calls the callback.
    k : int
        The step; -1 = at the start.
    function : callable
        The callback.
    """
    inner = callback_of(error)  # of a simulation inside the callback, which comes first
    source = None if inner else line_of_error(error) or users_line_of_callable(function)
    record = FailedCallback(slot, None if k < 0 else k, source)
    # A class of the user's own may refuse either: the exception itself is what counts.
    if inner is None:
        with contextlib.suppress(Exception):
            error.callback = record  # type: ignore[attr-defined]
    # Of simulations without end, each in a callback of the one before, some say enough.
    with contextlib.suppress(Exception):
        if inner is None or len(error.__notes__) < _MOST_NOTES:
            error.add_note(f"in {what} {record.when}")


def note_failed_file(error: BaseException, slot: str, file: str) -> None:
    """Record on an exception that the file of a callback could not be loaded."""
    source = line_of_error(error)
    if isinstance(error, SyntaxError) and error.filename:
        source = SourceLine(error.filename, error.lineno or 1, "<module>")
    with contextlib.suppress(Exception):
        error.callback = FailedCallback(slot, None, source or SourceLine(file, 1, "<module>"))  # type: ignore[attr-defined]


def refused(
    error: BaseException, slot: str, what: str, k: int, function: object
) -> CallbackTypeError | CallbackValueError:
    """Return the exception to raise for a result that its slot cannot use; arguments as `failed`.

    Its message is that of `error`, which says what was expected and what came.
    """
    source = line_of_callable(function)
    record = FailedCallback(slot, None if k < 0 else k, users_line_of_callable(function))
    place = f"of {_type_name(function)}" if source is None else traceback_line(source)
    kind = CallbackTypeError if isinstance(error, TypeError) else CallbackValueError
    return _recorded(kind(f"in {what} {record.when}: {error}\n  {place}"), record)


def check_estimator(estimator: object) -> None:
    """Raise CallbackTypeError unless an object can be updated with samples."""
    update = getattr(estimator, "update", None)
    if callable(update) and accepts(update, 2):
        return
    source = users_line_of_callable(update if callable(update) else type(estimator))
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


def traceback_line(source: SourceLine) -> str:
    """Return a line in the format of a traceback, which editors and consoles know."""
    return f'File "{source.file}", line {source.number}, in {source.function}'
