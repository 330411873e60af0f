"""The exercises of robsim by notebook, and notebooks with their answers."""

from __future__ import annotations

import ast
import json
from functools import cache
from os import PathLike
from pathlib import Path
from types import ModuleType

from robsim.base.checks import check_bool
from robsim.base.files import write_new_files
from robsim.base.shipped import NOTEBOOKS
from robsim.teach.exercises.exercise import Exercise
from robsim.teach.tasks.solutions import unpack

#: The files of ``notebooks/solutions``, packed: students find no answer by chance.
PACKED = Path(__file__).with_name("answers.bin")


@cache
def sources() -> dict[str, str]:
    """Return the modules of answers by the name of their notebook."""
    return unpack(PACKED.read_bytes())


@cache
def notebook_exercises() -> dict[str, tuple[Exercise, ...]]:
    """Return the exercises of each notebook, in their order.

    Returns
    -------
    dict of str to tuple of Exercise
        By the name of the notebook, such as ``"02_park"``.

    Examples
    --------
    >>> [one.name for one in robsim.teach.notebook_exercises()["02_park"]]
    ['to_the_right', 'voltages', 'drive_ahead']
    """
    return {name: _exercises_in(name, source) for name, source in sources().items()}


def _exercises_in(name: str, source: str) -> tuple[Exercise, ...]:
    module = ModuleType(name)
    exec(compile(source, f"<answers of {name}>", "exec"), vars(module))
    return tuple(one for one in vars(module).values() if isinstance(one, Exercise))


def solved(notebook: str) -> bytes:
    """Return a notebook with the functions of its module of answers."""
    content = json.loads((NOTEBOOKS / f"{notebook}.ipynb").read_text(encoding="utf-8"))
    answers = _definitions(sources()[notebook])
    for cell in content["cells"]:
        if cell["cell_type"] == "code":
            cell["source"] = _filled("".join(cell["source"]), answers)
    return (json.dumps(content, indent=1, ensure_ascii=False) + "\n").encode()


def copy_notebooks(folder: str | PathLike[str], *, solutions: bool = False) -> list[Path]:
    """Copy the notebooks of robsim and their picture into a folder.

    Parameters
    ----------
    folder : path
        The folder, created if needed.
    solutions : bool
        Whether to include the answers of the exercises.

    Returns
    -------
    list of Path
        The copies.

    Raises
    ------
    FileExistsError
        If one of them exists in the folder; then nothing is written.
    NotADirectoryError
        If `folder` is a file.

    Examples
    --------
    >>> robsim.teach.copy_notebooks("coursework")[0].name
    '00_panel.ipynb'
    """
    check_bool("solutions", solutions)
    found = (*sorted(NOTEBOOKS.glob("*.ipynb")), *NOTEBOOKS.glob("*.svg"))
    files = {file.name: file.read_bytes() for file in found}
    if solutions:
        files |= {f"{name}.ipynb": solved(name) for name in sources()}
    return write_new_files(files, folder)


def _definitions(source: str) -> dict[str, str]:
    """Return the text of each function and class at the top of a module, without decorators."""
    lines = source.splitlines()
    kinds = (ast.FunctionDef, ast.ClassDef)
    found = (node for node in ast.parse(source).body if isinstance(node, kinds))
    return {node.name: "\n".join(lines[node.lineno - 1 : node.end_lineno]) for node in found}


def _filled(cell: str, answers: dict[str, str]) -> str:
    for name, text in _definitions(cell).items():
        cell = cell.replace(text, answers.get(name, text))
    return cell
