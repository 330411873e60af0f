"""The table of what campaigns cost."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from robsim._base.report import Column, Quantity, Report, Row, Table, percent
from robsim.campaigns._engines.chunks import size_for

WORKERS = 1000
_DURATIONS = (0.001, 0.01, 0.1, 1.0, 10.0)  # s of a run
_SHARE = 0.1  # of its time that the parent may be busy


@dataclass(frozen=True, kw_only=True)
class CampaignBench(Report):
    """What campaigns cost on this machine.

    Attributes
    ----------
    serial : dict of str to (float, float)
        For each kind of runs the times of one (s): in a bare loop, and in a campaign.
    parallel : dict of str to float
        Runs a second of two processes, by who begins them; the first is that of a campaign.
    growing : dict of int to float
        Time of a run (s) in a campaign of so many runs.
    memory : float or None
        What the memory grew by in the longest of them (MB); None where it cannot be read.
    row, chunk : float
        Processor time that the calling process takes for a row, and for a chunk of runs (s).
    left_out : tuple of str
        What could not be measured, and why.
    """

    serial: Mapping[str, tuple[float, float]]
    parallel: Mapping[str, float]
    growing: Mapping[int, float]
    memory: float | None
    row: float
    chunk: float
    left_out: tuple[str, ...] = ()

    @property
    def title(self) -> str:
        """What was measured."""
        return "Campaigns of runs of 100 steps, beside the same loops by hand"

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """Memory, and what the calling process takes."""
        known = () if self.memory is None else (self.memory,)
        grown = (
            Quantity("memory", f"memory over {max(self.growing)} runs", value, "MB", ".1f")
            for value in known
        )
        return (
            *grown,
            Quantity("parent_row", "calling process, a row", 1e6 * self.row, "us", ".1f"),
            Quantity("parent_chunk", "calling process, a chunk", 1e6 * self.chunk, "us", ".0f"),
        )

    @property
    def tables(self) -> tuple[Table, ...]:
        """In one process, in two, by the number of runs, and on paper in many."""
        return self._serial_table, self._parallel_table, self._growing_table, self._workers_table

    @property
    def _serial_table(self) -> Table:
        columns = (
            Column("bare", "bare loop", "ms", ".3f"),
            Column("campaign", "campaign", "ms", ".3f"),
            Column("ratio", "x", "", ".2f"),
            Column("more", "more", "ms", ".3f"),
        )
        rows = [
            Row(kind, [1e3 * bare, 1e3 * ours, ours / bare, 1e3 * (ours - bare)])
            for kind, (bare, ours) in self.serial.items()
        ]
        return Table(key="serial", columns=columns, rows=rows, row_title="a run, one process")

    @property
    def _parallel_table(self) -> Table:
        columns = (
            Column("runs_per_second", "runs", "1/s", ".0f"),
            Column("ratio", "campaign / this", "", ".2f"),
        )
        ours = next(iter(self.parallel.values()))
        rows = [Row(name, [rate, ours / rate]) for name, rate in self.parallel.items()]
        return Table(key="parallel", columns=columns, rows=rows, row_title="two processes")

    @property
    def _growing_table(self) -> Table:
        first = next(iter(self.growing.values()))
        columns = (Column("time", "a run", "ms", ".3f"), Column("ratio", "x", "", ".2f"))
        rows = [Row(str(n), [1e3 * each, each / first]) for n, each in self.growing.items()]
        return Table(key="growing", columns=columns, rows=rows, row_title="runs, with a store")

    @property
    def _workers_table(self) -> Table:
        columns = (
            Column("chunk", "chunk", "", ".0f"),
            Column("busy", "workers busy", "", ".0f"),
            Column("parent", "parent busy", "", percent),
            Column("chunk_needed", "chunk for 10 %", "", ".0f", missing="none"),
        )
        rows = [Row(f"{seconds:g}_s", self._on_paper(seconds)) for seconds in _DURATIONS]
        return Table(key="workers", columns=columns, rows=rows, row_title="run, 1000 workers")

    def _on_paper(self, seconds: float) -> list[float | None]:
        """Return what so many workers would give with runs of this duration."""
        chunk = size_for(seconds)
        each = self.row + self.chunk / chunk  # s of the parent for a run
        # W workers bring W / seconds rows a second.
        demand = WORKERS * each / seconds
        busy = WORKERS / max(demand, 1.0)
        # W / seconds (row + chunk / n) = share
        left = _SHARE * seconds / WORKERS - self.row
        needed = max(1, math.ceil(self.chunk / left)) if left > 0 else None
        return [chunk, busy, min(demand, 1.0), needed]

    @property
    def remarks(self) -> tuple[str, ...]:
        """How to read the tables."""
        shortest = WORKERS * self.row / _SHARE
        return (
            "no_frames: a metric of one number; frames_240: frames of 240 x 240 px with noise, "
            "detected, and the metric tracking",
            "two processes: runs of frames_240, with the time to begin the processes",
            f"1000 workers: on paper, from the calling process' time for a row and a chunk, with "
            f"an executor that takes none itself; runs shorter than {shortest:.2g} s keep the "
            "calling process busy for more than 10 % with chunks of any size",
            *self.left_out,
        )
