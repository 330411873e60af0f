"""The number of arguments that a callable takes, as far as it is known."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable
from time import perf_counter
from typing import Any

from robsim.base.source_line import inner_of, users_line_of_callable


def accepts(function: Callable[..., object], count: int) -> bool:
    """Return whether a callable takes `count` positional arguments; True if that is unknown."""
    signature = signature_of(function)
    if signature is None:
        return True
    try:
        signature.bind(*[None] * count)
    except TypeError:
        return False
    return True


def signature_of(function: Callable[..., object]) -> inspect.Signature | None:
    try:
        return inspect.signature(function)
    except (TypeError, ValueError):  # of compiled objects
        return None


def name_of(function: Callable[..., object]) -> str:
    """Return the name of a callable: ``control``, ``lambda``, ``MyController.__call__``."""
    function = inner_of(function)
    name = getattr(function, "__name__", None) or f"{type(function).__name__}.__call__"
    return "lambda" if name == "<lambda>" else str(name)


def forgets_self(function: Callable[..., object], count: int) -> bool:
    """Return whether a method without its object would take this number of arguments."""
    plain = getattr(function, "__func__", None)
    if plain is None and not hasattr(function, "__code__"):
        plain = inspect.getattr_static(type(function), "__call__", None)
    return inspect.isfunction(plain) and accepts(plain, count)


def why_not_a_function(function: Callable[..., object]) -> str | None:
    """Return why a call of a callable does not run its code, as ``an async function: ...``."""
    function = inner_of(function)
    if not hasattr(function, "__code__"):
        function = inspect.getattr_static(type(function), "__call__", function)
    if inspect.iscoroutinefunction(function) or inspect.isasyncgenfunction(function):
        return "an async function: write def instead of async def"
    if inspect.isgeneratorfunction(function):
        return "a generator function: write return instead of yield"
    return None


def where_defined(function: Callable[..., object]) -> str:
    return f"{signature_of(function) or '(...)'}{place_of(function)}"


def place_of(function: Callable[..., object]) -> str:
    """Return the definition's place of a user's callable, as `` (control.py:3)``; else ``""``."""
    line = users_line_of_callable(function)
    return "" if line is None else f" ({line.place})"


class CallTimes:
    """Counts and times the calls of the callbacks of a run."""

    def __init__(self) -> None:
        self._totals: dict[str, tuple[int, float]] = {}

    def total(self, slot: str) -> tuple[int, float]:
        """Return number and duration (s) of a slot's calls, without native ones; for any thread."""
        return self._totals.get(slot, (0, 0.0))

    def timed(self, slot: str, callback: Callable[..., Any]) -> Callable[..., Any]:
        """Return a callback whose count starts at 0."""
        totals = self._totals
        totals[slot] = (0, 0.0)

        @functools.wraps(callback, updated=())
        def call(*arguments: Any) -> Any:
            started = perf_counter()
            try:
                return callback(*arguments)
            finally:
                calls, seconds = totals[slot]
                totals[slot] = calls + 1, seconds + perf_counter() - started

        return call
