"""The Ljung-Box test of innovations, with the number of lags that it chooses itself."""

import numpy as np

from robsim.estimation import whiteness
from size_and_power.trials import Row, Trials, random_of

_SHAPES = ((20, 3), (40, 1), (60, 3), (100, 1), (100, 3), (200, 3), (400, 3), (1000, 3), (5, 12, 3))
_SIZE = (0.04, 0.07)
_MEMORIES = {0.2: (0.95, 1), 0.5: (0.99, 1)}  # and the rates that are promised
_LONG = (400, 3)


def _record(shape):
    *runs, steps, n = shape
    return f"{runs[0]} runs of {steps} steps of {n}" if runs else f"{steps} steps of {n}"


def _row(hypothesis, record, promised, answer="not white"):
    return Row("whiteness", hypothesis, record, answer, promised)


def _verdicts(trace):
    def noise(*shape):
        return random_of(trace, *shape).normal(size=shape)

    innovations = {_record(shape): noise(*shape) for shape in _SHAPES}
    innovations["gaps"] = _with_gaps(noise(200, 3), random_of(trace, 1))
    for memory in _MEMORIES:
        innovations[f"memory {memory}"] = _autoregressive(noise(*_LONG), memory)
    reports = {key: whiteness(values) for key, values in innovations.items()}
    # 3 x 10 degrees of freedom: from 36.0 to 51.5
    edge = {"edge": reports[_record(_LONG)].at_limit}
    return {key: not report.is_white for key, report in reports.items()} | edge


def _with_gaps(values, rng):
    missing = rng.random(len(values)) < 0.2
    return np.where(missing[:, None], np.nan, values)


def _autoregressive(values, memory):
    for k in range(1, len(values)):
        values[k] += memory * values[k - 1]
    return values


TRIALS = (
    Trials(
        name="ljung-box",
        metric=_verdicts,
        rows={
            **{("", _record(shape)): _row("white", _record(shape), _SIZE) for shape in _SHAPES},
            ("", "gaps"): _row("white", "200 steps of 3, 20 % missing", _SIZE),
            **{
                ("", f"memory {memory}"): _row(
                    f"autoregressive, {memory:g}", _record(_LONG), promised
                )
                for memory, promised in _MEMORIES.items()
            },
            ("", "edge"): _row("white", _record(_LONG), (0.15, 0.25), "at the limit"),
        },
    ),
)
