"""`TaskReport`: whether callback files solve a task, and the reasons of missing points."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from robsim.base.check_report import Problem
from robsim.base.report import Quantity, percent
from robsim.teach.doctor.callbacks.folder import FolderReport

if TYPE_CHECKING:  # the grader's doctor has no tasks
    from robsim.teach.tasks.definition import Task
    from robsim.teach.tasks.trial import TaskTrial

#: The kind of the problem of a solution that the grader refuses.
REFUSED = "not handed in"


@dataclass(frozen=True, kw_only=True)
class TaskReport(FolderReport):
    """The result of a check of callback files for a task.

    `problems` has the problems of the files, and then the findings of the task's runs.

    Attributes
    ----------
    task : Task
        The task.
    trial : TaskTrial or None
        The outcome of the runs; None = not tried.
    findings : tuple of Problem
        The findings of the runs, the likeliest cause first.

    Examples
    --------
    >>> import pathlib
    >>> pathlib.Path("mine").mkdir()
    >>> size = pathlib.Path("mine/control.py").write_text("def control(step): return 0, 0")
    >>> robsim.teach.check_folder("mine", task="park").trial.is_solved
    False
    """

    task: Task
    trial: TaskTrial | None
    findings: tuple[Problem, ...] = ()

    @property
    def ok(self) -> bool:
        """Whether the files solve the task without any problem."""
        return self.is_solved and not self.problems

    @property
    def is_solved(self) -> bool:
        """Whether the files get full points for the task."""
        return self.trial is not None and self.trial.is_solved

    @property
    def headline(self) -> str:
        """The verdict in one line."""
        task = f"the task {self.task.name}"
        if self.trial is None:
            refused = (one.sentence for one in self.problems if one.kind == REFUSED)
            return f"{self.name} was not tried on {task}: {next(refused, 'it cannot be loaded')}"
        if self.is_solved:
            ill = f"; {super().headline}" if self.problems else ""
            return f"{self.name} solves {task}: {self.trial.verdict}{ill}"
        points = "" if not self.trial.limits else f", {percent(self.trial.points)} of the points"
        return f"{self.name} does not solve {task}: {self.trial.verdict or 'no limits'}{points}"

    @property
    def not_used(self) -> tuple[str, ...]:
        """The slots that have a file but are not used by the task."""
        return tuple(slot for slot, check in self.checks.items() if check == "not used")

    @property
    def quantities(self) -> Sequence[Quantity]:
        """Points, runs, and the number of failed runs."""
        return () if self.trial is None else self.trial.quantities

    @property
    def title(self) -> str:
        """The name of the files and the task."""
        return f"Check of {self.name} for the task {self.task.name}"

    @property
    def short(self) -> dict[str, str]:
        """A sentence for each score below full points, by name: the distance to full points."""
        return {} if self.trial is None else dict(_short(self.trial))


def _short(trial: TaskTrial) -> Iterator[tuple[str, str]]:
    for score in trial.task.scores:
        limit, statistic = trial.limits.get(score.name), trial.statistics[score.name]
        if limit is None or not statistic > 0 or limit.fraction(statistic) >= 1:
            continue
        of = {
            "ratio": " times the reference",
            "consistency": "",
            "lost": " times as many right ones in the reference",
        }[score.kind]
        is_low = limit.low is not None and statistic < limit.low
        full = f"from {limit.low:.3g} on" if is_low else f"up to {limit.full:.3g}"
        share = percent(limit.fraction(statistic))
        yield (
            score.name,
            f"{score.title}: {statistic:.3g}{of}, all points {full}; this gives {share} of them",
        )
