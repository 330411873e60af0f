"""The command line: the program ``robsim``, with one module per command, loaded when it is run."""

from __future__ import annotations

import io
import logging
import sys
import warnings
from importlib.metadata import version
from typing import Annotated, Any

import typer

from robsim.cli import errors
from robsim.cli.command import Group, Later

#: Each command, with its module and summary.
_COMMANDS = {
    "demo": ("simulated.demo", "Drive a robot, track it by camera and estimate its parameters."),
    "new": ("simulated.new", "Write the default callbacks to a folder, as templates to edit."),
    "run": ("simulated.run", "Run a simulation, optionally with the callbacks of a folder."),
    "campaign": (
        "simulated.campaign",
        "Run a simulation many times, over seeds and options, and compare the means.",
    ),
    "gui": (
        "simulated.gui",
        "Open the panel in the browser: camera view, controls, traces, callbacks.",
        "simulated.start",
    ),
    "replay": ("replay", "Rerun a shared run of the panel, with identical results."),
    "check": ("check", "Check your callbacks: report each problem with its situation and line."),
    "grade": ("grade", "Grade the submissions of an assignment."),
    "track": ("track", "Track the robot in a video file or a folder of images."),
    "sessions": (
        "lab.sessions",
        "Repair recorded runs that were cut off, or make videos of recorded runs.",
    ),
    "cameras": ("sources", "List the cameras of this computer, and why others are missing."),
    "live": ("lab.live", "Drive a robot under a real camera, with the callbacks of a folder."),
    "notebooks": ("notebooks", "Copy the notebooks for students into a folder."),
    "bench": ("simulated.bench", "Measure how fast robsim is on this machine."),
    "assignment": ("assignment", "Make an assignment for a course, for robsim grade."),
    "calibrate": (
        "calibration.app",
        "Calibrate a camera: its lens, and its pose above the floor.",
    ),
    "tasks": ("tasks", "List and show tasks, and score your solution of a task."),
    "robots": ("robots", "Show, add and choose robots."),
    "colors": ("colors", "Show, train and test the colour classes that vision detects."),
}


class _Commands(Group):
    def __init__(self, **options: Any) -> None:
        super().__init__(**options)
        self.commands = {name: Later(name, *place) for name, place in _COMMANDS.items()}


app = typer.Typer(
    cls=_Commands,
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
        bool, typer.Option("--version", metavar="", help="Print the version and stop.")
    ] = False,
    verbose: Annotated[
        bool,
        typer.Option(
            "--verbose",
            metavar="",
            help="With --version: also print system, packages, cameras and isolation.",
        ),
    ] = False,
) -> None:
    if verbose and not show_version:
        raise typer.BadParameter("--verbose needs --version: robsim --version --verbose")
    if show_version:
        errors.say(f"robsim {version('robsim')}")
        if verbose:
            from robsim.cli.versions import facts

            for line in facts():
                errors.say(line)
        raise typer.Exit


def main() -> None:
    """Run the command line: the entry point ``robsim``."""
    # It speaks of its cache where that cannot be written.
    logging.getLogger("matplotlib").setLevel(logging.ERROR)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # such as the sign for degrees in ASCII
    with warnings.catch_warnings():
        warnings.showwarning = lambda message, *_: errors.print_note(f"warning: {message}")
        app(prog_name="robsim")
