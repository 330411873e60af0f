"""Loading submissions: as a folder of one's own is loaded, with what the rules allow."""

import importlib
import linecache
import shutil
import sys
import traceback

import pytest

import robsim
import robsim.reference
from robsim.grading._errors import SubmissionError
from robsim.grading._submissions import Rules, load_slots, loaded_slots, loading
from submissions import BOTH, CONTROL, PLAIN, answer, notebook, sent, write


@pytest.fixture(autouse=True)
def traceless():
    """Nothing of a submission stays in the interpreter."""
    finders, path, modules = list(sys.meta_path), list(sys.path), dict(sys.modules)
    yield
    assert sys.meta_path == finders
    assert sys.path == path
    assert [name for name in sys.modules if name.startswith("robsim_callbacks")] == []
    assert [n for n, module in modules.items() if sys.modules.get(n) is not module] == []
    assert robsim.reference is sys.modules["robsim.reference"]


def failure(path, rules=CONTROL):
    with pytest.raises(SubmissionError) as caught, loaded_slots(sent(path, rules), rules):
        pass
    return caught.value


FILTER = """
import dataclasses

import numpy as np

import robsim
from smoothing import Smoothed


@dataclasses.dataclass
class Memory:
    turn: float = 0.0


memory, smoothed = Memory(), Smoothed(0.5)


def control(step):
    import late

    pose = step.measurement.pose if step.measurement else np.zeros(3)
    memory.turn = smoothed(np.sin(pose[2])) * late.GAIN
    return 1.0 + memory.turn, 1.0 - memory.turn
"""
SMOOTHING = """
class Smoothed:
    def __init__(self, weight):
        self.weight, self.value = weight, 0.0

    def __call__(self, new):
        self.value += self.weight * (new - self.value)
        return self.value
"""


def ran(callbacks):
    sim = robsim.Simulation(
        robot="lab", measure=True, seed=3, noise=robsim.GaussianNoise(8), resolution=(240, 240),
        **callbacks,
    )  # fmt: skip
    return bytes_of(sim.run(20))


def bytes_of(trace):
    return {name: trace[name].tobytes() for name in trace.names}


@pytest.mark.parametrize("kind", ["folder", "zip", "file", "notebook"])
def test_a_submission_gives_the_bytes_of_its_folder(tmp_path, kind):
    folder = write(tmp_path / "s001", control=FILTER, smoothing=SMOOTHING, late="GAIN = 0.3")
    sim = robsim.Simulation.from_folder(
        folder, robot="lab", measure=True, seed=3, noise=robsim.GaussianNoise(8),
        resolution=(240, 240),
    )  # fmt: skip
    expected = bytes_of(sim.run(20))
    path = folder
    if kind == "zip":
        path = shutil.make_archive(str(tmp_path / "s002"), "zip", folder)
    elif kind == "file":
        (folder / "control.py").rename(folder / "mine.py")
        path = write(folder, smoothing=SMOOTHING)
        (folder / "late.py").write_text("GAIN = 0.3")
        path = tmp_path / "mine.py"
        path.write_text(FILTER.replace("from smoothing import Smoothed", SMOOTHING)
                        .replace("import late", "class late:\n        GAIN = 0.3"))  # fmt: skip
    elif kind == "notebook":
        cells = FILTER.replace("from smoothing import Smoothed", SMOOTHING)
        cells = cells.replace("import late", "class late:\n        GAIN = 0.3").split("\n\n\n")
        path = notebook(tmp_path / "s003.ipynb", *cells)
    with loaded_slots(sent(path), CONTROL) as callbacks:
        assert ran(callbacks) == expected


def test_slots_of_the_rules_alone_are_loaded(tmp_path):
    folder = write(tmp_path / "s001", control=PLAIN, measure="raise SystemExit(0)")
    with loaded_slots(sent(folder), CONTROL) as callbacks:
        assert [*callbacks] == ["control"]
    off = "ENABLED = False\n\n\ndef measure(step): ...\n"
    folder = write(tmp_path / "s002", control=PLAIN, measure=off)
    with loaded_slots(sent(folder, BOTH), BOTH) as callbacks:
        assert callbacks["measure"] is False


def test_data_files_are_beside_the_code(tmp_path):
    source = (
        "from pathlib import Path\n\nGAIN = float((Path(__file__).parent / 'gain.txt').read_text())"
        "\n\n\ndef control(step):\n    return GAIN, GAIN\n"
    )
    folder = write(tmp_path / "s001", control=source)
    (folder / "gain.txt").write_text("0.25")
    files = sent(folder)
    files.write_to(tmp_path / "scratch")
    with loaded_slots(files, CONTROL, tmp_path / "scratch") as callbacks:
        assert callbacks["control"](None) == (0.25, 0.25)


@pytest.mark.parametrize(
    ("source", "words", "line"),
    [
        ("x = 1\n1 / 0\n", "ZeroDivisionError: division by zero", 2),
        ("import not_there\n", "ModuleNotFoundError: No module named 'not_there'", 1),
        ("raise SystemExit\n", "SystemExit", 1),
        ("def control(a, b): ...\n", "control.py: control must take one argument", None),
        ("control = 3\n", "must be a function control(step), got 3", None),
        ("def contol(step): ...\n", "must define control(step); it defines: contol", None),
        ("ENABLED = 1\n", "ENABLED must be True or False", None),
        ("async def control(step): ...\n", "write def in place of async def", None),
    ],
)
def test_what_fails_at_the_start_is_told_with_its_line(tmp_path, source, words, line):
    error = failure(write(tmp_path / "s001", control=source))
    assert words in str(error)
    assert (error.slot, error.line) == ("control", line or error.line)
    if line:
        assert error.file == "control.py"
    if "contol" not in source:
        (tmp_path / "mine.py").write_text(source.replace("ENABLED = 1", "1 / 0") + "control = 3")
        assert failure(tmp_path / "mine.py").whose == "submission"


