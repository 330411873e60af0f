"""From tests of right solutions to limits."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np

from robsim.base.checks import Floats
from robsim.teach.tasks.definition import Task
from robsim.teach.tasks.marks.sets import Sets
from robsim.teach.tasks.score import ScoreLimit

#: The minimum limit relative to the reference: right solutions may round differently.
_LEAST_MARGIN = 1.01
#: The minimum unit: a score that hardly ever differs would else scale the limits of all others by
#: its rare differences.
_LEAST_UNIT = 1.1
#: The minimum ratio between the limits of no points and full points.
NEAREST = 1.5
#: A margin, so that rounding cannot fail the test that determines a limit.
_ROUNDED = 1 + 1e-9


def limits_from(
    task: Task,
    right: Sequence[Sets],
    wrong: Sequence[Sets],
    pilot: int,
    rank: int,
) -> dict[str, ScoreLimit]:
    """Return the limits of a task's scores from the tests of right and of wrong solutions.

    In a test, each score has a statistic s, see `Score.statistic`. A score can be too large by
    log s and, for a consistency, also by -log s; their spread among right solutions differs. So
    the pilot tests give each a unit d: three standard deviations above its mean, for the solution
    with the largest value, and at least log 1.1.

    Another test is as far off as its worst score, e = max(log s / d). The limits are exp(c d), with
    one c for all: the r-th largest e of a solution's tests, for the solution with the largest. So
    the bound holds for all scores together, even for dependent ones. No limit is below 1.01.

    A score gives no points from the smallest median of a wrong solution beyond the limit, but
    always some below 1.5 times the limit. A score of kind ``"lost"`` gives none if the right steps
    are half of the reference's: a controller cannot act without an answer.
    """
    # (solutions, tests, tails): the logarithms that can be too large
    tails = np.stack([_tails(task, one.statistics) for one in right])
    before = tails[:, :pilot]
    least = math.log(_LEAST_MARGIN)
    # d = mean + 3 sd, of the right solution for which it is largest
    units = np.max(before.mean(axis=1) + 3 * before.std(axis=1), axis=0)
    units = units.clip(min=math.log(_LEAST_UNIT))
    # e = max(tail / d);  c = the r-th largest e, of the solution for which it is largest
    off = np.max(tails[:, pilot:] / units, axis=2)
    factor = float(np.max(np.sort(off, axis=1)[:, -rank]))
    bounds = iter((_ROUNDED * np.exp(np.maximum(factor * units, least))).tolist())
    medians = np.array(
        [np.nanmedian(one.statistics, axis=0) for one in wrong if one.through.any()]
    ).reshape(-1, len(task.scores))
    limits = {}
    for score, those in zip(task.scores, medians.T, strict=True):
        full = next(bounds)
        limit = ScoreLimit(full=full, zero=_zero(full, [2.0] if score.kind == "lost" else those))
        if score.kind == "consistency":
            inverse = next(bounds)
            below = 1 / _zero(inverse, 1 / those)
            limit = ScoreLimit(full=full, zero=limit.zero, low=1 / inverse, low_zero=below)
        limits[score.name] = limit
    return limits


def _zero(full: float, medians: Iterable[float]) -> float:
    """Return the statistic without points: the smallest median beyond the limit."""
    beyond = [median for median in medians if median > full]
    return float(max(min(beyond, default=0.0), NEAREST * full))


def _tails(task: Task, statistics: Floats) -> Floats:
    """Return log(s) for each score s, and also -log(s) if s can be too small."""
    columns = []
    for index, score in enumerate(task.scores):
        logs = np.log(statistics[:, index])
        columns += [logs, -logs] if score.kind == "consistency" else [logs]
    return np.stack(columns, axis=1)


def fewest_values(exceeded: float, confidence: float) -> int:
    """Return the number of values whose largest is a bound that few other values exceed.

    Another value exceeds the bound with the probability `exceeded`, at the confidence level
    `confidence`; both are within 0..1.
    """
    # P(the largest of n lies above the quantile) = 1 - (1 - p)^n
    return math.ceil(math.log1p(-confidence) / math.log1p(-exceeded))


def bound_rank(n: int, exceeded: float, confidence: float) -> int:
    """Return r: the r-th largest of n independent values is a bound that few others exceed.

    A one-sided tolerance bound for any distribution; `fewest_values` explains the arguments. The
    r-th largest lies above the quantile q(1 - p) if r values or more do, and their number is
    binomial: P(X >= r), X ~ B(n, p). Source: Wilks, Determination of Sample Sizes for Setting
    Tolerance Limits, Ann. Math. Statist. 12, 1941.
    """
    from scipy.special import bdtrc

    fewest = fewest_values(exceeded, confidence)
    if n < fewest:
        raise ValueError(f"n must be at least {fewest}, got {n}")
    rank = 1
    # bdtrc(r, n, p) = P(X >= r + 1)
    while bdtrc(rank, n, exceeded) >= confidence:
        rank += 1
    return rank


def share_interval(count: int, n: int, level: float = 0.95) -> tuple[float, float]:
    """Return the exact confidence interval of a probability, from its count in n trials.

    Source: Clopper and Pearson, The Use of Confidence or Fiducial Limits Illustrated in the Case of
    the Binomial, Biometrika 26, 1934.
    """
    from scipy.special import betaincinv

    outside = (1 - level) / 2
    low = float(betaincinv(count, n - count + 1, outside)) if count else 0.0
    high = float(betaincinv(count + 1, n - count, 1 - outside)) if count < n else 1.0
    return low, high
