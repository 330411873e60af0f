"""The table of what graded runs cost."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from robsim.base.report import Column, Quantity, Report, Row, Table


@dataclass(frozen=True, kw_only=True)
class GradingBench(Report):
    """What graded runs cost on this machine.

    Attributes
    ----------
    steps : dict of str to (float, float)
        For each kind of runs the time of a step (s): with all in one process, and with the robot
        half in a worker.
    start : float
        Time until a worker has loaded a submission, done one step and is gone (s).
    isolation : str
        What shut the workers in.
    """

    steps: Mapping[str, tuple[float, float]]
    start: float
    isolation: str

    @property
    def title(self) -> str:
        """What was measured."""
        return "Graded runs: the robot half in a worker, beside all in one process"

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """What a run costs beside its steps."""
        return (Quantity("start", "a run of one step", 1e3 * self.start, "ms", ".0f"),)

    @property
    def tables(self) -> tuple[Table, ...]:
        """The times of a step."""
        columns = (
            Column("here", "one process", "ms", ".3f"),
            Column("worker", "worker", "ms", ".3f"),
            Column("ratio", "x", "", ".2f"),
            Column("more", "more", "ms", ".3f"),
        )
        rows = [
            Row(kind, [1e3 * here, 1e3 * there, there / here, 1e3 * (there - here)])
            for kind, (here, there) in self.steps.items()
        ]
        return (Table(key="steps", columns=columns, rows=rows, row_title="a step"),)

    @property
    def remarks(self) -> tuple[str, ...]:
        """How to read the table."""
        return (
            "1200, 480: the submission measures in frames of so many px squared, with Gaussian "
            "noise of 10 % or none; poses: it estimates the state of a robot that is measured here "
            "in noisy frames of 480 px; inputs: it controls one that nobody looks at",
            self.isolation,
        )
