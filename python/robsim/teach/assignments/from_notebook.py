"""An assignment from the exercises of a notebook, checked with secret numbers."""

from __future__ import annotations

import json
import secrets
import string
from collections.abc import Iterable, Sequence
from pathlib import Path

from robsim.base.shipped import NOTEBOOKS
from robsim.teach.exercises import Exercise, notebook_exercises
from robsim.teach.submissions.notebook.choosing import COUNTS

_TEMPLATES = Path(__file__).with_name("templates") / "notebook"
#: The points of an exercise in each kind of tests.
_POINTS = {"public": 1, "hidden": 2}


def notebook_files(notebook: str, name: str) -> dict[str, bytes]:
    """Return the files of an assignment by their paths, without its key.

    The seed of hidden tests is secret, unlike the seed that draws the numbers of a task.
    """
    content = (NOTEBOOKS / f"{notebook}.ipynb").read_bytes()
    heading = "".join(json.loads(content)["cells"][0]["source"]).splitlines()[0].removeprefix("# ")
    exercises = notebook_exercises()[notebook]
    names = [one.name for one in exercises]
    values = {"name": name, "title": heading, "functions": names}
    points = " | ".join(map(str, _POINTS.values()))
    rows = "\n".join(f"| `{one.name}` | {points} | {one.title} |" for one in exercises)
    texts = {
        "assignment.toml": _filled(
            "assignment.toml", **{key: json.dumps(value) for key, value in values.items()}
        ),
        "sheet.md": _filled(
            "sheet.md", heading=heading, notebook=notebook, rows=rows, counts=COUNTS
        ),
    }
    for kind, seed in (("public", 0), ("hidden", secrets.randbits(63))):
        texts[f"{kind}_tests.py"] = _tests(notebook, exercises, kind, seed)
    files = {path: text.encode() for path, text in texts.items()}
    files |= {f"start/{file.name}": file.read_bytes() for file in NOTEBOOKS.glob("*.svg")}
    return files | {f"start/{notebook}.ipynb": content}


def _tests(notebook: str, exercises: Sequence[Exercise], kind: str, seed: int) -> str:
    how = {"kind": kind, "points": _POINTS[kind]}
    tests = (_filled("exercise.txt", **how, name=one.name, title=one.title) for one in exercises)
    return _filled("head.txt", notebook=notebook, seed=seed) + "".join(tests)


def names_of_tests(functions: Iterable[str]) -> tuple[str, ...]:
    """Return the names of all tests of functions."""
    return tuple(f"test_{name}_{kind}" for name in functions for kind in _POINTS)


def _filled(file: str, **values: object) -> str:
    return string.Template((_TEMPLATES / file).read_text(encoding="utf-8")).substitute(values)
