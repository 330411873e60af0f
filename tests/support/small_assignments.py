"""Small assignments as the tests make them: a folder, and what is handed in."""

import io
import json
import re
import textwrap
from contextlib import contextmanager
from unittest import mock

from PIL import Image

from robsim.teach import Key, task
from robsim.teach.assignments.marking import work

#: Wide limits for the scores of the task to estimate, so that any filter that works is within.
LIMITS = {
    "position": {"full": 2.0, "zero": 20.0},
    "heading": {"full": 2.0, "zero": 20.0},
    "consistency": {"full": 3.0, "zero": 100.0, "low": 0.3, "low_zero": 0.01},
}
#: Of each test: quick runs.
SHORT = {"runs": 2, "steps": 20}

#: For assignments that are about anything but time.
PATIENT = "limits = { call = 300, first_call = 300, submission = 3000 }\n"

TESTS = """
name = "hw3"
title = "Through dropouts"

[[tests]]
name = "shown"
task = "estimate"
points = 2
public = true
parameters = { runs = 2, steps = 20 }

[[tests]]
name = "hidden"
number = "3.1"
task = "estimate"
points = 4
public = false
parameters = { runs = 2, steps = 20, noise = 12 }
"""


def assignment(folder, text=PATIENT + TESTS, *, limits=("shown", "hidden"), key=True, **files):
    """Write an assignment; `files`: others by name without suffix, Python at its top."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "assignment.toml").write_text(text)
    tests = {name: {"limits": LIMITS} for name in limits}
    (folder / "limits.json").write_text(json.dumps({"format": 1, "tests": tests}))
    if key and not (folder / "key").exists():
        Key.new().save(folder / "key")
    for name, content in files.items():
        (folder / f"{name}.py").write_text(textwrap.dedent(content))
    return folder


def retell(folder, **numbers):
    """Change numbers in the tables of the sheet."""
    sheet = folder / "sheet.md"
    text = sheet.read_text()
    for name, value in numbers.items():
        text, count = re.subn(rf"(\| `{name}` \|) `.*`", rf"\1 `{value}`", text)
        assert count == 1
    sheet.write_text(text)


def solution(folder, name="reference", kind="estimate"):
    """Write a solution that ships with robsim as a submission."""
    (one,) = [each for each in task(kind).solutions if each.name == name]
    folder.mkdir(parents=True)
    for module, content in one.files.items():
        (folder / f"{module}.py").write_bytes(content)
    return folder


def _small_png():
    content = io.BytesIO()
    Image.new("RGB", (4, 4)).save(content, "png")
    return content.getvalue()


_PNG = _small_png()


@contextmanager
def drawn_quickly():
    """Let pictures of runs be one and the same, since to draw takes longer than to grade."""
    with mock.patch.object(work, "picture_of", return_value=(_PNG, "A picture.")):
        yield
