"""Submissions as the tests hand them in: folders, zips, notebooks."""

import json
import pickle
import zipfile

import pytest

from robsim.teach import SubmissionError
from robsim.teach.submissions import Rules, loaded_slots, read_submission

CONTROL = Rules(slots=("control",))
BOTH = Rules(slots=("control", "measure"))
PLAIN = "def control(step):\n    return 1.0, 2.0\n"


def write(folder, **files):
    """A folder with Python files."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in files.items():
        (folder / f"{name}.py").write_text(text)
    return folder


def packed(path, files):
    """A zip: content by name, or by `zipfile.ZipInfo`."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            archive.writestr(name, content)
    return path


def notebook(path, *cells, tags=None, **others):
    """A notebook of code cells; `tags` by number of the cell, from 1."""
    written = [
        {
            "cell_type": "code",
            "metadata": {"tags": [tags[number]]} if tags and number in tags else {},
            "source": cell,
            "outputs": [],
            "execution_count": None,
        }
        for number, cell in enumerate(cells, 1)
    ]
    content = {"nbformat": 4, "nbformat_minor": 5, "metadata": {}, "cells": written} | others
    path.write_text(json.dumps(content))
    return path


def refused(path, rules=CONTROL):
    """The error that a submission is refused with."""
    with pytest.raises(SubmissionError) as caught:
        read_submission(path, rules)
    return caught.value


def sent(path, rules=CONTROL):
    """A submission as a worker gets it."""
    return pickle.loads(pickle.dumps(read_submission(path, rules)))


def answer(path, rules=CONTROL):
    """What the control of a submission returns."""
    with loaded_slots(sent(path, rules), rules) as callbacks:
        return callbacks["control"](None)
