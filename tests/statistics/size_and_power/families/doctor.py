"""The doctor's verdicts on the estimators of the zoo, in situations of other seeds."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from typing import NamedTuple

import parameter_estimators
import state_estimators
from robsim.doctor import _situations, check_estimator, check_parameter_estimator
from size_and_power.row import Row, counted

SHARE = 0.02  # the whole zoo takes more than a minute

_ZOOS = {
    "state": (state_estimators, check_estimator),
    "parameters": (parameter_estimators, check_parameter_estimator),
}
_DRAWN = (_situations.weaving, _situations.turning, _situations.excited, _situations.resting)


class _Case(NamedTuple):
    kind: str
    name: str
    make: Callable
    answer: str
    promised: tuple[float, float]
    is_given: Callable  # of the report


def rows(seeds: range, every: int = 1) -> list[Row]:
    """Return the rates of right estimators that are called ill, and of faults that are found.

    `every`: which estimators, 3 for every third.
    """
    cases = [case for kind in _ZOOS for case in _cases(kind)][::every]
    given: list[list[bool]] = [[] for _ in cases]
    for seed in seeds:
        with _seeded(seed):
            for case, answers in zip(cases, given, strict=True):
                _, check = _ZOOS[case.kind]
                answers.append(case.is_given(check(case.make, budget=10.0)))
    return [
        counted(f"doctor, {case.kind}", case.name, "its own runs", case.answer, case.promised, one)
        for case, one in zip(cases, given, strict=True)
    ]


def _cases(kind: str) -> Iterator[_Case]:
    zoo, _ = _ZOOS[kind]
    for name, make in zoo.RIGHT.items():
        yield _Case(kind, name, make, "ill", (0, 0.01), lambda report: not report)
    for name, (make, faults) in zoo.BROKEN.items():
        yield _Case(kind, name, make, faults[0], (0.95, 1), partial(_names, faults))


def _names(faults, report) -> bool:
    told = [problem.kind for problem in report.problems]
    remarks = " ".join(report.remarks)
    return any(
        one.removeprefix("remark:") in (remarks if one.startswith("remark:") else told)
        for one in faults
    )


@contextmanager
def _seeded(seed: int) -> Iterator[None]:
    """Let the doctor's situations be drawn with another seed."""
    usual = _situations._SEED
    _forget()
    _situations._SEED = seed
    try:
        yield
    finally:
        _situations._SEED = usual
        _forget()


def _forget() -> None:
    for situation in _DRAWN:
        situation.cache_clear()
