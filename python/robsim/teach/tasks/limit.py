"""`Limit`: up to where a score has all points, and where it has none."""

from __future__ import annotations

import math
from dataclasses import dataclass

from robsim.base.checks import check_float


@dataclass(frozen=True, kw_only=True)
class Limit:
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
