"""One checkup, whatever the estimator."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from robsim._base.check_report import CheckReport, Problem
from robsim._base.checks import check_float
from robsim.doctor._errors import problem_of_make
from robsim.doctor._trial import EstimatorUnderTest, NoEstimator, Slot

BUDGET = 0.02  # s a call: a tenth of the default dt

Checks = Callable[[EstimatorUnderTest], Iterable[Problem | str]]


def examine(make: Callable[[], Any], slot: Slot, budget: float, checks: Checks) -> CheckReport:
    """Return what a checks finds in an estimator: problems, and remarks as strings.

    Parameters
    ----------
    make : callable
        Returns a fresh estimator.
    slot : Slot
        What it is for.
    budget : float
        Time that a call may take, in the median (s).
    checks : callable
        ``checks(estimator)``: what is found, one after the other, the cause first.
    """
    if not callable(make):
        raise TypeError(
            f"make must be callable and return a fresh estimator, such as its class, got {make!r}"
        )
    estimator = EstimatorUnderTest(
        make, slot, check_float("budget", budget, "s", exclusive_minimum=0)
    )
    problems: list[Problem] = []
    remarks: list[str] = []
    try:
        for item in checks(estimator):
            if isinstance(item, Problem):
                problems.append(item)
            else:
                remarks.append(item)
    except NoEstimator as none:
        problems.append(problem_of_make(estimator, none.reason))
    return CheckReport(
        name=estimator.name,
        problems=(*problems, *_printed(estimator)),
        remarks=tuple(remarks),
    )


def _printed(estimator: EstimatorUnderTest) -> list[Problem]:
    text = estimator.stdout.text
    if not text:
        return []
    text = text if len(text) <= 40 else f"{text[:40]} ..."
    sentence = f"it prints, {text!r} at first: in a run of 800 steps nobody can read that"
    return [Problem(kind="prints", sentence=sentence, line=estimator.stdout.line or estimator.line)]
