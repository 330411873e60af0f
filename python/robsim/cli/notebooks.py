"""The command ``robsim notebooks``: copies the notebooks for students."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from robsim.cli import errors
from robsim.cli.command import argument

EXAMPLE = "Example: robsim notebooks coursework"
HELP = "They need Jupyter: pip install notebook 'robsim\\[notebook]'. Then: jupyter notebook FOLDER"


def notebooks(
    folder: Annotated[Path, argument("FOLDER", "The folder; created if needed.")],
) -> None:
    """Copy the notebooks for students into a folder."""
    from robsim.base.shipped import copy_notebooks

    with errors.report_errors():
        files = copy_notebooks(folder)
    errors.say(f"written to {folder}: {', '.join(file.name for file in files)}")
