"""What a panel painted in some seconds, beside what matplotlib would take."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from robsim._base.report import Column, Quantity, Report, Row, Table


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
    matplotlib : float
        Time to draw camera view and traces anew with matplotlib (ms).
    """

    hosts: tuple[Painted, ...]
    matplotlib: float

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


def painted(
    host: str,
    seen: Sequence[tuple[int, float]],
    done: Mapping[int, float],
    span: float,
    busy: float,
) -> Painted:
    """Return the figures of a host.

    Parameters
    ----------
    host : str
        Its name.
    seen : sequence of (int, float)
        Step and the time at which it was first on the screen (ms).
    done : mapping
        Step -> the time at which it was done (ms).
    span : float
        How long was looked (s).
    busy : float
        Processor time of the Python process (s).
    """
    known = [(k, at) for k, at in seen if k in done]
    if len(known) < 2:
        raise RuntimeError(f"the {host} painted no frames that could be read back")
    latencies = [at - done[k] for k, at in known]
    median, late = np.percentile(latencies, (50, 95))
    return Painted(
        host=host,
        rate=len(known) / span,
        latency_median=float(median),
        latency_p95=float(late),
        busy=100 * busy / span,
    )
