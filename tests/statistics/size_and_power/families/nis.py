"""The NIS of a linear Kalman filter, right and with a Q or R that is wrong."""

from robsim.estimation import nis_consistency
from size_and_power.linear_filter import factors, filtered, key_of
from size_and_power.trials import Row, Trials, random_of

# steps, factor of Q, factor of R -> rate of rejections
_REJECTED = {
    (50, 1, 1): (0.04, 0.06),
    (100, 1, 1): (0.04, 0.06),
    (400, 1, 1): (0.04, 0.06),
    (200, 1, 1 / 4): (0.99, 1),
    (200, 1, 4): (0.99, 1),
    (200, 1 / 4, 1): (0.08, 1),
    (200, 4, 1): (0.08, 1),
}

# 1 to 3 standard deviations off: 31 % of a normal distribution
_AT_LIMIT = {case: (0.25, 0.4) for case in _REJECTED if case[1:] == (1, 1)}


def _verdicts(trace):
    given = {}
    for case in _REJECTED:
        steps, q, r = case
        _, _, innovations, S = filtered(1, steps, q=q, r=r, rng=random_of(trace, steps))
        report = nis_consistency(innovations[0], S)
        given[key_of(case, "rejected")] = report.verdict != "consistent"
        given[key_of(case, "at the limit")] = report.at_limit
    return given


def _row(case, answer, promised):
    steps, q, r = case
    return Row("NIS", factors(q, r), f"1 run of {steps} steps", answer, promised)


TRIALS = (
    Trials(
        name="linear-filter",
        metric=_verdicts,
        rows={
            ("", key_of(case, answer)): _row(case, answer, promised)
            for answer, cases in (("rejected", _REJECTED), ("at the limit", _AT_LIMIT))
            for case, promised in cases.items()
        },
    ),
)
