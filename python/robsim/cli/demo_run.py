"""The demonstration run."""

from __future__ import annotations

from pathlib import Path

from robsim._core import DriveAround, Spin
from robsim.cli.results import Results, check_folder, write_results
from robsim.simulation._simulation import Simulation

#: Steps that the robot spins before it drives around.
SPIN_STEPS = 200


def run_demo(out: Path, *, steps: int = 1000, seed: int = 2008, progress: bool = True) -> Results:
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
    check_folder(out)
    simulation = Simulation(
        boundary="unlimited", measure=True, estimate_parameters=True, control=Spin(), seed=seed
    )
    simulation.run(SPIN_STEPS, progress=progress and "spin        ")
    simulation.control = DriveAround()
    simulation.run(steps - SPIN_STEPS, progress=progress and "drive around")
    return write_results(out, simulation)
