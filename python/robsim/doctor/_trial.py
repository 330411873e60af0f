"""A student's estimator in a situation."""

from __future__ import annotations

import io
import sys
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stdout
from dataclasses import dataclass
from typing import Any

import numpy as np

from robsim._base.checks import Floats
from robsim._base.source_line import SourceLine, line_of_callable, line_of_frame
from robsim._core import Step
from robsim.doctor._situations import Situation
from robsim.simulation._simulation import Simulation
from robsim.simulation._time_limit import TimeLimit

TIME_LIMIT = 5.0  # s a call; who takes longer never comes back
_TIMED = 20  # calls
_HEARD = 200  # characters


class BadResult(Exception):
    """An estimator returned what its slot cannot use."""

    def __init__(self, kind: str, sentence: str) -> None:
        super().__init__(sentence)
        self.kind = kind


class NoEstimator(Exception):
    """There is none to try: `reason` says why."""

    def __init__(self, reason: BaseException) -> None:
        super().__init__(str(reason))
        self.reason = reason


@dataclass(frozen=True, kw_only=True)
class Slot:
    """What a kind of estimators has in common.

    Attributes
    ----------
    entry : callable
        What `make` returned -> its function that is called; raises BadResult if it has none.
    callback : callable
        What `make` returned -> the callback ``(step) -> result``.
    read : callable
        A result, and the numbers before or None -> its numbers; raises BadResult.
    simulate : callable
        A situation and the callback -> the simulation.
    """

    entry: Callable[[Any], Callable[..., Any]]
    callback: Callable[[Any], Callable[[Step], Any]]
    read: Callable[[Any, Floats | None], Floats]
    simulate: Callable[[Situation, Callable[[Step], Any]], Simulation]


@dataclass(frozen=True, kw_only=True, eq=False)
class Trial:
    """What an estimator did in a situation.

    Attributes
    ----------
    outputs : array (n, width)
        What it returned at each step that it got through.
    error : BaseException or None
        What ended it at the step after those.
    """

    situation: Situation
    outputs: Floats
    error: BaseException | None = None

    @property
    def failed_at(self) -> int:
        """The step of the error."""
        return len(self.outputs)


class StdoutCapture(io.TextIOBase):
    """A stdout that keeps the first line printed, and what printed it."""

    def __init__(self) -> None:
        self._text = ""
        self.line: SourceLine | None = None

    @property
    def text(self) -> str:
        """The first line; empty if nothing was printed."""
        return self._text.lstrip().partition("\n")[0]

    def write(self, text: str) -> int:
        """Hear what is printed; Python calls it."""
        if self.line is None:
            self.line = line_of_frame(sys._getframe(1))
        if len(self._text) < _HEARD:
            self._text += text
        return len(text)


class EstimatorUnderTest:
    """The estimator to be checked.

    Parameters
    ----------
    make : callable
        Returns a fresh one.
    slot : Slot
        The slot of the simulation that it is for.
    budget : float
        Time that a call may take, in the median (s).
    """

    def __init__(self, make: Callable[[], Any], slot: Slot, budget: float) -> None:
        self.slot = slot
        self.budget = budget
        self._make = make
        self.stdout = StdoutCapture()
        self.name = getattr(make, "__name__", repr(make))
        self.line = line_of_callable(make)

    def fresh(self) -> Callable[[Step], Any]:
        """Return the callback of a fresh estimator."""
        try:
            limit = TimeLimit(TIME_LIMIT)
            with self._observed(), limit.watching():
                estimator = limit.limited(lambda: self._make())()
            function = self.slot.entry(estimator)
        except (Exception, SystemExit) as error:
            raise NoEstimator(error) from error
        self.name = getattr(estimator, "__name__", type(estimator).__name__)
        self.line = line_of_callable(function) or self.line
        return self.slot.callback(estimator)

    def try_in(self, situation: Situation) -> Trial:
        """Try a fresh estimator in a situation, alone."""
        rehearsal = _Rehearsal(self, situation)
        with self._observed():
            return rehearsal.run()

    def try_together(self, situation: Situation, other: Situation) -> Trial:
        """Try one in a situation while a second one, turn by turn, is in another."""
        first, second = _Rehearsal(self, situation), _Rehearsal(self, other)
        with self._observed():
            for _ in range(min(len(situation.u), len(other.u))):
                if first.step() or second.step():
                    break
            return first.trial()

    @contextmanager
    def _observed(self) -> Iterator[None]:
        with redirect_stdout(self.stdout), warnings.catch_warnings():
            # Those of numpy come before an error that says more, or mean nothing.
            warnings.simplefilter("ignore")
            yield


class _Rehearsal:
    """A fresh estimator and the simulation around it."""

    def __init__(self, estimator: EstimatorUnderTest, situation: Situation) -> None:
        self._situation = situation
        self._callback = estimator.fresh()
        self._patient = estimator
        self._outputs: list[Floats] = []
        self._seconds: list[float] = []
        self._error: BaseException | None = None
        self._simulation = estimator.slot.simulate(situation, self._estimate)

    def _estimate(self, step: Step) -> Any:
        start = time.perf_counter()
        result = self._callback(step)
        self._seconds.append(time.perf_counter() - start)
        before = self._outputs[-1] if self._outputs else None
        self._outputs.append(self._patient.slot.read(result, before))
        self._check_speed()
        return result

    def _check_speed(self) -> None:
        if len(self._seconds) != _TIMED:
            return
        seconds = float(np.median(self._seconds))
        if seconds > self._patient.budget:
            raise BadResult(
                "too slow",
                f"a call takes {1000 * seconds:.3g} ms in the median of {_TIMED}, more than the "
                f"budget of {1000 * self._patient.budget:.3g} ms",
            )

    def run(self) -> Trial:
        """Do all steps."""
        try:
            self._simulation.run(len(self._situation.u))
        except (Exception, SystemExit) as error:
            self._error = error
        return self.trial()

    def step(self) -> bool:
        """Do one; return whether it failed."""
        try:
            self._simulation.step()
        except (Exception, SystemExit) as error:
            self._error = error
        return self._error is not None

    def trial(self) -> Trial:
        """Return what came of it."""
        return Trial(
            situation=self._situation,
            outputs=np.array(self._outputs),
            error=self._error,
        )
