"""The command ``robsim notebooks``: copies the notebooks for students."""

from __future__ import annotations

from pathlib import Path

from robsim.cli import errors


def notebooks(folder: Path) -> None:
    r"""Copy the notebooks for students into a folder.

    They need Jupyter: pip install notebook 'robsim\[notebook]'. Then: jupyter notebook FOLDER

    FOLDER: The folder; created if needed.

    Example: robsim notebooks coursework
    """
    from robsim.base.shipped import copy_notebooks

    files = copy_notebooks(folder)
    errors.say(f"written to {folder}: {', '.join(file.name for file in files)}")
