"""The run of an estimator's checks and their report, for both kinds of estimators."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import wraps
from os import PathLike
from pathlib import Path
from typing import Any

from robsim.base.check_report import CheckReport, Problem
from robsim.base.checks import check_float
from robsim.base.report import Table
from robsim.base.text import quoted
from robsim.simulation.callbacks.slot import SlotHandle
from robsim.simulation.folders.callback_folder import CallbackFolder, Callbacks
from robsim.simulation.time_limit import TimeLimit
from robsim.teach.doctor._errors import problem_of_make
from robsim.teach.doctor._trial import TIME_LIMIT, EstimatorUnderTest, NoEstimator, Slot

BUDGET = 0.02  # s per call: a tenth of the default dt

Make = Callable[[], Any] | str | PathLike[str]
Checks = Callable[[EstimatorUnderTest], Iterable[Problem | str | Table]]


def run_checks(make: Make, slot: Slot, budget: float, checks: Checks) -> CheckReport:
    """Run the checks of an estimator and return their report.

    Parameters
    ----------
    make : callable or path
        Returns a fresh estimator; or its file, or the folder of that.
    slot : Slot
        The slot of the simulation that the estimator is for.
    budget : float
        Maximum of the median time per call (s).
    checks : callable
        ``checks(estimator)``: yields problems, the cause first, remarks as strings, and tables.
    """
    if isinstance(make, (str, PathLike)):
        make = _from_file(Path(make), slot)
    if not callable(make) or isinstance(make, SlotHandle):
        raise TypeError(
            f"make must be callable and return a fresh {slot.noun}, such as its class, or lambda: "
            f"My{slot.noun.capitalize()}(...), got {quoted(make)}"
        )
    estimator = EstimatorUnderTest(
        make, slot, check_float("budget", budget, "s", exclusive_minimum=0)
    )
    problems: list[Problem] = []
    remarks: list[str] = []
    tables: list[Table] = []
    try:
        for item in checks(estimator):
            if isinstance(item, Problem):
                problems.append(item)
            elif isinstance(item, Table):
                tables.append(item)
            else:
                remarks.append(item)
    except NoEstimator as none:
        problems.append(problem_of_make(estimator, none.reason))
    for printed in _printed(estimator):
        if slot.may_print:
            remarks.append(str(printed))
        else:
            problems.append(printed)
    return CheckReport(
        name=estimator.name,
        problems=tuple(problems),
        remarks=tuple(remarks),
        tables=tuple(tables),
    )


def _from_file(path: Path, slot: Slot) -> Callable[[], Any]:
    """Return a function that executes a callback file anew and returns its estimator."""
    is_file = path.suffix == ".py"
    if is_file and path.stem != slot.file:
        raise ValueError(f"make must be a file {slot.file}.py, or a folder with one, got {path}")
    folder = CallbackFolder(path.parent if is_file else path, (slot.file,))
    if load(folder)[slot.file] is False:
        raise ValueError(f"{folder.path / slot.file}.py is switched off: set ENABLED = True in it")
    return lambda: slot.from_file(fresh_callback(folder, slot.file))


def load(folder: CallbackFolder) -> Callbacks:
    """Load the callbacks of a folder within the time limit.

    Raises
    ------
    TimeoutError
        If that takes longer.
    Exception
        As `CallbackFolder.load`.
    """
    limit = TimeLimit(TIME_LIMIT)
    with limit.watching():
        callbacks: Callbacks = limit.limited(folder.load)()
    return callbacks


def fresh_callback(folder: CallbackFolder, slot: str) -> Callable[..., Any]:
    """Return a callback of modules of its own, which imports helper modules when it is called."""
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
