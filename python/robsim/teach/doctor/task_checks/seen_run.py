"""The worst run of a trial next to the reference, and problems in it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robsim.base.check_report import Problem
from robsim.base.checks import Floats
from robsim.teach.tasks.definition import Task
from robsim.teach.tasks.solutions import Solution
from robsim.teach.tasks.trial import TaskTrial
from robsim.trace import Trace


@dataclass(frozen=True)
class SeenRun:
    """The worst run of a trial."""

    trial: TaskTrial
    solution: Solution
    trace: Trace
    reference: Trace  # the same run of the reference

    @property
    def task(self) -> Task:
        return self.trial.task

    @classmethod
    def of(cls, trial: TaskTrial, solution: Solution) -> SeenRun | None:
        """Return the worst run of a trial; None if all have failed."""
        if trial.worst is None or trial.trace is None or trial.reference_trace is None:
            return None
        return cls(trial, solution, trial.trace, trial.reference_trace)

    def problem(self, kind: str, sentence: str, k: int | None = None) -> Problem:
        situation = f"run {self.trial.worst} of the task"
        return Problem(kind=kind, sentence=sentence, situation=situation, k=k)

    def tolerance(self, name: str, default: float) -> float:
        return float(self.task.values.get(name, default))


def rms(values: Floats) -> float:
    """Return the root mean square of the finite values; NaN = no finite value."""
    known = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(known**2))) if len(known) else float("nan")
