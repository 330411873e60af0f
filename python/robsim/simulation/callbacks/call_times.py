"""How often the callbacks are called, and how long that takes."""

from __future__ import annotations

import functools
from collections.abc import Callable
from time import perf_counter
from typing import Any


class CallTimes:
    """Counts and times the calls of the callbacks of a run."""

    def __init__(self) -> None:
        self._totals: dict[str, tuple[int, float]] = {}

    def total(self, slot: str) -> tuple[int, float]:
        """Return the number of calls of what is in a slot, and their duration (s).

        Any thread may ask. Native stages are not counted.
        """
        return self._totals.get(slot, (0, 0.0))

    def timed(self, slot: str, callback: Callable[..., Any]) -> Callable[..., Any]:
        """Return a callback whose calls are counted anew."""
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
