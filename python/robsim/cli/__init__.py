"""The command line: the program ``robsim``, with one module per command."""

from __future__ import annotations

import logging
import warnings
from importlib.metadata import version
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from robsim.cli import bench, colors, demo, errors, notebooks, robots, run, track
from robsim.cli.shared import SWITCH


class _Program(TyperGroup):
    """The commands; Ctrl-C ends each of them with a word."""

    def invoke(self, ctx: Any) -> Any:
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt:
            errors.print_note("stopped")
            raise typer.Exit(130) from None  # as a shell has it: 128 + SIGINT


app = typer.Typer(
    cls=_Program,
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode="rich",
    pretty_exceptions_enable=False,
    help="Camera-based control of mobile robots, simulated.",
    epilog="Start with: robsim demo",
)
app.command(help=demo.HELP, epilog=demo.EXAMPLE)(demo.demo)
app.command(help=run.NEW_HELP, epilog=run.NEW_EXAMPLE)(run.new)
app.command(help=run.RUN_HELP, epilog=run.RUN_EXAMPLE)(run.run)
app.command(help=track.HELP, epilog=track.EXAMPLE)(track.track)
app.command(help=notebooks.HELP, epilog=notebooks.EXAMPLE)(notebooks.notebooks)
app.command(help=bench.HELP, epilog=bench.EXAMPLE)(bench.bench)
app.add_typer(robots.app, name="robots")
app.add_typer(colors.app, name="colors")


@app.callback(invoke_without_command=True)
def _root(
    show_version: Annotated[
        bool, typer.Option("--version", metavar=SWITCH, help="Print the version and stop.")
    ] = False,
) -> None:
    if show_version:
        print(f"robsim {version('robsim')}")
        raise typer.Exit


def main() -> None:
    """Run the command line: the entry point ``robsim``."""
    # It speaks of its cache where that cannot be written.
    logging.getLogger("matplotlib").setLevel(logging.ERROR)
    with warnings.catch_warnings():
        warnings.showwarning = lambda message, *_: errors.print_note(f"warning: {message}")
        app(prog_name="robsim")
