"""Single calls of callbacks that need no run, and the report on them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from functools import partial
from typing import Any

from robsim.base.check_report import CheckReport, Problem
from robsim.base.source_line import line_of_error
from robsim.base.text import quoted
from robsim.simulation.callbacks.checks import check_callback
from robsim.simulation.callbacks.slot import Slot
from robsim.teach.doctor._errors import explained
from robsim.teach.doctor._run_checks import BUDGET, Make, run_checks
from robsim.teach.doctor._trial import BadResult, CallClock, EstimatorUnderTest, in_time
from robsim.teach.doctor._trial import Slot as UnderTest


def under_test(
    slot: Slot[Any], noun: str, read: Callable[..., Any], simulate: Callable[..., Any]
) -> UnderTest:
    return UnderTest(
        entry=partial(_entry, slot),
        read=read,
        simulate=simulate,
        file=slot.name,
        noun=noun,
        may_print=True,
    )


def _entry(slot: Slot[Any], callback: Any) -> Callable[..., Any]:
    """Return a callback; raises BadResult if its slot would refuse it."""
    try:
        if not callable(callback):  # also for None, which means the default elsewhere
            raise TypeError(f"{slot.name} must be callable, got {quoted(callback)}")
        check_callback(slot.name, callback)
    except TypeError as error:
        raise BadResult("wrong callback", str(error)) from None
    return callback  # type: ignore[no-any-return]


class Failed(Exception):
    """A callback has failed with `problem`."""

    def __init__(self, problem: Problem) -> None:
        super().__init__(problem.sentence)
        self.problem = problem


class CallbackCalls:
    """Calls of fresh callbacks from one maker."""

    def __init__(self, callback: EstimatorUnderTest) -> None:
        self._callback = callback
        self._clock = CallClock()

    def call(
        self, situation: str, *arguments: Any, read: Callable[[Any], Any] = lambda result: result
    ) -> Any:
        """Return the result of a fresh callback, after `read`, which may raise BadResult."""
        function = self._callback.fresh()
        try:
            with self._callback.observed():
                result = in_time(self._clock.timed()(function), *arguments)
            return read(result)
        except (Exception, SystemExit) as error:
            problem = self.problem(*explained(error), situation, line_of_error(error))
            raise Failed(problem) from error

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
    make: Make,
    slot: Slot[Any],
    checks: Callable[[CallbackCalls], Iterable[Problem | str]],
    budget: float = BUDGET,
) -> CheckReport:
    def run(callback: EstimatorUnderTest) -> Iterator[Problem | str]:
        calls = CallbackCalls(callback)
        try:
            yield from checks(calls)
        except Failed as failed:
            yield failed.problem
        else:
            yield from calls.slowness()

    return run_checks(make, under_test(slot, "callback", _unused, _unused), budget, run)


def _unused(*arguments: Any) -> Any:
    raise AssertionError("there are no trials, only calls")
