"""Trials of verdicts: the runs of a campaign, whose metric says which answers were given."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

import robsim
from size_and_power.row import Row


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
