"""The program robsim, for tests."""

import os
import subprocess
import sys
from contextlib import chdir

from typer.testing import CliRunner

from robsim.cli import app


def cli(*arguments, cwd=None):
    """Run a command as a program of its own: a second or more, all that it imports."""
    command = [sys.executable, "-m", "robsim", *arguments]
    environment = {**os.environ, "COLUMNS": "200"}
    return subprocess.run(
        command, capture_output=True, text=True, cwd=cwd, timeout=300, env=environment
    )


HEARING = """
import signal
from robsim.cli import main
signal.signal(signal.SIGINT, signal.default_int_handler)
main()
"""


def interruptible(*arguments):
    """What starts a command that hears Ctrl-C, which a job in the background ignores otherwise."""
    return [sys.executable, "-W", "error", "-c", HEARING, *arguments]


def command(*arguments, cwd="."):
    """Run a command in this process; an exception that the command lets through comes out."""
    with chdir(cwd):
        runner = CliRunner(env={"COLUMNS": "200"})
        return runner.invoke(app, list(arguments), catch_exceptions=False)
