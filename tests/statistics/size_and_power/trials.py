"""Trials of verdicts: runs of a campaign, their answers, and the rows that count them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy import special

import robsim


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


def one_each(numbers: Mapping[str, np.ndarray]) -> Mapping[str, np.ndarray]:
    """Return the numbers of the runs as the answers: each run is a trial."""
    return numbers


@dataclass(frozen=True, kw_only=True)
class Trials:
    """A campaign, and what is counted of it."""

    name: str  # within the family
    # What is promised, by the label of the case, "" if there is but one, and by answer.
    rows: Mapping[tuple[str, str], Row]
    # {answer: whether it was given} in a run, or what `answers` makes them of.
    metric: Callable[[robsim.Trace], Mapping[str, float]]
    # {answer: for each trial whether it was given} of the numbers of all runs of a case.
    answers: Callable[[Mapping[str, np.ndarray]], Mapping[str, np.ndarray]] = one_each
    scenario: robsim.Scenario = field(default_factory=robsim.Scenario)
    vary: Mapping[str, Any] = field(default_factory=dict)
    steps: int = 1  # of which nothing but the seed is used unless there are more
    runs: int = 1  # that make a trial
    share: float = 1.0  # of the trials that is made, since they are slow

    def counted(
        self, trials: int, *, seed: int = 0, executor: int | None = None, keep: Path | None = None
    ) -> list[Row]:
        """Run the campaign, and return the rows with what was counted."""
        result = robsim.campaign(
            self.scenario,
            vary=self.vary,
            metrics={"given": self.metric},
            runs=self.runs * max(1, round(self.share * trials)),
            steps=self.steps,
            seed=seed,
            executor=executor,
            store=keep,
            on_error="raise",
        )
        given = {}
        for case in result.spec.cases:
            of_case = result["case_id"] == case.index
            numbers = {
                name.removeprefix("given_"): result[name][of_case] for name in result.metrics
            }
            label = ", ".join(map(str, case.labels.values()))
            given |= {(label, name): one for name, one in self.answers(numbers).items()}
        return [row.counted(given[key]) for key, row in self.rows.items()]


def random_of(trace: robsim.Trace, *place: int) -> np.random.Generator:
    """Return random numbers of a run, others for each place."""
    seed = trace.info.seed  # that of the campaign, and the number of the run
    return np.random.default_rng([seed["entropy"], *seed["spawn_key"], *place])
