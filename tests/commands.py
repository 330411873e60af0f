"""Run robsim as a program."""

import os
import subprocess
import sys


def cli(*arguments, cwd=None):
    command = [sys.executable, "-m", "robsim", *arguments]
    environment = {**os.environ, "COLUMNS": "200"}
    return subprocess.run(
        command, capture_output=True, text=True, cwd=cwd, timeout=100, env=environment
    )
