"""The command ``robsim demo``: a complete run with figures, as a first example."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

from robsim.cli import errors
from robsim.cli.shared import Json

if TYPE_CHECKING:
    from rich.table import Table

    from robsim.cli.results import Results
    from robsim.estimation.identification.batch import BatchEstimate
    from robsim.simulation import Simulation


_MINIMUM_STEPS = 50


def demo(
    out: Path = Path("robsim-demo"), steps: int = 1000, seed: int = 2008, as_json: Json = False
) -> None:
    """Drive a robot, track it by camera and estimate its parameters.

    The robot drives around, and a noisy camera measures its pose. From these measurements,
    recursive least squares estimates the parameters of its model online, and a batch fit estimates
    them at the end. The output compares both estimates with the true values. The command writes
    figures and the trace to a folder.

    --out FOLDER: Folder for the figures and the trace.
    --steps N: Number of steps, at least 50.
    --seed N: Seed of the run.

    Example: robsim demo
    """
    result = _run(out, steps, seed)
    if as_json:
        errors.show(json.dumps(result.to_dict(), indent=2))
        return
    if result.report is not None:
        _print_report(result.report)
    errors.show(result.tracking)
    errors.say(f"written to {out}: {', '.join(file.name for file in result.files)}")
    errors.say("the installation works")


def _run(out: Path, steps: int, seed: int) -> Results:
    """Write the figures of the run."""
    from robsim.cli.results import check_folder, write_results

    if steps < _MINIMUM_STEPS:
        raise ValueError(f"steps must be at least {_MINIMUM_STEPS}, got {steps}")
    check_folder(out)
    simulation = simulate_demo(steps, seed, progress="drive around")
    # From noisy poses least squares is biased, this method is not.
    return write_results(out, simulation, method="output_error")


def simulate_demo(steps: int = 1000, seed: int = 2008, progress: str | bool = False) -> Simulation:
    """Drive in view of a noisy camera, and estimate from its measurements."""
    from robsim._core import DriveAround
    from robsim.simulation import Simulation
    from robsim.vision.imaging.noise import GaussianNoise

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
    simulation.run(steps, progress=progress)
    return simulation


def _print_report(report: BatchEstimate) -> None:
    import numpy as np

    errors.print_table(_table(report))
    error = np.abs(report.batch - report.theta_true)
    near = np.count_nonzero(error <= 2 * report.standard_errors)
    method = report.method.replace("_", " ")
    errors.say("online: recursive least squares, biased because its regressors are noisy, too")
    errors.say(
        f"batch:  {method}, made for measurement noise: {near} of 15 within two standard errors of "
        "the truth"
    )


def _table(report: BatchEstimate) -> Table:
    from rich.box import SIMPLE_HEAD
    from rich.table import Table

    title = "The robot's parameters, estimated from camera measurements"
    table = Table(box=SIMPLE_HEAD, pad_edge=False, title=title, title_justify="left")
    table.add_column("")
    for name, color in (
        ("true", "magenta"),
        ("online", "blue"),
        ("off by", "blue"),
        ("batch", "yellow"),
        ("off by", "yellow"),
        ("std. error", "yellow"),
    ):
        table.add_column(name, justify="right", no_wrap=True, header_style=f"bold {color}")
    for name, value in report.to_dict()["parameters"].items():
        true, online, batch = value["true"], value["online"], value["batch"]
        table.add_row(
            name,
            _number(true),
            *(_number(online), _error(online, true, name)),
            *(_number(batch), _error(batch, true, name)),
            _share(value["standard_error"], true, name),
            end_section=name in ("d1X", "d1Y"),
        )
    return table


def _number(value: float | None) -> str:
    if value is None:
        return "-"
    return f"{value:.1e}" if 0 < abs(value) < 1e-3 else f"{value:.5g}"


def _error(value: float | None, true: float | None, name: str) -> str:
    return "-" if value is None or true is None else _share(abs(value - true), true, name)


def _share(size: float | None, true: float | None, name: str) -> str:
    """Return a size in percent of the true value; d1, which is almost 0, in its unit."""
    if size is None:
        return "-"
    if name.startswith("d1") or not true:
        return f"{size:.0e} {'rad' if name.endswith('P') else 'px'}"
    share = 100 * size / abs(true)
    return f"{share:.2g} %" if share < 99.5 else f"{share:.0f} %"
