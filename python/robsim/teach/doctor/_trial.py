"""Trials of an estimator under test in a situation, with its output, errors and timing."""

from __future__ import annotations

import io
import sys
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, redirect_stdout
from dataclasses import dataclass
from typing import Any

import numpy as np

from robsim._core import Step
from robsim.base.check_report import Problem
from robsim.base.checks import Floats
from robsim.base.source_line import SourceLine, line_of_frame, users_line_of_callable
from robsim.base.text import quoted
from robsim.simulation.callbacks.slot import SlotHandle
from robsim.simulation.time_limit import TimeLimit
from robsim.teach.doctor._situations import Situation
from robsim.trace import Trace

TIME_LIMIT = 5.0  # s per call; after that it counts as an endless loop
_TIMED_CALLS = 20
_TIMED_LATER = 16  # every 16th call
_PROBE = 0.03  # s
_KEPT_CHARACTERS = 200  # of stdout


class BadResult(Exception):
    """An estimator returned a result that its slot cannot use."""

    def __init__(self, kind: str, sentence: str) -> None:
        super().__init__(sentence)
        self.kind = kind


def numbers_in(result: Any, shape: tuple[int, ...]) -> Floats | None:
    try:
        numbers = np.array(result, dtype=float)
    except (TypeError, ValueError):
        return None
    return numbers if numbers.shape == shape else None


def described(result: Any) -> str:
    if isinstance(result, np.ndarray):
        return f"an array of shape {result.shape} of {result.dtype}"
    text = repr(result)
    return text if len(text) <= 40 else f"a {type(result).__name__}"


def finite_numbers(
    result: Any, shape: tuple[int, ...], expected: str, hint: str, unit: str = ""
) -> Floats:
    """Return a result as finite numbers; a BadResult names the expected result or a hint."""
    numbers = numbers_in(result, shape)
    if numbers is None:
        raise BadResult("output shape", f"it returns {described(result)}, not {expected}")
    if not np.isfinite(numbers).all():
        raise BadResult("not finite", f"it returns {quoted(result)}{unit}: {hint}")
    return numbers


def in_time(function: Callable[..., Any], *given: Any) -> Any:
    """Call a function; raise TimeoutError if it takes too long."""
    limit = TimeLimit(TIME_LIMIT)
    with limit.watching():
        return limit.limited(function)(*given)


class NoEstimator(Exception):
    """make() returned no estimator; the cause is the error."""


@dataclass(frozen=True, kw_only=True)
class Slot:
    """The interface of one kind of estimator."""

    #: The function of an estimator that is called; raises BadResult without one.
    entry: Callable[[Any], Callable[..., Any]]
    #: ``read(result, previous)``: a result as numbers; raises BadResult.
    read: Callable[[Any, Floats | None], Floats]
    simulate: Callable[[Situation, Callable[[Step], Any]], Any]  # a `Runner`, or the like
    file: str  # the slot whose file in a callback folder has the estimator
    callback: Callable[[Any], Callable[[Step], Any]] = lambda estimator: estimator
    from_file: Callable[[Any], Any] = lambda callback: callback  # the estimator of that file
    noun: str = "estimator"  # in reports
    may_print: bool = False  # then a print is worth a remark only


@dataclass(frozen=True, kw_only=True, eq=False)
class Trial:
    """The outcome of an estimator in a situation."""

    estimator: EstimatorUnderTest
    situation: Situation
    outputs: Floats  # (n, width): the results of the steps before the error, or of all steps
    trace: Trace
    error: BaseException | None = None  # that ended the trial, at step n

    @property
    def failed_at(self) -> int:
        return len(self.outputs)

    def problem(
        self, kind: str, sentence: str, k: int | None = None, line: SourceLine | None = None
    ) -> Problem:
        """Return a problem of the trial; the default line is the definition of the estimator."""
        return Problem(
            kind=kind,
            sentence=sentence,
            situation=self.situation.name,
            k=k,
            line=line or self.estimator.line,
        )


class CallClock:
    """The duration of calls, independent of the machine's load."""

    def __init__(self) -> None:
        self._times: list[tuple[float, float, float]] = []

    def __len__(self) -> int:
        return len(self._times)

    @property
    def last(self) -> float:  # s
        return self._times[-1][0]

    @contextmanager
    def timed(self) -> Iterator[None]:
        before = _clocks()
        yield
        passed, thread, process = (now - then for now, then in zip(_clocks(), before, strict=True))
        self._times.append((passed, thread, process))

    def check(self, budget: float) -> None:
        """Raise BadResult if a call takes longer than the budget (s).

        The duration includes work and waiting, such as a sleep, but not the time in which other
        programs have the processor.
        """
        if not self._times:
            return
        passed, thread, process = np.array(self._times).T
        seconds, work = np.quantile(passed, 0.25), np.median(thread)
        if seconds > budget:
            waits = seconds - _slowdown() * np.median(process)
            seconds = min(seconds, work + max(0.0, waits))
        seconds = max(seconds, work)
        if seconds > budget:
            raise BadResult(
                "too slow",
                f"a call takes {1000 * seconds:.3g} ms, the median of {len(self)}, more than the "
                f"budget of {1000 * budget:.3g} ms",
            )


def _clocks() -> tuple[float, float, float]:
    """Return the time, and the processor time of this thread and of this process (s)."""
    return time.perf_counter(), time.thread_time(), time.process_time()


