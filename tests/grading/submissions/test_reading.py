"""Reading submissions of every kind, as students hand them in."""

import json
import zipfile

import pytest

from robsim.grading._errors import SubmissionError
from robsim.grading._submissions import Rules, SubmissionFiles, loaded_slots, read_submission

CONTROL = Rules(slots=("control",))
BOTH = Rules(slots=("control", "measure"))
DRIVE = "from gains import GAIN\n\n\ndef control(step):\n    return GAIN, GAIN\n"
PLAIN = "def control(step):\n    return 1.0, 2.0\n"


def write(folder, **files):
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in files.items():
        (folder / f"{name}.py").write_text(text)
    return folder


def packed(path, files):
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            archive.writestr(name, content)
    return path


def notebook(path, *cells):
    cells = [{"cell_type": "code", "metadata": {}, "source": cell, "outputs": []} for cell in cells]
    path.write_text(json.dumps({"nbformat": 4, "metadata": {}, "cells": cells}))
    return path


def refusal(path, rules=CONTROL):
    with pytest.raises(SubmissionError) as caught:
        read_submission(path, rules)
    return str(caught.value)


def answer(path, rules=CONTROL):
    """What the control of a submission gives, read, sent and loaded."""
    message = read_submission(path, rules).to_message()
    with loaded_slots(SubmissionFiles.from_message(message), rules) as callbacks:
        return callbacks["control"](None)


def test_a_folder_a_zip_a_file_and_a_notebook_are_one_submission(tmp_path):
    folder = write(tmp_path / "s001", control=DRIVE, gains="GAIN = 3.0\n")
    files = {f.name: f.read_text() for f in folder.iterdir()}
    assert answer(folder) == (3, 3)
    assert answer(packed(tmp_path / "s002.zip", files)) == (3, 3)
    in_folders = {f"s003/hw3/{name}": text for name, text in files.items()}
    assert answer(packed(tmp_path / "s003.zip", in_folders)) == (3, 3)
    (tmp_path / "s004.py").write_text(PLAIN)
    assert answer(tmp_path / "s004.py") == (1, 2)
    (tmp_path / "control.py").write_text(PLAIN)
    assert answer(tmp_path / "control.py") == (1, 2)
    assert answer(notebook(tmp_path / "s005.ipynb", PLAIN)) == (1, 2)
    assert answer(packed(tmp_path / "s006.zip", {"mine.py": PLAIN})) == (1, 2)


def test_what_a_submission_is_stands_in_it(tmp_path):
    folder = write(tmp_path / "s001", control=PLAIN, measure="def measure(step): ...\n")
    (folder / "table.csv").write_text("1,2")
    found = read_submission(folder, BOTH)
    assert (found.name, found.kind, found.main) == ("s001", "folder", "")
    assert found.slots == ("control", "measure")
    assert set(found.sources) == {"control.py", "measure.py", "table.csv"}
    assert SubmissionFiles.from_message(found.to_message()) == found
    only = read_submission(folder, CONTROL)
    assert only.slots == ("control",)
    assert only.notes == ("measure.py is not used: the assignment has no such slot",)


def test_a_misspelled_name_is_told(tmp_path):
    folder = write(tmp_path / "s001", contrl=PLAIN)
    assert "is contrl.py meant to be control.py?" in refusal(write(folder, other=""))
    folder = write(tmp_path / "s002", control=PLAIN, measur="")
    assert "'measur.py' is named after no slot: rename it to measure.py" in refusal(folder, BOTH)
    (tmp_path / "s003.py").write_text(PLAIN.replace("control", "contrl"))
    assert "is contrl meant to be control?" in refusal(tmp_path / "s003.py")
