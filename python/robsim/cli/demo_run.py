"""The run of ``robsim demo``: drive around, measure, estimate from the measurements."""

from __future__ import annotations

from pathlib import Path

from robsim._core import DriveAround
from robsim.cli.results import Results, check_folder, write_results
from robsim.imaging import GaussianNoise
from robsim.simulation._simulation import Simulation

_MINIMUM_STEPS = 50

#: The batch method: from noisy poses least squares is biased, this one is not.
METHOD = "output_error"


def simulate_demo(*, steps: int = 1000, seed: int = 2008, progress: bool = False) -> Simulation:
    """Drive through a noisy camera's view and estimate the parameters from what it measures.

    Parameters
    ----------
    steps : int
        Number of steps, at least 50.
    seed : int
        Seed of the run.
    progress : bool
        Show a progress bar.

    Returns
    -------
    Simulation
        The simulation after the run.

    Raises
    ------
    ValueError
        If `steps` is less than 50.
    """
    if steps < _MINIMUM_STEPS:
        raise ValueError(f"steps must be at least {_MINIMUM_STEPS}, got {steps}")
    simulation = Simulation(
        control=DriveAround(),
        resolution=(600, 600),
        noise=GaussianNoise(10),
        headings=None,
        measure=True,
        identify_from="measurement",
        estimate_parameters=True,
        seed=seed,
    )
    simulation.run(steps, progress=progress and "drive around")
    return simulation


def run_demo(out: Path, *, steps: int = 1000, seed: int = 2008, progress: bool = True) -> Results:
    """Run the demo and write its figures.

    Parameters
    ----------
    out : Path
        Folder for the figures and the trace; created if needed.
    steps, seed, progress
        As of `simulate_demo`.

    Returns
    -------
    Results
        The estimates, the tracking statistics and the files written.

    Raises
    ------
    ValueError
        If `steps` is less than 50.
    """
    check_folder(out)
    simulation = simulate_demo(steps=steps, seed=seed, progress=progress)
    return write_results(out, simulation, method=METHOD)
