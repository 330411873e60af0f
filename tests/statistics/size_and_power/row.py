"""One line of the table: how often a verdict was given, and how often it should be."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike
from scipy import special


@dataclass(frozen=True)
class Row:
    """How often one answer to a record was given where the hypothesis is true, and should be."""

    verdict: str  # that is tested: "NEES"
    hypothesis: str  # what is true: "right", or which fault, and how large
    record: str  # the data of one trial: "20 runs of 100 steps"
    answer: str  # that is counted: "rejected"
    promised: tuple[float, float]  # rates, from and to
    trials: int = 0
    hits: int = 0

    @property
    def key(self) -> tuple[str, str, str, str]:
        """What the row is about."""
        return self.verdict, self.hypothesis, self.record, self.answer

    @property
    def rate(self) -> float:
        """Fraction of the trials with this answer."""
        return self.hits / self.trials

    @property
    def interval(self) -> tuple[float, float]:
        """The 95 % interval of the rate: Clopper and Pearson, Biometrika 26(4), 1934."""
        hits, misses = self.hits, self.trials - self.hits
        low = special.betaincinv(hits, misses + 1, 0.025) if hits else 0.0
        high = special.betaincinv(hits + 1, misses, 0.975) if misses else 1.0
        return float(low), float(high)

    @property
    def holds(self) -> bool:
        """Whether the interval meets the rates that are promised."""
        low, high = self.interval
        return low <= self.promised[1] and high >= self.promised[0]

    @property
    def p_value(self) -> float:
        """Probability of a rate as far outside the promise if the promise were true."""
        low, high = self.promised
        if self.rate > high:
            return float(special.bdtrc(self.hits - 1, self.trials, high))
        if self.rate < low:
            return float(special.bdtr(self.hits, self.trials, low))
        return 1.0

    def counted(self, answers: ArrayLike) -> Row:
        """Return the row with the answers of the trials: whether this one was given."""
        given = np.asarray(answers, bool)
        return replace(self, trials=given.size, hits=int(given.sum()))
