"""The run of ``robsim demo``: spin, drive around, track, estimate, write the figures."""

from __future__ import annotations

from pathlib import Path

from robsim._core import DriveAround, Spin
from robsim.cli.results import Results, check_folder, write_results
from robsim.simulation._simulation import Simulation

#: Number of steps that the robot spins before it drives around.
SPIN_STEPS = 200


def run_demo(out: Path, *, steps: int = 1000, seed: int = 2008, progress: bool = True) -> Results:
    """Spin, drive, track, and estimate the model's parameters; write the figures.

    Parameters
    ----------
    out : Path
        Folder for the figures and the trace; created if needed.
    steps : int
        Number of steps, more than 200: the robot spins for the first 200.
    seed : int
        Seed of the run.
    progress : bool
        Show a progress bar.

    Returns
    -------
    Results
        The estimates, the tracking statistics and the files written.

    Raises
    ------
    ValueError
        If `steps` is 210 or less.
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
