"""The runs of a submission as those of a campaign."""

from __future__ import annotations

import pickle
from dataclasses import dataclass

import numpy as np

from robsim.base.checks import check_int
from robsim.base.seeds import Seed
from robsim.base.source_line import SourceLine
from robsim.campaigns.choices import WholeRun
from robsim.simulation import FailedCallback, Scenario
from robsim.teach.errors import SubmissionError
from robsim.teach.grading.graded_run import graded_run
from robsim.teach.grading.keys import Key, RunSeeds
from robsim.teach.grading.task import Task
from robsim.trace import Trace


@dataclass(frozen=True)
class GradedRuns(WholeRun):
    """Graded runs as those of a campaign."""

    task: Task
    key: Key | None
    student: str
    test: str

    def trace(
        self, scenario: Scenario, steps: int, *, seed: np.random.SeedSequence, run: int
    ) -> Trace:
        given = seed if self.key is None else None
        seeds = seeds_of(self.key, self.student, self.test, run, steps, given)
        try:
            return graded_run(self.task, scenario, steps, seeds).result
        except SubmissionError as error:  # a row has the line of a callback
            if error.slot is not None and error.file is not None:
                line = SourceLine(error.file, error.line or 1, "")
                error.callback = FailedCallback(error.slot, error.step, line)
            raise

    @property
    def content(self) -> bytes:
        rules, files = self.task.rules.to_dict(), self.task.submission.to_message()
        return pickle.dumps((rules, self.task.frames, self.student, self.test)) + files


def seeds_of(
    key: Key | None, student: str, test: str, run: int, steps: int, seed: Seed
) -> RunSeeds:
    """Return those that are given; else those of the key, or of a new one."""
    if seed is not None:
        return RunSeeds.of(seed)
    check_int("number", run, minimum=0, maximum=2**62)
    return RunSeeds.of_key(key or Key.new(), student, test, run, steps)
