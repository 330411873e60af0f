"""A notebook at home: read as the grader reads it, then run as files of callbacks."""

from __future__ import annotations

from collections.abc import Iterable
from os import PathLike

from robsim.base.files import as_path
from robsim.simulation.slots import SLOTS
from robsim.teach.errors import SubmissionError
from robsim.teach.submissions.files import SubmissionFiles
from robsim.teach.submissions.loading import run_cells
from robsim.teach.submissions.reading import read_submission
from robsim.teach.submissions.rules import Rules

_CELLS, _GIVEN = "robsim_cells", "task.py"


def is_notebook(path: str | PathLike[str], slots: Iterable[str]) -> bool:
    """Return whether the grader takes a notebook: a file, or a folder without files of slots."""
    file = as_path(path)
    if not file.is_dir():
        return file.suffix.lower() == ".ipynb"
    names = {one.name for one in file.iterdir()}
    has_one = any(name.endswith(".ipynb") for name in names)
    return has_one and names.isdisjoint(f"{slot}.py" for slot in slots)


def read_notebook(path: str | PathLike[str], slots: tuple[str, ...]) -> SubmissionFiles:
    """Return a notebook, not run; raise FileNotFoundError, or ValueError if grading refuses it.

    A single notebook comes with the ``task.py`` of its folder.
    """
    file = as_path(path)
    if not file.exists():
        raise FileNotFoundError(f"no file {path}")
    beside = file.with_name(_GIVEN)
    given = {_GIVEN: beside.read_bytes()} if file.is_file() and beside.is_file() else {}
    try:
        return read_submission(path, Rules(slots=slots), given)
    except SubmissionError as error:
        raise ValueError(str(error)) from None


def callback_files(notebook: SubmissionFiles) -> dict[str, bytes]:
    """Return a file for each slot of a notebook, and one that runs its cells, without ``.py``."""
    given = f"{notebook.sources[notebook.main]!r}, {notebook.main!r}, {notebook.slots!r}"
    names = f"from {run_cells.__module__} import {run_cells.__name__} as run"
    helpers = {name: source for name, source in notebook.modules.items() if name not in SLOTS}
    files = {_CELLS: f"{names}\nFILLED = run({given}, globals())\n"}
    for slot in notebook.slots:
        files[slot] = f"from {_CELLS} import FILLED\n{slot} = FILLED[{slot!r}]\n"
    return helpers | {name: source.encode() for name, source in files.items()}
