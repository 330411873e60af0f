"""The doctor's findings on the estimators of the zoo, in situations of other seeds.

What is kept of an estimator in a run is one number: the place of what the doctor says of it in
`FINDINGS`, 0 if nothing.
"""

from contextlib import contextmanager
from functools import partial

import numpy as np

import parameter_estimators
import state_estimators
from robsim.teach import check_estimator, check_parameter_estimator
from robsim.teach.doctor import _situations
from size_and_power.trials import Row, Trials, random_of

_ZOOS = {
    "state": (state_estimators, check_estimator),
    "parameters": (parameter_estimators, check_parameter_estimator),
}
_DRAWN = (_situations.weaving, _situations.turning, _situations.excited, _situations.resting)
_RIGHT = ""  # the fault of a right one
_REMARK = "remark:"

#: Estimators by kind and name: what makes them, and their faults, each of which counts as named.
ESTIMATORS = {
    kind: {name: (make, [_RIGHT]) for name, make in zoo.RIGHT.items()} | zoo.BROKEN
    for kind, (zoo, _) in _ZOOS.items()
}
FINDINGS = (
    *dict.fromkeys(faults[0] for zoo in ESTIMATORS.values() for _, faults in zoo.values()),
    "another",
)


def finding(report, faults):
    """Return the place in `FINDINGS` of what a report says: the fault, if that is among it."""
    told = [problem.kind for problem in report.problems]
    if any(_is_told(fault, told, report.remarks) for fault in faults if fault):
        return FINDINGS.index(faults[0])
    first = told[0] if told else _RIGHT
    return FINDINGS.index(first if first in FINDINGS else "another")


def _is_told(fault, problems, remarks):
    if fault.startswith(_REMARK):
        return fault.removeprefix(_REMARK) in " ".join(remarks)
    return fault in problems


def _findings(trace, kind, every):
    _, check = _ZOOS[kind]
    with _seeded(int(random_of(trace).integers(2**31))):
        return {
            name: finding(check(make, budget=10.0), faults)
            for name, (make, faults) in _some(kind, every).items()
        }


def _some(kind, every):
    return dict(list(ESTIMATORS[kind].items())[::every])


@contextmanager
def _seeded(seed):
    """Let the doctor's situations be drawn with another seed."""
    usual = _situations._SEED
    _forget()
    _situations._SEED = seed
    try:
        yield
    finally:
        _situations._SEED = usual
        _forget()


def _forget():
    for situation in _DRAWN:
        situation.cache_clear()


def _names(kind, every):
    """Return the names of the estimators by fault."""
    names = {}
    for name, (_, faults) in _some(kind, every).items():
        names.setdefault(faults[0], []).append(name)
    return names


def _answers(numbers, kind, every):
    """Whether a fault was named; of right estimators, whether anything was."""
    given = {}
    for fault, names in _names(kind, every).items():
        said = np.array([numbers[name] for name in names])
        given[fault] = said == FINDINGS.index(fault) if fault else said > 0
    return given


def _row(kind, fault, number):
    promised = (0.95, 1) if fault else (0, 0.01)
    record = f"{number} estimator{'s' if number > 1 else ''}"
    hypothesis = fault.removeprefix(_REMARK) or "right"
    return Row(f"doctor, {kind}", hypothesis, record, "named" if fault else "ill", promised)


def trials(kind, every=1):
    """Return the trials of every so many estimators of a kind."""
    return Trials(
        name=kind,
        metric=partial(_findings, kind=kind, every=every),
        answers=partial(_answers, kind=kind, every=every),
        rows={
            ("", fault): _row(kind, fault, len(names))
            for fault, names in _names(kind, every).items()
        },
        share=0.02,  # the whole zoo takes more than a minute
    )


TRIALS = tuple(trials(kind) for kind in _ZOOS)
