"""Size and power of the doctor: how often it tells what, over many seeds of its situations.

python tests/support/doctor_power.py [SEEDS] [state|parameters]
"""

import sys
from collections.abc import Iterator
from contextlib import contextmanager

import parameter_estimators
import state_estimators
from robsim.doctor import _situations, check_estimator, check_parameter_estimator

_DRAWN = (_situations.weaving, _situations.turning, _situations.excited, _situations.resting)


@contextmanager
def seeded(seed: int) -> Iterator[None]:
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


def _cases(kinds):
    zoos = {
        "state": (state_estimators, check_estimator),
        "parameters": (parameter_estimators, check_parameter_estimator),
    }
    for kind in kinds:
        zoo, check = zoos[kind]
        for name, make in zoo.RIGHT.items():
            yield f"doctor, {kind}: ill", name, check, make, _is_ill, 0.0
        for name, (make, faults) in zoo.BROKEN.items():
            yield f"doctor, {kind}: {faults[0]}", name, check, make, _names(faults), 1.0


def _is_ill(report) -> bool:
    return not report


def _names(faults):
    def is_named(report) -> bool:
        told = [problem.kind for problem in report.problems]
        remarks = " ".join(report.remarks)
        return any(
            one.removeprefix("remark:") in (remarks if one.startswith("remark:") else told)
            for one in faults
        )

    return is_named


def rows(seeds, kinds=("state", "parameters")) -> list[dict]:
    """Return a row for each estimator of the zoo: how often its verdict is given.

    Parameters
    ----------
    seeds : iterable of int
        Seeds of the situations.
    kinds : iterable of str
        ``"state"``, ``"parameters"``.

    Returns
    -------
    list of dict
        verdict, situation (the estimator), rate, n, expected (0 for right ones: the share of false
        alarms; 1 for broken ones: the share that is named rightly).
    """
    seeds = list(seeds)
    cases = list(_cases(kinds))
    told = [0] * len(cases)
    for seed in seeds:
        with seeded(seed):
            for number, (_, _, check, make, is_told, _) in enumerate(cases):
                told[number] += is_told(check(make, budget=10.0))
    return [
        {
            "verdict": verdict,
            "situation": name,
            "rate": count / len(seeds),
            "n": len(seeds),
            "expected": expected,
        }
        for (verdict, name, _, _, _, expected), count in zip(cases, told, strict=True)
    ]


if __name__ == "__main__":
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 20
    for row in rows(range(count), sys.argv[2:] or ("state", "parameters")):
        print("{verdict:45} {situation:38} {rate:6.3f} of {n}, expected {expected:g}".format(**row))
