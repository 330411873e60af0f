"""`Score`: a number of a task's runs, and the combination of several runs into a statistic."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from robsim.base.checks import (
    Floats,
    as_float_array,
    check_choice,
    check_float,
    check_name,
    check_text,
)

#: A score of kind ``"lost"`` has no share: its fraction multiplies the points of all others.
KINDS = ("ratio", "consistency", "lost")


@dataclass(frozen=True, kw_only=True)
class Score:
    """A number by which the runs of a task are scored.

    Parameters
    ----------
    name : str
        Its name, as in the numbers that `Task.score` returns.
    title : str
        Its description for people.
    unit : str
        Its unit; "" = without a unit.
    kind : {"ratio", "consistency", "lost"}
        The combination of several runs; see `statistic`.
    share : float
        Its share of the points of a test; the shares of a task sum to 1. A score of kind ``"lost"``
        has the share 0, but all other scores are multiplied by its fraction of the points.
    floor, worst : float
        Bounds of the number: a better number than `floor` counts as `floor`. A worse number than
        `worst`, or NaN, counts as `worst`.

    Raises
    ------
    TypeError, ValueError
        If an argument has the wrong type or is out of range; the message names it.

    Examples
    --------
    >>> score = robsim.teach.ParkTask().scores[1]
    >>> f"{score.title} ({score.unit})"
    'distance from the goal at the end (px)'
    """

    name: str
    title: str
    unit: str = ""
    kind: str = "ratio"
    share: float = 1.0
    floor: float
    worst: float

    def __post_init__(self) -> None:
        check_name("name", self.name)
        check_text("title", self.title)
        check_text("unit", self.unit)
        check_choice("kind", self.kind, KINDS)
        check_float("share", self.share, minimum=0, maximum=1)
        check_float("floor", self.floor, self.unit, exclusive_minimum=0)
        check_float("worst", self.worst, self.unit, exclusive_minimum=self.floor)
        if (self.kind == "lost") != (self.share == 0):
            raise ValueError(
                "share must be 0 for kind 'lost', and above 0 for other kinds, got "
                f"{self.share} for {self.kind!r}"
            )
        if self.kind == "lost" and self.worst >= _ALL:
            raise ValueError(f"worst must be below {_ALL:g} % for kind 'lost', got {self.worst}")

    def statistic(self, values: Sequence[float], reference: Sequence[float]) -> float:
        """Return the combined number of some runs, relative to a reference.

        Parameters
        ----------
        values, reference : sequence of float, (M,)
            The numbers of a submission and of the reference, of the same runs in the same order.

        Returns
        -------
        float
            For the kind ``"ratio"``, the geometric mean of value/reference: 1 is as good as the
            reference, 2 is twice as bad. For ``"consistency"``, the geometric mean of the values,
            which should be 1. For ``"lost"`` (% of the steps), the remaining steps of the
            reference, divided by the remaining steps of the runs.

        Raises
        ------
        TypeError, ValueError
            If the values are not numbers, are empty, or differ in number from the reference's
            values.

        Notes
        -----
        Any method loses the robot in some runs. Such a run outweighs all other runs together in a
        mean of squares, but not in a geometric mean.
        """
        own, others = self._known("values", values), self._known("reference", reference)
        if len(own) != len(others):
            raise ValueError(
                "values and reference must have one number per run, for the same runs, got "
                f"{len(own)} and {len(others)}"
            )
        return float(self._of_tests(own, others))

    def _of_tests(self, own: Floats, others: Floats) -> Floats:
        """Return the statistics of tests, (..., M) -> (...)."""
        own, others = self._clipped(own), self._clipped(others)
        if self.kind == "lost":
            # statistic = sum(100 - reference) / sum(100 - value)
            ratio: Floats = np.sum(_ALL - others, axis=-1) / np.sum(_ALL - own, axis=-1)
            return ratio
        # statistic = exp(mean over runs of log(value / reference))
        logs = np.log(own) - (np.log(others) if self.kind == "ratio" else 0.0)
        statistic: Floats = np.exp(np.mean(logs, axis=-1))
        return statistic

    def _known(self, argument: str, values: Sequence[float]) -> Floats:
        numbers = as_float_array(argument, values)
        if numbers.ndim != 1 or not len(numbers):
            raise ValueError(
                f"{argument} must be the numbers of one or more runs, got shape {numbers.shape}"
            )
        return numbers

    def _clipped(self, numbers: Floats) -> Floats:
        known = np.where(np.isnan(numbers), self.worst, numbers)
        clipped: Floats = np.clip(known, self.floor, self.worst)
        return clipped


_ALL = 100.0  # %


def share_of_points(scores: Sequence[Score], fractions: Sequence[float]) -> list[float]:
    """Return each score's part of the points, 0..1, from the fractions of all."""
    pairs = [*zip(scores, fractions, strict=True)]
    kept = math.prod(fraction for score, fraction in pairs if score.kind == "lost")
    return [fraction if score.kind == "lost" else fraction * kept for score, fraction in pairs]


def scores_of(*rows: tuple[Any, ...]) -> tuple[Score, ...]:
    """Return scores from rows: name, title, unit, share, floor, worst, and an optional kind."""
    names = ("name", "title", "unit", "share", "floor", "worst", "kind")
    return tuple(Score(**dict(zip(names, row, strict=False))) for row in rows)


@dataclass(frozen=True, kw_only=True)
class ScoreLimit:
    """The limits of a score: the statistic for full points, and the statistic for no points.

    Parameters
    ----------
    full : float
        The largest statistic with full points.
    zero : float
        The statistic above which a score gives no points.
    low : float or None
        The smallest statistic with full points, for a score that can be too small; None = no limit.
    low_zero : float or None
        The statistic below which a score has no points; required with `low`.

    Raises
    ------
    TypeError, ValueError
        If a limit is not a number above 0, or only one of `low` and `low_zero` is given.

    Examples
    --------
    >>> limit = robsim.teach.ScoreLimit(full=1.5, zero=3.0)  # times the reference's score
    >>> limit.zero / limit.full
    2.0
    """

    full: float
    zero: float
    low: float | None = None
    low_zero: float | None = None

    def __post_init__(self) -> None:
        for name in ("full", "zero", "low", "low_zero"):
            if getattr(self, name) is not None or name in ("full", "zero"):
                check_float(name, getattr(self, name), exclusive_minimum=0)
        if (self.low is None) != (self.low_zero is None):
            raise ValueError("low and low_zero must be given together")

    def fraction(self, statistic: float) -> float:
        """Return the share of the points, 0 to 1, linear in log(statistic) between the limits.

        Parameters
        ----------
        statistic : float
            The result of `Score.statistic`.

        Raises
        ------
        TypeError, ValueError
            If the statistic is not a number above 0.
        """
        check_float("statistic", statistic, exclusive_minimum=0)
        share = _between(statistic, self.full, self.zero)
        if self.low is None or self.low_zero is None:
            return share
        return min(share, _between(1 / statistic, 1 / self.low, 1 / self.low_zero))


def _between(statistic: float, full: float, zero: float) -> float:
    # (log zero - log s) / (log zero - log full), within 0..1
    if statistic <= full:
        return 1.0
    if statistic >= zero or zero <= full:
        return 0.0
    return math.log(zero / statistic) / math.log(zero / full)
