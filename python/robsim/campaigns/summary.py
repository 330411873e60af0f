"""Means over the runs of a campaign with their intervals, and differences of paired runs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from robsim.base.checks import Floats
from robsim.base.report import Column, Report, Row, Table
from robsim.base.report.optional import import_optional

if TYPE_CHECKING:
    import pandas

_COLUMNS = (
    *("n", "mean", "half_width", "sd"),
    *("n_pairs", "difference", "difference_half_width", "more_runs"),
)
_WIDEST = 12  # label of a group, in letters, that stands at the head of a column


@dataclass(frozen=True, kw_only=True, eq=False)
class CampaignSummary(Report):
    """Means over the runs of each group of cases, and the differences from the first group.

    A run counts if its number is known in all cases of the group. The numbers of these cases are
    averaged first. So each run has one number, and the runs are independent.

    Attributes
    ----------
    by : tuple of str
        The options that make the groups.
    groups : tuple of str
        The groups; the differences are to the first one.
    metrics : tuple of str
        The M columns.
    n : array (G, M) of int
        Number of runs.
    mean, sd : array (G, M)
        Mean and standard deviation over the runs.
    half_width : array (G, M)
        Half width of the confidence interval of the mean.
    n_pairs : array (G, M) of int
        Number of runs known in both the group and the first one.
    difference, difference_half_width : array (G, M)
        Mean of the group minus the first one, run by run, and half the width of its confidence
        interval.
    more_runs : array (G, M)
        Number of further runs that let the interval exclude 0, if mean and spread of the
        differences stay the same; 0 = it excludes 0 now, NaN = not known, inf = no difference.
    level : float
        Level of confidence of all intervals.
    failed : int
        Number of failed runs.
    first_error : str
        The error of the first failed run, with its run and case.

    Notes
    -----
    The intervals are Student's t intervals for the mean of independent numbers. They hold for means
    over dozens of runs, and for numbers without far outliers. The intervals of differences are
    narrower than the intervals of the means suggest, since the runs of all cases have the same
    seeds. Each interval holds for a single comparison: of twenty differences, one is expected
    outside its 95 % interval. If you add runs until an interval excludes 0, you find differences
    that do not exist.
    """

    by: tuple[str, ...]
    groups: tuple[str, ...]
    metrics: tuple[str, ...]
    n: Floats
    mean: Floats
    sd: Floats
    half_width: Floats
    n_pairs: Floats
    difference: Floats
    difference_half_width: Floats
    more_runs: Floats
    level: float
    failed: int = 0
    first_error: str = ""

    @property
    def title(self) -> str:
        """The compared options."""
        return f"Means by {', '.join(self.by)}" if self.by else "Means over all cases"

    @property
    def tables(self) -> tuple[Table, ...]:
        """A table for each metric."""
        return tuple(self._table(index) for index in range(len(self.metrics)))

    def _table(self, index: int) -> Table:
        text = f"{100 * self.level:.10g} %"
        columns = [
            Column("mean", "mean", ""),
            Column("half_width", f"+- ({text})", "", ".2g"),
            Column("sd", "sd", "", ".3g"),
            Column("runs", "runs", ""),
        ]
        if len(self.groups) > 1:
            columns += [
                Column("difference", f"minus {self._first}", "", ".3g"),
                Column("difference_half_width", f"+- ({text})", "", ".2g"),
                Column("more_runs", "runs more", "", _runs),
            ]
        rows = [
            Row(group, self._values(g, index)[: len(columns)])
            for g, group in enumerate(self.groups)
        ]
        name = self.metrics[index]
        return Table(key=name, columns=columns, rows=rows, row_title=name)

    @property
    def _first(self) -> str:
        return self.groups[0] if len(self.groups[0]) <= _WIDEST else "the first"

    def _values(self, group: int, index: int) -> list[object]:
        differences = (self.difference, self.difference_half_width, self.more_runs)
        return [
            *(float(table[group, index]) for table in (self.mean, self.half_width, self.sd)),
            int(self.n[group, index]),
            *(float(table[group, index]) if group else None for table in differences),
        ]

    @property
    def remarks(self) -> tuple[str, ...]:
        """The kind of comparison, and the missing values."""
        remarks = []
        if len(self.groups) > 1 and self.metrics:
            remarks.append("differences compare runs with the same seed")
            remarks.append(
                "runs more: how many further runs let the interval of the difference exclude 0, if "
                "mean "
                "and spread stay the same; decided: it excludes 0 now"
            )
        if (self.n != self.n[:1]).any():
            remarks.append(
                "the means are of different runs, because some numbers are not known: compare the "
                "differences, which use only runs with both"
            )
        if self.failed:
            one = self.failed == 1
            runs = "1 run failed and counts" if one else f"{self.failed} runs failed and count"
            remarks.append(f"{runs} only where numbers are known; the first: {self.first_error}")
        return tuple(remarks)

    def to_pandas(self) -> pandas.DataFrame:
        """Return a data frame with a row for each metric and group.

        Raises
        ------
        ImportError
            If pandas is not installed.
        """
        pd = import_optional("pandas", "to_pandas needs")
        index = pd.MultiIndex.from_product([self.metrics, self.groups], names=["metric", "group"])
        columns = {name: getattr(self, name).T.ravel() for name in _COLUMNS}
        frame: pandas.DataFrame = pd.DataFrame(columns, index=index)
        return frame


def _runs(count: float) -> str:
    if math.isinf(count):
        return "no difference"
    return f"{count:.0f}" if count else "decided"


def summary_of(
    values: Floats,
    *,
    by: Sequence[str],
    groups: Sequence[str],
    metrics: Sequence[str],
    level: float,
    failed: int,
    first_error: str = "",
) -> CampaignSummary:
    """Return the summary of `values` (G, R, M): M metrics of R runs of G groups; NaN = unknown."""
    n, mean, sd, half_width = _statistics(values, level)
    with np.errstate(invalid="ignore"):  # inf - inf
        pairs = values - values[:1]
    n_pairs, difference, spread, difference_half_width = _statistics(pairs, level)
    return CampaignSummary(
        by=tuple(by),
        groups=tuple(groups),
        metrics=tuple(metrics),
        n=n,
        mean=mean,
        sd=sd,
        half_width=half_width,
        n_pairs=n_pairs,
        difference=difference,
        difference_half_width=difference_half_width,
        more_runs=_more_runs(n_pairs, difference, spread, level),
        level=level,
        failed=failed,
        first_error=first_error,
    )


def _statistics(values: Floats, level: float) -> tuple[Floats, Floats, Floats, Floats]:
    """Return number, mean, standard deviation, and half the interval of the mean over the runs."""
    known = ~np.isnan(values)
    n = np.count_nonzero(known, axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        mean = np.sum(values, axis=1, where=known) / n
        squares = np.sum(np.square(values - mean[:, np.newaxis]), axis=1, where=known)
        sd = np.sqrt(squares / np.where(n > 1, n - 1, np.nan))
        # half width = t(n - 1) sd / sqrt(n)
        half_width = _student(level, n) * sd / np.sqrt(n)
    return np.asarray(n), mean, sd, half_width


def _student(level: float, n: Floats) -> Floats:
    from scipy.special import stdtrit

    quantiles: Floats = stdtrit(np.maximum(n - 1, 1), (1 + level) / 2)
    return quantiles


def _more_runs(n: Floats, difference: Floats, sd: Floats, level: float) -> Floats:
    """Return the number of further runs for |difference| > t(n - 1) sd / sqrt(n)."""
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.square(sd / difference)
    needed = np.where(np.isnan(sd), np.nan, np.where(difference == 0, np.inf, 2.0))
    is_open = np.isfinite(ratio) & np.isfinite(needed)
    for _ in range(50):  # t depends on n; it settles in a few turns
        needed[is_open] = np.maximum(
            np.floor(np.square(_student(level, needed[is_open])) * ratio[is_open]) + 1, 2
        )
    more = np.maximum(needed - n, 0.0)
    is_decided = np.abs(difference) > _student(level, n) * sd / np.sqrt(np.maximum(n, 1))
    return np.where(np.isfinite(needed) & is_decided, 0.0, more)
