"""The command ``robsim notebooks``: copies the notebooks for students, or their answers."""

from __future__ import annotations

from pathlib import Path

from robsim.cli import errors


def notebooks(folder: Path, solutions: bool = False) -> None:
    r"""Copy the notebooks for students into a folder.

    The notebooks need Jupyter: pip install jupyterlab 'robsim\[notebook]'. Then run jupyter lab
    FOLDER.

    FOLDER: The folder to copy to; created if needed.
    --solutions: For teachers: copy the notebooks with solved exercises.

    Example: robsim notebooks coursework
    """
    from robsim.teach.exercises import copy_notebooks

    files = copy_notebooks(folder, solutions=solutions)
    errors.say(f"written to {folder}: {', '.join(file.name for file in files)}")
