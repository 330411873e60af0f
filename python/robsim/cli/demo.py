"""The command ``robsim demo``: a complete run with figures, to begin with."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from robsim.cli import errors
from robsim.cli.shared import Json

EXAMPLE = "Example: robsim demo"
HELP = (
    "Drive a robot, track it by camera and estimate its parameters.\n\n"
    "The robot spins, then drives around in an unlimited area. Vision tracks it, recursive least "
    "squares estimates its parameters online, a batch estimate follows at the end. Figures and the "
    "trace are written to a folder."
)


def demo(
    out: Annotated[
        Path, typer.Option("--out", help="Folder for the figures and the trace.")
    ] = Path("robsim-demo"),
    steps: Annotated[
        int, typer.Option("--steps", help="Number of steps; in the first 200 the robot spins.")
    ] = 1000,
    seed: Annotated[int, typer.Option("--seed", help="Seed of the run.")] = 2008,
    as_json: Json = False,
) -> None:
    """Drive a robot, track it by camera and estimate its parameters."""
    from robsim.cli.demo_run import run_demo

    with errors.report_errors():
        result = run_demo(out, steps=steps, seed=seed)
    if as_json:
        print(json.dumps(result.to_dict(), indent=2))
        return
    print(result)
    print(f"written to {out}: {', '.join(file.name for file in result.files)}")
