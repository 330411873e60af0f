"""The NEES of a linear Kalman filter, right and with a Q or R that is wrong."""

from robsim.evaluation import nees_consistency
from size_and_power.linear_filter import filtered
from size_and_power.row import Row, counted

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


def rows(seeds: range) -> list[Row]:
    """Return the rates of rejections, and of verdicts at the limit."""
    reports = {case: [_report(case, seed) for seed in seeds] for case in _REJECTED | _AT_LIMIT}
    found = []
    for case, promised in _REJECTED.items():
        given = [verdict != "consistent" for verdict, _ in reports[case]]
        found.append(counted("NEES", *_texts(case), "rejected", promised, given))
    for case, promised in _AT_LIMIT.items():
        given = [at_limit for _, at_limit in reports[case]]
        found.append(counted("NEES", *_texts(case), "at the limit", promised, given))
    return found


def _report(case: tuple[int, float, float], seed: int) -> tuple[str, bool]:
    runs, q, r = case
    errors, P, _, _ = filtered(runs, STEPS, q=q, r=r, seed=[seed, runs])
    report = nees_consistency(errors, P)
    return report.verdict, report.at_limit


def _texts(case: tuple[int, float, float]) -> tuple[str, str]:
    runs, q, r = case
    parts = [f"{name} x {factor:g}" for name, factor in (("Q", q), ("R", r)) if factor != 1]
    return ", ".join(parts) or "right", f"{runs} run{'s' if runs > 1 else ''} of {STEPS} steps"
