"""The NEES of a linear Kalman filter, right and with a Q or R that is wrong."""

from robsim.estimation import nees_consistency
from size_and_power.linear_filter import factors, filtered, key_of
from size_and_power.trials import Row, Trials, random_of

STEPS = 100

# runs, factor of Q, factor of R -> rate of rejections, as ConsistencyReport promises them
_REJECTED = {
    (1, 1, 1): (0, 0.01),
    (5, 1, 1): (0, 0.01),
    (20, 1, 1): (0, 0.01),
    (50, 1, 1): (0, 0.01),
    (1, 1 / 4, 1): (0.4, 0.8),
    (1, 1, 1 / 4): (0.6, 1),
    (1, 4, 1): (0, 0.01),
    (1, 1, 4): (0, 0.01),
    (20, 1 / 4, 1): (0.99, 1),
    (20, 1, 1 / 4): (0.99, 1),
    (20, 4, 1): (0.99, 1),
    (20, 1, 4): (0.99, 1),
}

# A right one, and two of which about half are rejected.
_AT_LIMIT = {(20, 1, 1): (0, 0.1), (20, 1.45, 1): (0.4, 0.8), (20, 0.65, 1): (0.4, 0.8)}


def _verdicts(trace):
    given = {}
    for case in _REJECTED | _AT_LIMIT:
        runs, q, r = case
        errors, P, _, _ = filtered(runs, STEPS, q=q, r=r, rng=random_of(trace, runs))
        report = nees_consistency(errors, P)
        given[key_of(case, "rejected")] = report.verdict != "consistent"
        given[key_of(case, "at the limit")] = report.at_limit
    return given


def _row(case, answer, promised):
    runs, q, r = case
    record = f"{runs} run{'s' if runs > 1 else ''} of {STEPS} steps"
    return Row("NEES", factors(q, r), record, answer, promised)


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
