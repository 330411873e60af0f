"""The command ``robsim replay``: a shared run, run again."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

import typer

from robsim.cli import errors
from robsim.cli.outcome import show_panel


def replay(file: Path, trust: bool = False, port: int = 0, no_browser: bool = False) -> None:
    """Rerun a shared run, bit by bit, and open its panel at the last step.

    A file may contain Python code, its callbacks. They run with your rights, and only after your
    consent, or with --trust: read the code of a stranger first, the file is text.

    FILE: Replay file, from Share of the panel.
    --trust: Run the code of the file without a question.
    --port N: Port of the page on this machine. [default: any that is free]
    --no-browser: Start no browser, print the address only.

    Example: robsim replay run.replay
    """
    from robsim.gui.panels.replay_file import ReplayFile
    from robsim.gui.replays import run_again

    with errors.report_errors(file):
        read = ReplayFile.load(file)
        if read.code and not trust:
            errors.say("the file contains Python code, which would run with your rights:")
            for name, lines in read.code.items():
                errors.say(f"  {name}, {lines} lines")
            with suppress(typer.Abort):  # no answer comes
                trust = typer.confirm("Run it?")
            if not trust:
                raise typer.Exit(1)
        with run_again(read) as panel:
            errors.say(f"rerun: {len(panel.trace)} steps")
            show_panel(panel, port, is_wanted=not no_browser)
