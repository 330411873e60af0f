"""A notebook at home: read as the grader reads it, then run as files of callbacks."""

from __future__ import annotations

from os import PathLike

from robsim.base.files import as_path
from robsim.teach.errors import SubmissionError
from robsim.teach.submissions.files import SubmissionFiles
from robsim.teach.submissions.loading import run_cells
from robsim.teach.submissions.reading import read_submission
from robsim.teach.submissions.rules import Rules

_CELLS = "robsim_cells"


def is_notebook(path: str | PathLike[str]) -> bool:
    file = as_path(path)
    return file.suffix.lower() == ".ipynb" and not file.is_dir()


def read_notebook(path: str | PathLike[str], slots: tuple[str, ...]) -> SubmissionFiles:
    """Return a notebook, not run; raise FileNotFoundError, or ValueError if grading refuses it."""
    if not as_path(path).exists():
        raise FileNotFoundError(f"no file {path}")
    try:
        return read_submission(path, Rules(slots=slots))
    except SubmissionError as error:
        raise ValueError(str(error)) from None


def callback_files(notebook: SubmissionFiles) -> dict[str, bytes]:
    """Return a file for each slot of a notebook, and one that runs its cells, without ``.py``."""
    given = f"{notebook.sources[notebook.main]!r}, {notebook.main!r}, {notebook.slots!r}"
    names = f"from {run_cells.__module__} import {run_cells.__name__} as run"
    files = {_CELLS: f"{names}\nFILLED = run({given}, globals())\n"}
    for slot in notebook.slots:
        files[slot] = f"from {_CELLS} import FILLED\n{slot} = FILLED[{slot!r}]\n"
    return {name: source.encode() for name, source in files.items()}
