"""The command line."""

from __future__ import annotations

import json
from importlib.metadata import version
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

app = typer.Typer(
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode="rich",
    pretty_exceptions_enable=False,
    help="Camera-based control of mobile robots, simulated.",
    epilog="Start with: robsim demo",
)


@app.callback(invoke_without_command=True)
def _root(
    show_version: Annotated[
        bool, typer.Option("--version", help="Print the version and stop.")
    ] = False,
) -> None:
    if show_version:
        print(f"robsim {version('robsim')}")
        raise typer.Exit


DEMO_HELP = (
    "Drive a robot, track it by camera and find its parameters.\n\n"
    "The robot spins, then drives around in an unlimited area. Vision tracks it, recursive least "
    "squares estimate its parameters on the way, a batch estimate follows at the end. Figures and "
    "the trace go to a folder."
)


@app.command(help=DEMO_HELP)
def demo(
    out: Annotated[
        Path, typer.Option("--out", help="Folder for the figures and the trace.")
    ] = Path("robsim-demo"),
    steps: Annotated[
        int, typer.Option("--steps", help="Steps of the run; in the first 200 the robot spins.")
    ] = 1000,
    seed: Annotated[int, typer.Option("--seed", help="Seed of the run.")] = 2008,
    as_json: Annotated[
        bool, typer.Option("--json", help="Print the numbers as JSON, and nothing else.")
    ] = False,
) -> None:
    """Drive a robot, track it by camera and find its parameters."""
    from robsim.demo import run_demo

    try:
        result = run_demo(out, steps=steps, seed=seed)
    except (ValueError, OSError) as error:
        Console(stderr=True).print(f"[bold red]error:[/] {error}", highlight=False)
        raise typer.Exit(code=2) from error
    if as_json:
        print(json.dumps(result.to_dict(), indent=2))
        return
    print(result.report)
    print(result.tracking)
    print(f"written to {out}: {', '.join(file.name for file in result.files)}")


def main() -> None:
    """Run the command line: the entry point ``robsim``."""
    app(prog_name="robsim")
