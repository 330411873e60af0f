"""Submissions of each kind from the reader to a run in a worker, and what is told of it."""

import pytest

import robsim
from graded import PATIENT
from robsim.teach import Submission, SubmissionError
from submissions import notebook, packed, write

pytestmark = pytest.mark.long

WORLD = robsim.Scenario(measure=True, robot="lab", resolution=(240, 240))


def inputs(path, **options):
    return (
        Submission(path, slots="control", limits=PATIENT, **options)
        .run(WORLD, seed=3, steps=4)
        .u.tolist()
    )


def failure(path, **options):
    with pytest.raises(SubmissionError) as caught:
        inputs(path, **options)
    return caught.value


def test_a_notebook_runs_its_slot_and_nothing_else(tmp_path):
    left = tmp_path / "left"
    cells = [
        f"!touch {left}",
        f"%%bash\ntouch {left}",
        f"open({str(left)!r}, 'w')",
        "from IPython.display import HTML, display\ndisplay(HTML('<script>alert(1)</script>'))",
        "get_ipython().run_cell('1')",
        "GAIN = 0.5\n%matplotlib inline",
        "@sim.control\ndef drive(step):\n    return GAIN, 1",
    ]
    kernel = {"kernelspec": {"name": "bash", "argv": ["touch", str(left)]}}
    path = notebook(tmp_path / "s.ipynb", *cells, metadata=kernel)
    submission = Submission(path, slots="control", limits=PATIENT)
    assert submission.run(WORLD, steps=4, seed=3).u.tolist() == [[0.5, 1.0]] * 4
    assert submission.output == ""
    assert not left.exists()


def test_names_of_files_reach_no_message_as_they_are(tmp_path):
    for name in ("\x1b[31m\n.py", "\u202egnp.py", "-rf.py", "a\x07.py"):
        (tmp_path / name).write_text("1 / 0\ndef control(step): return 0, 0\n")
        with pytest.raises(SubmissionError) as failed:
            inputs(tmp_path / name)
        assert str(failed.value).isprintable()


def test_a_notebook_that_fails_is_told_by_cell_and_line(tmp_path):
    cells = (
        "import math\n\n\ndef helper(k):\n    return 1 / (2 - k)",
        "control = lambda s: (0, helper(s.k))",
    )
    error = failure(notebook(tmp_path / "s001.ipynb", *cells))
    told = (error.slot, error.step, error.file, error.line)
    assert told == ("control", 2, "s001.ipynb, cell 1", 5)
    assert "ZeroDivisionError: division by zero" in str(error)


def test_data_files_are_there(tmp_path):
    source = (
        "from pathlib import Path\n\nHERE = Path(__file__).parent\n"
        "U = float((HERE / 'data/left.txt').read_text()), float(open('right.txt').read())\n"
        "\n\ndef control(step):\n    return U\n"
    )
    files = {"control.py": source, "data/left.txt": "0.25", "right.txt": "0.75"}
    assert inputs(packed(tmp_path / "s001.zip", files)) == [[0.25, 0.75]] * 4


def test_what_is_masked_is_told_in_a_worker(tmp_path):
    body = "    return robsim.estimation.reference.nothing\n"
    source = f"import robsim\n\n\ndef control(step):\n{body}"
    hidden = "robsim.estimation.reference"
    error = failure(write(tmp_path / "s001", control=source), masked=[hidden])
    assert (error.step, error.file, error.line) == (0, "control.py", 5)
    assert "robsim.estimation.reference is not there" in str(error)