def _slowdown() -> float:
    """Return the factor by which the machine's load slows a program down now."""
    then, before, _ = _clocks()
    while time.thread_time() - before < _PROBE:
        pass
    now, after, _ = _clocks()
    return (now - then) / (after - before)


class StdoutCapture(io.TextIOBase):
    """A stdout that keeps the first line printed and the source line that printed it."""

    def __init__(self) -> None:
        self._text = ""
        self.line: SourceLine | None = None

    @property
    def text(self) -> str:
        return self._text.lstrip().partition("\n")[0]

    def write(self, text: str) -> int:
        if self.line is None:
            self.line = line_of_frame(sys._getframe(1))
        if len(self._text) < _KEPT_CHARACTERS:
            self._text += text
        return len(text)


class EstimatorUnderTest:
    """Makes fresh estimators to check, and runs trials; the budget limits the median call (s)."""

    def __init__(self, make: Callable[[], Any], slot: Slot, budget: float) -> None:
        self.slot = slot
        self.budget = budget
        self.make = make
        self.stdout = StdoutCapture()
        self.shows = False
        self.name = getattr(make, "__name__", type(make).__name__)
        self.line = users_line_of_callable(make)
        self.made: Any = None  # the last one

    def fresh(self) -> Callable[[Step], Any]:
        try:
            with self.observed():
                estimator = in_time(lambda: self.make())
                if isinstance(estimator, SlotHandle):  # sim.estimate_state
                    estimator = estimator.callback
            function = self.slot.entry(estimator)
        except (Exception, SystemExit) as error:
            raise NoEstimator from error
        self.made = estimator
        self.name = getattr(estimator, "__name__", type(estimator).__name__)
        self.line = users_line_of_callable(function) or self.line
        return self.slot.callback(estimator)

    def try_in(
        self, situation: Situation, watch: Callable[[int, Any], None] | None = None
    ) -> Trial:
        """Run a fresh estimator in a situation, alone; ``watch(k, estimator)`` after each step."""
        trial_run = _TrialRun(self, situation, watch)
        with self.observed():
            return trial_run.run()

    def try_together(self, situation: Situation, other: Situation) -> Trial:
        """Run one in a situation, alternating step by step with a second one in another."""
        first, second = _TrialRun(self, situation), _TrialRun(self, other)
        with self.observed(), first.watched(), second.watched():
            for _ in range(min(len(situation.u), len(other.u))):
                if first.step() or second.step():
                    break
            return first.trial()

    @contextmanager
    def observed(self) -> Iterator[None]:
        with redirect_stdout(self.stdout), warnings.catch_warnings(), self._windowless():
            # Numpy's warnings precede an error that says more, or are harmless.
            warnings.simplefilter("ignore")
            yield

    @contextmanager
    def _windowless(self) -> Iterator[None]:
        """Let plt.show do nothing."""
        pyplot: Any = sys.modules.get("matplotlib.pyplot")
        if pyplot is None:
            yield
            return

        def show(*_: Any, **__: Any) -> None:
            self.shows = True

        before, pyplot.show = pyplot.show, show
        try:
            yield
        finally:
            pyplot.show = before


class _TrialRun:
    """A running trial: a fresh estimator and the simulation that calls it."""

    def __init__(
        self,
        estimator: EstimatorUnderTest,
        situation: Situation,
        watch: Callable[[int, Any], None] | None = None,
    ) -> None:
        self._situation = situation
        self._watch = watch
        self._callback = estimator.fresh()
        self._made = estimator.made
        self._estimator = estimator
        self._outputs: list[Floats] = []
        self._clock = CallClock()
        self._error: BaseException | None = None
        self._simulation = estimator.slot.simulate(situation, self._estimate)

    def _estimate(self, step: Step) -> Any:
        if len(self._clock) < _TIMED_CALLS or step.k % _TIMED_LATER == 0:
            with self._clock.timed():
                result = self._callback(step)
            self._check_speed()
        else:
            result = self._callback(step)
        before = self._outputs[-1] if self._outputs else None
        self._outputs.append(self._estimator.slot.read(result, before))
        if self._watch is not None:
            self._watch(step.k, self._made)
        return result

    def _check_speed(self) -> None:
        count = len(self._clock)
        # After a few very slow calls the others would only cost time.
        if count == _TIMED_CALLS or (count >= 3 and self._clock.last > TIME_LIMIT / 5):
            self._clock.check(self._estimator.budget)

    def run(self) -> Trial:
        self._attempt(self._simulation.run, len(self._situation.u))
        return self.trial()

    def watched(self) -> AbstractContextManager[None]:
        """Enforce the time limit on all steps in the context; a limit per step takes longer."""
        watched: AbstractContextManager[None] = self._simulation._watched()
        return watched

    def step(self) -> bool:
        """Do a step; return whether that fails."""
        return self._attempt(self._simulation.step)

    def _attempt(self, act: Callable[..., Any], *given: Any) -> bool:
        try:
            act(*given)
        except (Exception, SystemExit) as error:
            self._error = error
        return self._error is not None

    def trial(self) -> Trial:
        return Trial(
            estimator=self._estimator,
            situation=self._situation,
            outputs=np.array(self._outputs),
            trace=self._simulation.trace,
            error=self._error,
        )
