"""Work at home: a notebook as files of callbacks, and the refusals of grading."""

from __future__ import annotations

import ast
import io
from collections.abc import Iterable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager, redirect_stdout
from os import PathLike
from typing import Any

from robsim.base.files import as_path
from robsim.base.text import one_line
from robsim.simulation.callback_folder import imported_names
from robsim.simulation.slots import SLOTS
from robsim.teach.errors import SubmissionError
from robsim.teach.submissions.files import SubmissionFiles
from robsim.teach.submissions.handed_in import own_slots
from robsim.teach.submissions.imports import masked, masked_in
from robsim.teach.submissions.loading import loaded_slots, run_cells, statements_of_slot
from robsim.teach.submissions.python_text import statements_of
from robsim.teach.submissions.reading import read_submission
from robsim.teach.submissions.rules import Rules

_CELLS, _GIVEN = "robsim_cells", "task.py"


def is_notebook(path: str | PathLike[str], slots: Iterable[str]) -> bool:
    """Return whether the grader takes a notebook: a file, or a folder without files of slots.

    Raise ValueError for a zip.
    """
    file = as_path(path)
    if file.is_file() and file.suffix.lower() == ".zip":
        name = one_line(file)
        raise ValueError(f"{name} is a zip: unpack it, and name the folder or the notebook in it")
    if not file.is_dir():
        return file.suffix.lower() == ".ipynb"
    names = {one.name for one in file.iterdir()}
    has_one = any(name.endswith(".ipynb") for name in names)
    return has_one and names.isdisjoint(f"{slot}.py" for slot in slots)


def read_notebook(path: str | PathLike[str], slots: tuple[str, ...]) -> SubmissionFiles:
    """Return a notebook without running it; raise FileNotFoundError, or ValueError if refused.

    A single notebook comes with the ``task.py`` of its folder.
    """
    file = as_path(path)
    if not file.exists():
        raise FileNotFoundError(f"file {path} is missing")
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


def why_files_refused(
    files: Mapping[str, bytes], callbacks: AbstractContextManager[dict[str, Any]], rules: Rules
) -> str:
    """Return the reason for which grading would refuse the files of slots; "" = accepted."""
    if reason := _why_masked(files, rules.slots, rules):
        return reason
    with quiet(), masked(rules) as taken, callbacks as loaded:
        off = {slot: False for slot in rules.slots if slot in files}
        try:
            own_slots(
                off | loaded,
                rules.slots,
                taken,
                lambda slot: statements_of(files[slot], f"{slot}.py"),
            )
        except ValueError as error:
            return str(error)
    return ""


def why_notebook_refused(notebook: SubmissionFiles, rules: Rules) -> str:
    """Return the reason for which grading would refuse a notebook; "" = accepted."""
    code = ast.unparse(ast.Module([*statements_of_slot(notebook, rules, "")], []))
    main = notebook.main
    if reason := _why_masked({**notebook.modules, main: code.encode()}, [main], rules):
        return reason
    try:
        with quiet(), loaded_slots(notebook, rules):
            return ""
    except SubmissionError as error:
        return str(error)


def _why_masked(files: Mapping[str, bytes], mains: Iterable[str], rules: Rules) -> str:
    """Return the reason if a file in use names something masked; "" = no file does."""
    used = {*mains, *imported_names(files)}
    in_use = {name: source for name, source in files.items() if name in used}
    for name, mask in masked_in(in_use, rules.masked).items():
        file = name if name.endswith(".ipynb") else f"{name}.py"
        return f"{file} has {mask}, which is unavailable in this task"
    return ""


@contextmanager
def quiet() -> Iterator[None]:
    """Print the output of an additional run of code only if it fails: its real run prints it."""
    printed = io.StringIO()
    try:
        with redirect_stdout(printed):
            yield
    except BaseException:
        print(printed.getvalue(), end="")
        raise
