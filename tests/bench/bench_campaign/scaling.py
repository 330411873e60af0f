"""What many workers would give, on paper: tables of simulated campaigns."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from bench_campaign.dask_tasks import TaskCost
from bench_campaign.many_workers import EACH, Throughput, simulated
from bench_campaign.parent import ParentCost
from robsim.base.report import Column, Quantity, Row, Table, percent
from robsim.base.report.table import Format
from robsim.campaigns.engines.campaign_work import size_for

_WORKERS = (1, 10, 100, 1000)
_MOST = max(_WORKERS)
_CHUNKS = (1, 3, 10, 30, 100)
_SECONDS = 1.0  # of a run, in the tables by the number of workers
_DURATIONS = (0.001, 0.01, 0.1, 1.0, 10.0)  # s of a run
_LARGEST = 10_000  # runs of a chunk
_SHARE = 0.1  # of its time that the calling process may be busy


@dataclass(frozen=True, kw_only=True)
class Scaling:
    """What many workers would give.

    Attributes
    ----------
    parent : ParentCost
        What the calling process takes itself.
    task : TaskCost
        What the scheduler takes for a chunk, and its client in the calling process.
    by_workers : dict of int to dict of int to Throughput
        What so many workers give with chunks of so many runs of a second.
    by_duration : dict of float to Throughput
        What 1000 workers give with runs of a duration (s), in the chunks that a campaign makes.
    """

    parent: ParentCost
    task: TaskCost
    by_workers: Mapping[int, Mapping[int, Throughput]]
    by_duration: Mapping[float, Throughput]

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """The costs that were measured."""
        parent, task = self.parent, self.task
        costs = {
            "parent_submit": ("calling process, to hand a chunk over", parent.submit, ".0f"),
            "parent_receive": (
                "calling process, to take it back and store it",
                parent.receive,
                ".0f",
            ),
            "parent_row": ("calling process, a row", parent.row, ".1f"),
            "parent_flying": ("calling process, a chunk in flight", parent.flying, ".2f"),
            "task_client": ("Dask's client, a task", task.client, ".0f"),
            "task_scheduler": ("Dask's scheduler, a task", task.scheduler, ".0f"),
        }
        return tuple(
            Quantity(key, name, 1e6 * seconds, "us", format)
            for key, (name, seconds, format) in costs.items()
        )

    @property
    def tables(self) -> tuple[Table, ...]:
        """By the number of workers: the rate, what is busy; and by the duration of a run."""
        return (
            self._workers_table("rate", "runs/s, by workers", ".0f"),
            self._workers_table("parent", "process busy, by workers", percent),
            self._workers_table("scheduler", "scheduler busy, by workers", percent),
            self._durations_table,
        )

    def _workers_table(self, field: str, title: str, format: Format) -> Table:
        columns = [Column(f"chunk_{n}", f"chunk {n}", "", format) for n in _CHUNKS]
        rows = [
            Row(str(workers), [getattr(by_chunk[n], field) for n in _CHUNKS])
            for workers, by_chunk in self.by_workers.items()
        ]
        return Table(key=f"workers_{field}", columns=columns, rows=rows, row_title=title)

    @property
    def _durations_table(self) -> Table:
        columns = (
            Column("chunk", "chunk", "", ".0f"),
            Column("rate", "runs", "1/s", ".0f"),
            Column("workers", "busy", "", percent),
            Column("most", "at most", "", ".0f"),
            Column("parent", "process", "", percent),
            Column("chunk_needed", "chunk for 10 %", "", ".0f", missing="none"),
        )
        rows = []
        for seconds, found in self.by_duration.items():
            most, needed = self._most_workers(seconds), self.chunk_needed(seconds)
            cells = [size_for(seconds), found.rate, found.workers, most, found.parent, needed]
            rows.append(Row(f"{seconds:g}_s", cells))
        return Table(key="durations", columns=columns, rows=rows, row_title=f"run, {_MOST} workers")

    def _each(self) -> float:
        """Return what the calling process takes for a chunk (s), however many are in flight."""
        return self.parent.submit + self.task.client + self.parent.receive

    def _most_workers(self, seconds: float) -> int:
        """Return how many workers the calling process and the scheduler can keep busy."""
        chunk = size_for(seconds)
        slowest = max(self._each() + chunk * self.parent.row, self.task.scheduler)
        return max(int(chunk * seconds / slowest), 1)

    def chunk_needed(self, seconds: float) -> int | None:
        """Return the runs of a chunk with which 1000 workers leave the calling process 90 %.

        None where rows alone are too much for it, or nearly so.
        """
        each = self._each() + EACH * _MOST * self.parent.flying
        # W / seconds (row + each / n) = share
        left = _SHARE * seconds / _MOST - self.parent.row
        if left * _LARGEST < each:
            return None
        return max(1, math.ceil(each / left))

    @property
    def answer(self) -> str:
        """What 1000 workers give, and what they need."""
        by_chunk = self.by_workers[_MOST]
        least, most = by_chunk[_CHUNKS[0]].rate, by_chunk[_CHUNKS[-1]].rate
        shortest = _MOST * self.parent.row / _SHARE
        return (
            f"on paper: {_MOST} workers with runs of {_SECONDS:g} s give {least:.0f} runs a second "
            f"in chunks of one and {most:.0f} in chunks of {_CHUNKS[-1]}; chunks of "
            f"{self.chunk_needed(_SECONDS)} keep the calling process busy for less than 10 %, "
            f"which no chunks do with runs shorter than {shortest:.2g} s"
        )


def scaling_of(parent: ParentCost, task: TaskCost) -> Scaling:
    """Simulate campaigns with many workers."""
    whole = parent._replace(submit=parent.submit + task.client)

    def found(workers: int, chunk: int, seconds: float) -> Throughput:
        return simulated(whole, task.scheduler, workers=workers, chunk=chunk, seconds=seconds)

    return Scaling(
        parent=parent,
        task=task,
        by_workers={w: {n: found(w, n, _SECONDS) for n in _CHUNKS} for w in _WORKERS},
        by_duration={each: found(_MOST, size_for(each), each) for each in _DURATIONS},
    )
