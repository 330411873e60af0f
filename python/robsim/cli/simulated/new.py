"""The command ``robsim new``: templates of callbacks."""

from __future__ import annotations

import shlex
from pathlib import Path

from robsim.cli import errors


def new(folder: Path) -> None:
    """Write the default callbacks to a folder.

    Each file is a stage of the loop: control.py, measure.py, ... Optional stages are off: to switch
    a stage on, set ENABLED = True in its file. Then run robsim gui FOLDER or robsim run FOLDER.

    FOLDER: The folder to write to; created if needed.

    Example: robsim new mine
    """
    from robsim.simulation.callback_folder import new_folder

    files = new_folder(folder)
    errors.say(f"written to {folder}: {', '.join(file.name for file in files)}")
    name = shlex.quote(str(folder))
    errors.say(f"edit them, then watch the robot drive: robsim gui {name}")
    errors.say(f"or run them without a window: robsim run {name}")
