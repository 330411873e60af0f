"""Submissions of each kind from the reader to a run in a worker, and what is told of it."""

import pytest

import robsim
from robsim.grading import Submission, SubmissionError
from submissions import notebook, packed, write

pytestmark = pytest.mark.long

WORLD = robsim.Scenario(measure=True, robot="lab", resolution=(240, 240))


def inputs(path, **options):
    return Submission(path, slots="control", **options).run(WORLD, seed=3, steps=4).u.tolist()


def failure(path, **options):
    with pytest.raises(SubmissionError) as caught:
        inputs(path, **options)
    return caught.value


def test_a_notebook_drives(tmp_path):
    cells = (
        "GAIN = 0.5",
        "%matplotlib inline",
        "@sim.control\ndef drive(step):\n    return GAIN, 1",
    )
    assert inputs(notebook(tmp_path / "s001.ipynb", *cells)) == [[0.5, 1.0]] * 4


def test_a_notebook_that_fails_is_told_by_cell_and_line(tmp_path):
    cells = (
        "import math\n\n\ndef helper(k):\n    return 1 / (2 - k)",
        "control = lambda s: (0, helper(s.k))",
    )
    error = failure(notebook(tmp_path / "s001.ipynb", *cells))
    place = "control at step 2, s001.ipynb, cell 1, line 5"
    assert str(error) == f"{place}: ZeroDivisionError: division by zero"
    assert (error.slot, error.step, error.file, error.line) == (
        *("control", 2, "s001.ipynb, cell 1", 5),
    )


def test_data_files_are_there(tmp_path):
    source = (
        "from pathlib import Path\n\nHERE = Path(__file__).parent\n"
        "U = float((HERE / 'data/left.txt').read_text()), float(open('right.txt').read())\n"
        "\n\ndef control(step):\n    return U\n"
    )
    files = {"control.py": source, "data/left.txt": "0.25", "right.txt": "0.75"}
    assert inputs(packed(tmp_path / "s001.zip", files)) == [[0.25, 0.75]] * 4


def test_what_is_masked_is_told_in_a_worker(tmp_path):
    source = "import robsim\n\n\ndef control(step):\n    return robsim.reference.nothing\n"
    error = failure(write(tmp_path / "s001", control=source), masked=["robsim.reference"])
    assert str(error) == (
        "control at step 0, control.py, line 5: ImportError: robsim.reference is not there for "
        "this assignment: do without it"
    )


def test_a_long_message_is_short(tmp_path):
    source = "def control(step):\n    raise ValueError('\\x1b[31m' + 'x' * 10**7)\n"
    error = failure(write(tmp_path / "s001", control=source))
    assert str(error).startswith("control at step 0, control.py, line 2: ValueError: \\x1b[31mxxx")
    assert len(str(error)) < 500
