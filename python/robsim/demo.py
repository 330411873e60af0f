"""The demonstration run and what it writes."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from robsim import plotting
from robsim._core import DriveAround, Spin
from robsim.identification import BatchEstimate, batch_estimate
from robsim.simulation import Simulation
from robsim.trace import TrackingStatistics

#: Steps that the robot spins before it drives around.
SPIN_STEPS = 200


@dataclass(frozen=True, kw_only=True)
class DemoResult:
    """What the demonstration found.

    Attributes
    ----------
    report : BatchEstimate
        True values, batch and online estimates.
    tracking : TrackingStatistics
        How well vision followed the robot.
    files : tuple of Path
        The files written.
    """

    report: BatchEstimate
    tracking: TrackingStatistics
    files: tuple[Path, ...]

    def to_dict(self) -> dict[str, Any]:
        """Return the numbers: {"parameters": ..., "tracking": ...}."""
        return {"parameters": self.report.to_dict(), "tracking": asdict(self.tracking)}


def run_demo(
    out: Path, *, steps: int = 1000, seed: int = 2008, progress: bool = True
) -> DemoResult:
    """Let the robot spin, then drive around, track it, identify it, and write the figures.

    Parameters
    ----------
    out : Path
        Folder for the figures and the trace; made if there is none.
    steps : int
        Number of steps, more than 200: the robot spins for the first 200.
    seed : int
        Seed of the run.
    progress : bool
        Show a progress bar.
    """
    if steps <= SPIN_STEPS + 10:
        raise ValueError(f"steps must be above {SPIN_STEPS + 10}, got {steps}")
    out.mkdir(parents=True, exist_ok=True)
    simulation = Simulation(
        boundary="unlimited", measure=True, estimate_parameters=True, control=Spin(), seed=seed
    )
    simulation.run(SPIN_STEPS, progress=progress and "spin        ")
    simulation.control = DriveAround()
    trace = simulation.run(steps - SPIN_STEPS, progress=progress and "drive around")
    report = batch_estimate(trace)
    newest = simulation.newest
    axes = plotting.plot_frame(
        newest.frame,
        blobs=newest.blobs,
        measurement=newest.measurement,
        outline=simulation.robot.to_robot_frame(simulation.robot.outline),
    )
    figures = {
        "camera.png": axes.get_figure(root=True),
        "traces.png": plotting.plot_traces(trace),
        "parameters.png": plotting.plot_parameters(trace),
        "batch.png": plotting.plot_batch(report),
    }
    for name, figure in figures.items():
        assert figure is not None
        figure.savefig(out / name)
    trace.save(out / "trace.npz")
    files = tuple(out / name for name in (*figures, "trace.npz"))
    return DemoResult(report=report, tracking=trace.tracking(), files=files)
