"""The command line: the program ``robsim``, with one module per command."""

from __future__ import annotations

import io
import logging
import sys
import warnings
from importlib.metadata import version
from typing import Annotated

import typer

from robsim.cli import bench, check, colors, errors, notebooks, robots, track
from robsim.cli.assignment import app as assignment
from robsim.cli.calibration import app as calibration
from robsim.cli.command import Command, Group
from robsim.cli.grading import grade
from robsim.cli.live import cameras, live, serving
from robsim.cli.shared import SWITCH
from robsim.cli.simulated import campaign, demo, gui, run
from robsim.cli.tasks import app as tasks

app = typer.Typer(
    cls=Group,
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode="rich",
    pretty_exceptions_enable=False,
    help="Camera-based control of mobile robots, simulated.",
    epilog="Start with: robsim demo",
)
app.command(cls=Command, help=demo.HELP, epilog=demo.EXAMPLE)(demo.demo)
app.command(cls=Command, help=run.NEW_HELP, epilog=run.NEW_EXAMPLE)(run.new)
app.command(cls=Command, help=run.RUN_HELP, epilog=run.RUN_EXAMPLE)(run.run)
app.command(cls=Command, help=campaign.HELP, epilog=campaign.EXAMPLE)(campaign.campaign)
app.command(cls=Command, help=gui.HELP, epilog=gui.EXAMPLE)(gui.gui)
app.command(cls=Command, help=check.HELP, epilog=check.EXAMPLE)(check.check)
app.command(cls=Command, help=grade.HELP, epilog=grade.EXAMPLE)(grade.grade)
app.command(cls=Command, help=track.HELP, epilog=track.EXAMPLE)(track.track)
app.command(cls=Command, help=cameras.HELP, epilog=cameras.EXAMPLE)(cameras.cameras)
app.command(cls=Command, help=live.HELP, epilog=live.EXAMPLE)(live.live)
app.command(
    cls=Command,
    help=serving.HELP,
    epilog=serving.EXAMPLE,
    # What stands after COMMAND is for the command, options as well.
    context_settings={"allow_interspersed_args": False},
)(serving.serve)
app.command(cls=Command, help=notebooks.HELP, epilog=notebooks.EXAMPLE)(notebooks.notebooks)
app.command(cls=Command, help=bench.HELP, epilog=bench.EXAMPLE)(bench.bench)
app.add_typer(assignment.app, name="assignment", cls=Group)
app.add_typer(calibration.app, name="calibrate", cls=Group)
app.add_typer(tasks.app, name="tasks", cls=Group)
app.add_typer(robots.app, name="robots", cls=Group)
app.add_typer(colors.app, name="colors", cls=Group)


@app.callback(invoke_without_command=True)
def _root(
    show_version: Annotated[
        bool, typer.Option("--version", metavar=SWITCH, help="Print the version and stop.")
    ] = False,
) -> None:
    if show_version:
        errors.say(f"robsim {version('robsim')}")
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
