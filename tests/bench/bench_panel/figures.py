"""What a panel painted in some seconds, beside what matplotlib would take."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from robsim.base.report import Column, Quantity, Report, Row, Table


@dataclass(frozen=True, kw_only=True)
class Watched:
    """What was seen on the screen, by the browser's clock.

    Attributes
    ----------
    seen : list of (int, float)
        Step, and when it was first seen (ms).
    began, ended : float
        From when to when somebody looked (ms).
    """

    seen: list[tuple[int, float]]
    began: float
    ended: float


@dataclass(frozen=True, kw_only=True)
class Painted:
    """What a browser painted of a panel in one host.

    Attributes
    ----------
    host : str
        ``"page"`` or ``"JupyterLab"``.
    rate : float
        Different frames that were painted (1/s).
    latency_median, latency_p95 : float
        From the end of a step to its frame being seen on the screen (ms).
    busy : float
        Processor time of the Python process, for all it does, in % of one core.
    """

    host: str
    rate: float
    latency_median: float
    latency_p95: float
    busy: float

    @property
    def per_frame(self) -> float:
        """Processor time of the Python process for each frame that was painted (ms)."""
        return 10 * self.busy / self.rate


@dataclass(frozen=True, kw_only=True)
class PanelBench(Report):
    """How fast the panel is on this machine.

    Attributes
    ----------
    hosts : tuple of Painted
        What was painted.
    lacks_lab : bool
        Whether there was no JupyterLab to measure.
    matplotlib : float
        Time to draw camera view and traces anew with matplotlib (ms).
    """

    hosts: tuple[Painted, ...]
    matplotlib: float
    lacks_lab: bool = False

    @property
    def title(self) -> str:
        """What was measured."""
        return "Panel: 1200 x 1200 frames, 30 steps/s, shown at 600 x 600"

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """The alternative."""
        label = "camera view and traces drawn by matplotlib"
        return (Quantity("matplotlib", label, self.matplotlib, "ms", ".0f"),)

    @property
    def tables(self) -> tuple[Table, ...]:
        """A row for each host."""
        columns = (
            Column("rate", "painted", "1/s", ".1f"),
            Column("latency_median", "step to paint", "ms", ".0f"),
            Column("latency_p95", "95 %", "ms", ".0f"),
            Column("busy", "Python", "%", ".0f"),
            Column("per_frame", "per frame", "ms", ".1f"),
            Column("ratio", "matplotlib/this", format=".1f"),
        )
        rows = [
            Row(
                host.host,
                (
                    *(host.rate, host.latency_median, host.latency_p95, host.busy),
                    *(host.per_frame, self.matplotlib / host.per_frame),
                ),
            )
            for host in self.hosts
        ]
        return (Table(key="hosts", columns=columns, rows=rows),)

    @property
    def remarks(self) -> tuple[str, ...]:
        """What is left out."""
        if not self.lacks_lab:
            return ()
        return ("JupyterLab is left out: pip install jupyterlab anywidget, to measure it too.",)


def painted(host: str, watched: Watched, steps: Mapping[int, tuple[float, float]]) -> Painted:
    """Return the figures of a host.

    Parameters
    ----------
    host : str
        Its name.
    watched : Watched
        What was seen of it.
    steps : mapping
        Step -> when it was done (ms), and the processor time of the Python process by then (s).
    """
    known = [(k, at) for k, at in watched.seen if k in steps]
    within = [done for done in steps.values() if watched.began <= done[0] <= watched.ended]
    if min(len(known), len(within)) < 2:
        raise RuntimeError(f"the {host} painted no frames that could be read back")
    (first, busy_by_then), (last, busy_by_now) = within[0], within[-1]
    latencies = [at - steps[k][0] for k, at in known]
    median, late = np.percentile(latencies, (50, 95))
    return Painted(
        host=host,
        rate=1000 * len(known) / (watched.ended - watched.began),
        latency_median=float(median),
        latency_p95=float(late),
        busy=100_000 * (busy_by_now - busy_by_then) / (last - first),
    )
