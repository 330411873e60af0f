"""The run of an estimator's checks and their report, for both kinds of estimators."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from contextvars import ContextVar
from dataclasses import dataclass, replace
from functools import wraps
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from robsim.base.check_report import CheckReport, Problem
from robsim.base.checks import Floats, check_float
from robsim.base.report import Table
from robsim.base.text import quoted
from robsim.simulation.callback_folder import CallbackFolder, Callbacks
from robsim.simulation.callbacks.slot import SlotHandle
from robsim.teach.doctor._errors import problem_of, problem_of_make
from robsim.teach.doctor._lines import line_of_covariance
from robsim.teach.doctor._situations import Situation
from robsim.teach.doctor._trial import EstimatorUnderTest, NoEstimator, Slot, Trial, in_time

BUDGET = 0.02  # s per call: a tenth of the default dt
Make = Callable[[], Any] | str | PathLike[str]
Checks = Callable[[EstimatorUnderTest], Iterable["Problem | str | Table | Done"]]
#: Called with a line when a check is done.
telling: ContextVar[Callable[[str], object]] = ContextVar("telling", default=lambda line: None)


@dataclass(frozen=True)
class Done:
    """A finished check; its problems precede this item."""

    title: str


def run_checks(make: Make, slot: Slot, budget: float, checks: Checks) -> CheckReport:
    """Run `checks`, which yield problems, the cause first, remarks and tables; return a report."""
    if isinstance(make, (str, PathLike)):
        make = _from_file(Path(make), slot)
    if not callable(make) or isinstance(make, SlotHandle):
        raise TypeError(
            "make must be a callable, such as a class or lambda: "
            f"My{slot.noun.capitalize()}(...), that returns a new {slot.noun}, got {quoted(make)}"
        )
    estimator = EstimatorUnderTest(
        make, slot, check_float("budget", budget, "s", exclusive_minimum=0)
    )
    found: list[Problem | str | Table] = []
    tell, known = telling.get(), 0
    try:
        for one in checks(estimator):
            if not isinstance(one, Done):
                found.append(one)
                continue
            ill = sum(isinstance(other, Problem) for other in found[known:])
            known = len(found)
            tell(f"{slot.file}, {one.title}: {ill or 'no'} problem{'s' * (ill != 1)}")
    except NoEstimator as none:
        found.append(problem_of_make(estimator, none.__cause__ or none))
    found.extend(str(one) if slot.may_print else one for one in _printed(estimator))
    if estimator.shows:
        found.append("it calls plt.show, which does nothing here but blocks a run until a click")
    return CheckReport(
        name=estimator.name,
        problems=tuple(one for one in found if isinstance(one, Problem)),
        remarks=tuple(one for one in found if isinstance(one, str)),
        tables=tuple(one for one in found if isinstance(one, Table)),
    )


def _from_file(path: Path, slot: Slot) -> Callable[[], Any]:
    is_file = path.suffix == ".py"
    if is_file and path.stem != slot.file:
        raise ValueError(f"make must be a file {slot.file}.py, or a folder with one, got {path}")
    folder = CallbackFolder(path.parent if is_file else path, (slot.file,))
    if load(folder)[slot.file] is False:
        raise ValueError(f"{folder.path / slot.file}.py is switched off: set ENABLED = True in it")
    return lambda: slot.from_file(fresh_callback(folder, slot.file))


def load(folder: CallbackFolder) -> Callbacks:
    """Load the callbacks of a folder; raise TimeoutError if loading takes too long."""
    callbacks: Callbacks = in_time(folder.load)
    return callbacks


def fresh_callback(folder: CallbackFolder, slot: str) -> Callable[..., Any]:
    """Return a callback from separate modules, which imports helper modules when called."""
    own, callbacks = folder.anew()
    callback: Any = callbacks[slot]
    if not own.helpers:
        return callback  # type: ignore[no-any-return]

    @wraps(callback)
    def call(*arguments: Any) -> Any:
        with own.importable():
            return callback(*arguments)

    call.__name__ = getattr(callback, "__name__", type(callback).__name__)
    return call


def _printed(estimator: EstimatorUnderTest) -> list[Problem]:
    text = estimator.stdout.text
    if not text:
        return []
    text = text if len(text) <= 40 else f"{text[:40]} ..."
    sentence = f"it prints, first {text!r}: remove the print"
    return [Problem(kind="prints", sentence=sentence, line=estimator.stdout.line or estimator.line)]


# Relative; equal sums may round differently if arrays are aligned differently in memory.
_TOLERANCE = 1e-6
_TOGETHER = 40  # steps


def replay_problem(alone: Trial, again: Trial | None = None) -> Problem | None:
    """Return a problem if a fresh estimator's results differ in the first half of the same run.

    The cause may be memory of the earlier run, data of future steps, or random numbers.
    """
    again = again or alone.estimator.try_in(alone.situation.first(len(alone.situation.u) // 2))
    step = _difference(again, alone)
    return None if step is None else _cause_of_difference(alone, again, step)


def together_problem(alone: Trial, other: Situation) -> Problem | None:
    """Return a problem if a second estimator, in another situation, influences the first."""
    estimator = alone.estimator
    together = estimator.try_together(alone.situation.first(_TOGETHER), other)
    step = _difference(together, alone)
    if step is None:
        return None
    if step == together.failed_at and problem_of(together).kind == "too slow":
        return problem_of(together)
    again = estimator.try_in(together.situation)
    if (other_step := _difference(again, alone)) is not None:
        return _cause_of_difference(alone, again, other_step)
    found = together.problem(
        "shared memory",
        f"two {estimator.slot.noun}s from make() influence each other, as with a global variable "
        "or a list in the class: keep all state in self, set in __init__, or in variables of make",
        step,
    )
    return replace(found, situation="two robots at the same time")


def _difference(trial: Trial, alone: Trial) -> int | None:
    """Return the first step whose output differs from the first run, or fails."""
    steps = min(len(trial.outputs), len(alone.outputs))
    one, other = trial.outputs[:steps], alone.outputs[:steps]
    if steps and one.shape != other.shape:
        return 0
    is_close = np.isclose(one, other, rtol=_TOLERANCE, atol=_TOLERANCE, equal_nan=True)
    differs = ~is_close.all(axis=1) if steps else np.zeros(1, bool)
    if differs.any():
        return int(differs.argmax())
    return trial.failed_at if trial.error else None


_DEPENDS_ON_FUTURE = (
    "depends on future",
    "its result depends on later steps: the first half of a run alone gives another result than "
    "within the whole run",
)
REMEMBERS = "remembers earlier run"
_REMEMBERS = (
    REMEMBERS,
    "a fresh one from make() remembers the previous run: set all state in __init__ (or "
    "inside make), not in a global variable, the class or a default argument",
)
_NOT_REPRODUCIBLE = (
    "not reproducible",
    "the same steps give another result each time: use random numbers with a fixed seed, "
    "np.random.default_rng(1), and step.t for the time",
)


def _cause_of_difference(alone: Trial, again: Trial, step: int) -> Problem:
    if again.error is not None:
        return problem_of(again)
    try_in = alone.estimator.try_in
    if _difference(try_in(alone.situation), alone) is None:
        return again.problem(*_DEPENDS_ON_FUTURE, step)
    third = try_in(again.situation).outputs
    is_memory = _changes_less(alone.outputs, again.outputs, third)
    return again.problem(*(_REMEMBERS if is_memory else _NOT_REPRODUCIBLE), step)


def _changes_less(first: Floats, second: Floats, third: Floats) -> bool:
    if len(third) != len(second):
        return False
    before = np.nanmax(abs(second - first[: len(second)]))
    return bool(np.nanmax(abs(third - second)) < 0.2 * before)


# Relative to the variances: far above rounding errors, far below the effect of a wrong formula.
_SYMMETRY_TOLERANCE = 1e-6
_MINIMUM_EIGENVALUE = 1e-12


def covariance_problem(trial: Trial) -> Problem | None:
    """Return a problem for the first step whose covariance is not symmetric positive definite.

    NEES and every ellipse need its inverse, and a variance of 0 claims exact knowledge.
    """
    for k, output in enumerate(trial.outputs):
        fault = fault_of_covariance(output[3:12].reshape(3, 3))
        if fault is not None:
            return trial.problem(*fault, k, line_of_covariance(trial.estimator))
    return None


def fault_of_covariance(P: Floats) -> tuple[str, str] | None:
    """Return kind and sentence of a covariance's fault; None = no fault."""
    variances = np.diag(P)
    for name, variance in zip(("x", "y", "heading"), variances, strict=True):
        if variance <= 0:
            return (
                "covariance not positive",
                f"its covariance has the variance {variance:.3g} for {name}: a variance must be "
                "above 0, since a variance of 0 claims exact knowledge",
            )
    # C = P(i, j) / sqrt(P(i, i) P(j, j)), without units
    C = P / np.sqrt(np.outer(variances, variances))
    i, j = np.unravel_index(np.argmax(abs(C - C.T)), C.shape)
    if abs(C[i, j] - C[j, i]) > _SYMMETRY_TOLERANCE:
        return (
            "covariance not symmetric",
            f"its covariance is not symmetric, P[{i}, {j}] = {P[i, j]:.4g} but P[{j}, {i}] = "
            f"{P[j, i]:.4g}: look for a missing transpose, or take P = (P + P.T) / 2",
        )
    minimum = np.linalg.eigvalsh((C + C.T) / 2)[0]
    if minimum < _MINIMUM_EIGENVALUE:
        return (
            "covariance not positive",
            f"its covariance is not positive definite, its correlation matrix has the eigenvalue "
            f"{minimum:.3g}: look for a wrong sign, or P = (I - K H) P with the K of another P",
        )
    return None