def test_a_line_of_a_notebook_that_fails_is_told(tmp_path):
    error = failure(notebook(tmp_path / "s003.ipynb", "x = 1", "\nY = 1 / 0\ncontrol = Y"))
    assert "ZeroDivisionError: division by zero" in str(error)
    assert (error.file, error.line) == ("s003.ipynb, cell 2", 2)


def test_lines_are_known_though_there_is_no_file(tmp_path):
    with loaded_slots(sent(write(tmp_path / "s001", control=PLAIN)), CONTROL) as callbacks:
        code = callbacks["control"].__code__
        assert linecache.getline(code.co_filename, 2) == "    return 1.0, 2.0\n"


MASKED = Rules(slots=("control",), masked=("robsim.reference", "fractions"))


@pytest.mark.parametrize(
    "line",
    [
        "import robsim.reference",
        "import robsim.reference as r",
        "from robsim import reference",
        "from robsim.reference import ExtendedKalmanFilter",
        "import robsim.reference._kalman",
        "from robsim.reference import _kalman",
        "import robsim\nrobsim.reference",
        "import importlib\nimportlib.import_module('robsim.reference')",
        "import importlib\nimportlib.import_module('robsim.reference._kalman')",
        "__import__('robsim.reference')",
    ],
)
def test_what_is_masked_cannot_be_had(tmp_path, line):
    error = failure(write(tmp_path / "s001", control=f"{line}\n{PLAIN}"), MASKED)
    assert "ImportError: robsim.reference is not there for this assignment: do without it" in str(
        error
    )
    assert error.line == 1 + line.count("\n")
    late = f"def control(step):\n    {line.replace(chr(10), chr(10) + '    ')}\n"
    files = sent(write(tmp_path / "s002", control=late), MASKED)
    masked = pytest.raises(ImportError, match=r"robsim\.reference is not there")
    with loaded_slots(files, MASKED) as callbacks, masked:
        callbacks["control"](None)
    assert importlib.import_module("robsim.reference") is robsim.reference


@pytest.mark.parametrize("line", ["robsim.locate", "robsim.locate(None)", "robsim.locate.__doc__"])
def test_a_masked_function_cannot_be_had(tmp_path, line):
    rules = Rules(slots=("control",), masked=("robsim.locate",))
    source = f"import robsim\n\n\ndef control(step):\n    {line}()\n"
    with loaded_slots(sent(write(tmp_path / "s001", control=source), rules), rules) as callbacks:
        with pytest.raises(ImportError, match=r"robsim\.locate is not there for this assignment"):
            callbacks["control"](None)
        robsim.Simulation(measure=True).run(2)  # robsim itself has it
    error = failure(write(tmp_path / "s002", control=f"from robsim import locate\n{PLAIN}"), rules)
    assert "robsim.locate is not there" in str(error)
    assert robsim.locate.__name__ == "locate"


def test_only_what_is_allowed_can_be_imported(tmp_path):
    rules = Rules(slots=("control",), imports=("math", "numpy"))
    source = "import math\nimport numpy.linalg\nfrom helper import A\n" + PLAIN
    folder = write(tmp_path / "s001", control=source, helper="from math import pi as A")
    assert answer(folder, rules) == (1, 2)
    folder = write(tmp_path / "s002", control="import os.path\n" + PLAIN)
    error = failure(folder, rules)
    assert "os may not be imported in this assignment: there is math, numpy" in str(error)
    folder = write(tmp_path / "s003", control="import helper\n" + PLAIN, helper="import json")
    assert "json may not be imported" in str(failure(folder, rules))
    path = notebook(tmp_path / "s004.ipynb", "import json", "def control(step):\n    json.x")
    assert "json may not be imported" in str(failure(path, rules))
    # What a library needs in its turn is its own affair.
    source = (
        "import numpy as np\n\n\ndef control(step):\n    return np.polyfit([0, 1], [0, 1], 1)\n"
    )
    assert answer(write(tmp_path / "s005", control=source), rules).shape == (2,)


def test_a_worker_loads_for_good(tmp_path):
    source = "def control(step):\n    import late\n\n    return late.U\n"
    files = sent(write(tmp_path / "s001", control=source, late="U = 1, 2"))
    callbacks = load_slots(files, CONTROL)
    assert callbacks["control"](None) == (1, 2)
    loading._for_good.pop().__exit__(None, None, None)


def test_a_traceback_shows_the_lines_of_the_submission(tmp_path):
    source = "import helper\n\n\ndef control(step):\n    return helper.fail()\n"
    helper = "\n\ndef fail():\n    return [][1]\n"
    files = sent(write(tmp_path / "s001", control=source, helper=helper))
    with loaded_slots(files, CONTROL) as callbacks, pytest.raises(IndexError) as caught:
        callbacks["control"](None)
    told = traceback.extract_tb(caught.tb)[1:]
    assert [(frame.lineno, frame.line) for frame in told] == [
        (5, "return helper.fail()"),
        (4, "return [][1]"),
    ]
