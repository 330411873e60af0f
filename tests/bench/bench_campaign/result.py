"""The table of what campaigns cost."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from bench_campaign.scaling import Scaling
from robsim.base.report import Column, Quantity, Report, Row, Table


@dataclass(frozen=True, kw_only=True)
class CampaignBench(Report):
    """What campaigns cost on this machine.

    Attributes
    ----------
    serial : dict of str to (float, float)
        For each kind of runs the processor times of one (s): in a bare loop, and in a campaign.
    parallel : dict of str to float
        Runs a second of two processes, by who begins them; the first is that of a campaign.
    growing : dict of int to float
        Processor time of a run (s) in a campaign of so many runs, with a store.
    memory : float or None
        What the memory grew by in the longest of them (MB); None where it cannot be read.
    scaling : Scaling
        What many workers would give, simulated from the costs of a chunk of runs.
    left_out : tuple of str
        What could not be measured, and why.
    """

    serial: Mapping[str, tuple[float, float]]
    parallel: Mapping[str, float]
    growing: Mapping[int, float]
    memory: float | None
    scaling: Scaling
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
        return *grown, *self.scaling.quantities

    @property
    def tables(self) -> tuple[Table, ...]:
        """In one process, in two, by the number of runs, and on paper in many."""
        measured = self._serial_table, self._parallel_table, self._growing_table
        return *measured, *self.scaling.tables

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
    def remarks(self) -> tuple[str, ...]:
        """How to read the tables."""
        return (
            "no_frames: a metric of one number; frames_240: frames of 240 x 240 px with noise, "
            "detected, and the metric tracking",
            "one process, and by the number of runs: processor time; two processes: the shortest "
            "time of runs of frames_240, with the beginning of the processes",
            "costs: processor time of a campaign whose runs are done by nobody, and of empty tasks "
            "of Dask, whose scheduler is a process of its own",
            "tables by workers: runs of 1 s in chunks of 1 to 100, simulated from these costs; two "
            "chunks for each worker are in flight, the durations of runs scatter by 50 %",
            "busy: workers; process: the calling process is busy; at most: so many workers can it "
            "and the scheduler keep busy",
            self.scaling.answer,
            *self.left_out,
        )
