"""Single calls of callbacks that no run is needed for, and the report on them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from functools import partial
from os import PathLike
from typing import Any

from robsim.base.check_report import CheckReport, Problem
from robsim.base.source_line import line_of_error
from robsim.base.text import quoted
from robsim.simulation.callbacks.checks import check_callback
from robsim.simulation.callbacks.slot import Slot
from robsim.simulation.time_limit import TimeLimit
from robsim.teach.doctor._errors import explained
from robsim.teach.doctor._run_checks import BUDGET, run_checks
from robsim.teach.doctor._trial import TIME_LIMIT, BadResult, CallClock, EstimatorUnderTest
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


class _CallFailed(Exception):
    """A call has failed; `problem` says how."""

    def __init__(self, problem: Problem) -> None:
        super().__init__(problem.sentence)
        self.problem = problem


class CallbackCalls:
    """Calls of a callback, each of a fresh one.

    Parameters
    ----------
    callback : EstimatorUnderTest
        The callback.
    """

    def __init__(self, callback: EstimatorUnderTest) -> None:
        self._callback = callback
        self._clock = CallClock()

    def call(self, situation: str, *arguments: Any) -> Any:
        """Return what a fresh callback returns."""
        function = self._callback.fresh()
        limit = TimeLimit(TIME_LIMIT)
        try:
            with self._callback.observed(), limit.watching(), self._clock.timed():
                result = limit.limited(function)(*arguments)
        except (Exception, SystemExit) as error:
            kind, sentence = explained(error)
            line = line_of_error(error)
            raise _CallFailed(self.problem(kind, sentence, situation, line)) from error
        return result

    def problem(self, kind: str, sentence: str, situation: str = "", line: Any = None) -> Problem:
        return Problem(
            kind=kind, sentence=sentence, situation=situation, line=line or self._callback.line
        )

    def slowness(self) -> Iterator[Problem]:
        try:
            self._clock.check(self._callback.budget)
        except BadResult as slow:
            yield self.problem(slow.kind, str(slow))


def check_calls(
    make: Callable[[], Any] | str | PathLike[str],
    slot: Slot[Any],
    checks: Callable[[CallbackCalls], Iterable[Problem | str]],
    budget: float = BUDGET,
) -> CheckReport:
    """Run the checks of a callback by single calls, and return their report.

    Parameters
    ----------
    make : callable or path
        Returns a fresh callback; or its file, or the folder of that.
    slot : Slot
        Its slot.
    checks : callable
        ``checks(calls)``: yields problems and remarks.
    budget : float
        Maximum of the median time per call (s).
    """

    def run(callback: EstimatorUnderTest) -> Iterator[Problem | str]:
        calls = CallbackCalls(callback)
        try:
            yield from checks(calls)
        except _CallFailed as failed:
            yield failed.problem
        else:
            yield from calls.slowness()

    return run_checks(make, under_test(slot, "callback", _unused, _unused), budget, run)


def _unused(*arguments: Any) -> Any:
    raise AssertionError("there are no trials, only calls")
