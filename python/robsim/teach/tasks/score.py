"""`Score`: a number that a run of a task is scored by, and how those of several runs make one."""

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

KINDS = ("ratio", "consistency")


@dataclass(frozen=True, kw_only=True)
class Score:
    """A number that each run of a task has, and what it is.

    Parameters
    ----------
    name : str
        Its name, as in the numbers that `Task.score` returns.
    title : str
        What it is, for people.
    unit : str
        Its unit; "" = none.
    kind : {"ratio", "consistency"}
        How runs are put together; see `statistic`.
    share : float
        Its share of the points of a test; those of a task sum to 1.
    floor, worst : float
        What is better than `floor` counts as `floor`; what is worse than `worst`, or not a number,
        as `worst`.

    Raises
    ------
    TypeError, ValueError
        If an argument has the wrong type or is out of range; the message names it.
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

    def statistic(self, values: Sequence[float], reference: Sequence[float]) -> float:
        """Return what the numbers of some runs come to, relative to those of a reference.

        Parameters
        ----------
        values, reference : sequence of float, (M,)
            The numbers of a submission and of the reference, of the same runs in the same order.

        Returns
        -------
        float
            With kind ``"ratio"`` the geometric mean of value over reference: 1 is as good, 2 twice
            as bad. With ``"consistency"`` that of the values alone, which should be 1.

        Raises
        ------
        TypeError, ValueError
            If these are no numbers, none at all, or not equally many.

        Notes
        -----
        A geometric mean, since a single run in which a robot is lost, of which there are some with
        any method, outweighs in a mean of squares all others together.
        """
        # statistic = exp(mean over runs of log(value / reference))
        logs = self._logs("values", values)
        reference_logs = self._logs("reference", reference)
        if len(logs) != len(reference_logs):
            raise ValueError(
                f"values and reference must be of the same runs, got {len(logs)} and "
                f"{len(reference_logs)}"
            )
        if self.kind == "ratio":
            logs = logs - reference_logs
        return math.exp(float(np.mean(logs)))

    def _logs(self, argument: str, values: Sequence[float]) -> Floats:
        numbers = as_float_array(argument, values)
        if numbers.ndim != 1 or not len(numbers):
            raise ValueError(
                f"{argument} must be the numbers of one or more runs, got shape {numbers.shape}"
            )
        known = np.where(np.isnan(numbers), self.worst, numbers)
        logs: Floats = np.log(np.clip(known, self.floor, self.worst))
        return logs


def scores_of(*rows: tuple[Any, ...]) -> tuple[Score, ...]:
    """Return scores of rows: name, title, unit, share, floor, worst, and maybe their kind."""
    names = ("name", "title", "unit", "share", "floor", "worst", "kind")
    return tuple(Score(**dict(zip(names, row, strict=False))) for row in rows)


@dataclass(frozen=True, kw_only=True)
class ScoreLimit:
    """Up to where the statistic of a score has full points, and from where on none.

    Parameters
    ----------
    full : float
        The largest statistic with full points.
    zero : float
        The statistic from which on there are none: that of a naive solution.
    low : float or None
        The smallest statistic with full points, for what can be too small; None = none is.
    low_zero : float or None
        The statistic down from which there are none; given with `low`.

    Raises
    ------
    TypeError, ValueError
        If one is not a number above 0, or `low` and `low_zero` are not given together.
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
        """Return the share of the points, 0 to 1: linear in the logarithm between the limits.

        Parameters
        ----------
        statistic : float
            As of `Score.statistic`.

        Raises
        ------
        TypeError, ValueError
            If it is not a number above 0.
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
