"""The command ``robsim replay``: a shared run, run again."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

import typer

from robsim.cli import errors
from robsim.cli.outcome import show_panel


def replay(file: Path, trust: bool = False, port: int = 0, no_browser: bool = False) -> None:
    """Rerun a shared run with identical results, and open its panel at the last step.

    A file may contain callbacks, which are Python code. They run with your rights, and only after
    your consent, or with --trust. Read the code of a stranger first: the file is plain text.

    FILE: Replay file, written by Share in the panel.
    --trust: Consent to the code of the file in advance.
    --port N: Port of the page on this machine. [default: any free port]
    --no-browser: Only print the address, and open no browser.

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
