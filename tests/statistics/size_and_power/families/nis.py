"""The NIS of a linear Kalman filter, right and with a Q or R that is wrong."""

from robsim.evaluation import nis_consistency
from size_and_power.linear_filter import filtered
from size_and_power.row import Row, counted

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


def rows(seeds: range) -> list[Row]:
    """Return the rates of rejections, and of verdicts at the limit."""
    found, right = [], []
    for (steps, q, r), promised in _REJECTED.items():
        reports = [_report(steps, q, r, seed) for seed in seeds]
        parts = [f"{name} x {factor:g}" for name, factor in (("Q", q), ("R", r)) if factor != 1]
        texts = (", ".join(parts) or "right", f"1 run of {steps} steps")
        given = [report.verdict != "consistent" for report in reports]
        found.append(counted("NIS", *texts, "rejected", promised, given))
        if not parts:
            # 1 to 3 standard deviations off: 31 % of a normal distribution
            edge = [report.at_limit for report in reports]
            right.append(counted("NIS", *texts, "at the limit", (0.25, 0.4), edge))
    return found + right


def _report(steps: int, q: float, r: float, seed: int):
    _, _, innovations, S = filtered(1, steps, q=q, r=r, seed=[seed, steps])
    return nis_consistency(innovations[0], S)
