"""The program robsim, for tests."""

import os
import subprocess
import sys

from typer.testing import CliRunner

from robsim.cli import app


def cli(*arguments, cwd=None):
    """Run a command as a program of its own."""
    command = [sys.executable, "-m", "robsim", *arguments]
    environment = {**os.environ, "COLUMNS": "200"}
    return subprocess.run(
        command, capture_output=True, text=True, cwd=cwd, timeout=100, env=environment
    )


def command(*arguments):
    """Run a command in this process: quicker, for those that end at once."""
    return CliRunner(env={"COLUMNS": "200"}).invoke(app, list(arguments))
