"""Loading of submissions: here and in a worker."""

import importlib
import inspect
import re
import shutil
import sys
import traceback
from dataclasses import replace

import pytest

import robsim
import robsim.estimation.reference
from graded import PATIENT
from robsim.control import path_following
from robsim.simulation.callback_folder import new_folder
from robsim.teach import TASKS, Submission, SubmissionError, task, try_solution
from submissions import (
    BOTH,
    CONTROL,
    PLAIN,
    Rules,
    answer,
    loaded_slots,
    notebook,
    packed,
    read_submission,
    refused,
    sent,
    write,
)

# --- loading here


@pytest.fixture(autouse=True)
def traceless():
    """Nothing of a submission stays in the interpreter."""
    finders, path, modules = list(sys.meta_path), list(sys.path), dict(sys.modules)
    yield
    assert sys.meta_path == finders
    assert sys.path == path
    assert [name for name in sys.modules if name.startswith("robsim_callbacks")] == []
    assert [n for n, module in modules.items() if sys.modules.get(n) is not module] == []
    assert robsim.estimation.reference is sys.modules["robsim.estimation.reference"]


def failure(path, rules=CONTROL):
    with pytest.raises(SubmissionError) as caught, loaded_slots(sent(path, rules), rules):
        pass
    return caught.value


FILTER = """
import numpy as np
from smoothing import Smoothed

smoothed = Smoothed()


def control(step):
    import late

    pose = step.measurement.pose if step.measurement else np.zeros(3)
    turn = smoothed(np.sin(pose[2])) * late.GAIN
    return 1.0 + turn, 1.0 - turn
"""
SMOOTHING = """
class Smoothed:
    value = 0.0

    def __call__(self, new):
        self.value += 0.5 * (new - self.value)
        return self.value
"""


def bytes_of(trace):
    return {name: trace[name].tobytes() for name in trace.names}


def test_a_submission_of_each_kind_gives_the_bytes_of_its_folder(tmp_path):
    folder = write(tmp_path / "s001", control=FILTER, smoothing=SMOOTHING, late="GAIN = 0.3")
    options = {"robot": "lab", "measure": True, "seed": 3, "resolution": (240, 240)}
    options["noise"] = robsim.GaussianNoise(8)
    expected = bytes_of(robsim.Simulation.from_folder(folder, **options).run(20))
    zipped = shutil.make_archive(str(tmp_path / "s002"), "zip", folder)
    alone = FILTER.replace("from smoothing import Smoothed", SMOOTHING)
    alone = alone.replace("import late", "class late:\n        GAIN = 0.3")
    (tmp_path / "mine.py").write_text(alone)
    cells = notebook(tmp_path / "s003.ipynb", *alone.split("\n\n\n"))
    for path in (folder, zipped, tmp_path / "mine.py", cells):
        with loaded_slots(sent(path), CONTROL) as callbacks:
            assert bytes_of(robsim.Simulation(**options, **callbacks).run(20)) == expected


def test_files_beside_each_other_are_imported_with_a_dot_or_without(tmp_path):
    files = {"helper": "from .deeper import VALUE\n", "deeper": "VALUE = 3.0\n"}
    source = (
        "from .helper import VALUE\nimport deeper\ncontrol = lambda step: (VALUE, deeper.VALUE)"
    )
    folder = write(tmp_path / "mine", control=source, **files)
    assert answer(folder) == (3, 3)
    assert robsim.Simulation.from_folder(folder).run(2).u[0].tolist() == [3, 3]
    (tmp_path / "s002.py").write_text(source)
    given = {f"{name}.py": text.encode() for name, text in files.items()}
    with loaded_slots(read_submission(tmp_path / "s002.py", CONTROL, given), CONTROL) as callbacks:
        assert callbacks["control"](None) == (3, 3)
    error = failure(write(tmp_path / "s001", control=f"from . import helper\n{PLAIN}", **files))
    assert "write import helper" in str(error)
    assert error.line == 1
    taken = write(tmp_path / "s002", control=f"from .random import x\n{PLAIN}", random="x = 1")
    assert "rename it" in str(refused(taken))


def test_slots_of_the_rules_alone_are_loaded(tmp_path):
    folder = write(tmp_path / "s001", control=PLAIN, measure="raise SystemExit(0)")
    with loaded_slots(sent(folder), CONTROL) as callbacks:
        assert [*callbacks] == ["control"]
    off = "ENABLED = False\n\n\ndef measure(step): ...\n"
    folder = write(tmp_path / "s002", control=PLAIN, measure=off)
    with loaded_slots(sent(folder, BOTH), BOTH) as callbacks:
        assert [*callbacks] == ["control"]
    rules = replace(BOTH, defaults=True)
    with loaded_slots(sent(folder, rules), rules) as callbacks:
        assert callbacks["measure"] is False


def test_what_robsim_brings_along_is_not_handed_in(tmp_path):
    new_folder(tmp_path / "new")
    untouched = (tmp_path / "new/estimate_state.py").read_text()
    for slot, source, why in (
        ("measure", "measure = True", "is the stage of robsim"),
        ("measure", (tmp_path / "new/measure.py").read_text(), "ENABLED = False"),
        ("estimate_state", untouched.replace("= False", "= True"), "untouched"),
        ("control", "import robsim\ncontrol = robsim.Spin(0.1)", "an object of robsim"),
        (
            "control",
            "from robsim.control import FollowPath\ncontrol = FollowPath([(1, 1)])",
            "an ob",
        ),
    ):
        rules = Rules(slots=(slot,))
        folder = write(tmp_path / f"s{len(why)}{slot}", **{slot: source})
        assert f"nothing is handed in: {slot} " in str(failure(folder, rules))
        assert why in str(failure(folder, rules))
        with loaded_slots(sent(folder, rules), replace(rules, defaults=True)) as callbacks:
            assert [*callbacks] == [slot]
    changed = untouched.replace("= False", "= True").replace("step.k == 0", "step.k < 1")
    rules = Rules(slots=("estimate_state",))
    with loaded_slots(sent(write(tmp_path / "s9", estimate_state=changed), rules), rules) as own:
        assert callable(own["estimate_state"])


@pytest.mark.parametrize("name", TASKS)
def test_what_one_begins_with_is_handed_in_once_a_line_of_it_is_another(tmp_path, name):
    task = TASKS[name]()
    task.begin(tmp_path / "mine")
    rules = Rules(slots=task.slots, masked=task.masked)
    with pytest.raises(SubmissionError, match="untouched"):
        loaded_slots(sent(tmp_path / "mine", rules), rules).__enter__()
    for file in (tmp_path / "mine").glob("*.py"):
        if file.name != "task.py":
            file.write_text(re.sub(r"(?m)^( +return) ([^#\n]+)", r"\1 [\2][0]", file.read_text()))
    with loaded_slots(sent(tmp_path / "mine", rules), rules) as callbacks:
        assert {*callbacks} <= {*task.slots}


@pytest.mark.parametrize("number", ["125.0", "0.01**2"])
def test_a_number_alone_that_is_another_is_work(tmp_path, number):
    new_folder(tmp_path / "new")
    untouched = (tmp_path / "new/estimate_state.py").read_text().replace("= False", "= True")
    rules = Rules(slots=("estimate_state",))
    for kind in ("folder", "file", "notebook"):
        for source in (untouched, untouched.replace(number, f"2 * {number}")):
            path = tmp_path / f"{kind}{len(source)}"
            if kind == "folder":
                write(path, estimate_state=source)
            elif kind == "file":
                path = path.with_suffix(".py")
                path.write_text(source)
            else:
                path = notebook(path.with_suffix(".ipynb"), f"%matplotlib inline\n{source}")
            if source == untouched:
                assert "is the template, untouched" in str(failure(path, rules))
            else:
                with loaded_slots(sent(path, rules), rules) as own:
                    assert [*own] == ["estimate_state"]


def test_a_method_alone_that_is_another_is_work(tmp_path):
    begun = tmp_path / "mine"
    TASKS["identify"]().begin(begun)
    rules = Rules(slots=TASKS["identify"].slots, masked=TASKS["identify"].masked)
    file = begun / "init_parameter_estimator.py"
    file.write_text(file.read_text().replace("return self.theta", "return self.theta + phi"))
    with loaded_slots(sent(begun, rules), rules) as callbacks:
        assert len(callbacks) == 2
    file.unlink()
    (begun / "estimate_parameters.py").write_text(
        "def estimate_parameters(step):\n    return step.estimator.update(step.sample.phi, 1)\n"
    )
    assert "own estimator" in str(failure(begun, rules))


GIVEN = {"task.py": b"GOAL = 3\n", "table.csv": b"1,2\n"}
WITH_TASK = "from task import GOAL\ndef control(step):\n    return GOAL, 0\n"


def test_given_files_lie_beside_each_form_of_submission_in_place_of_copies(tmp_path):
    (tmp_path / "s002.py").write_text(WITH_TASK)
    for path in (
        write(tmp_path / "s001", control=WITH_TASK),
        tmp_path / "s002.py",
        packed(tmp_path / "s003.zip", {"s003/control.py": WITH_TASK}),
        notebook(tmp_path / "s004.ipynb", *WITH_TASK.split("\n", 1)),
        write(tmp_path / "s005", control=WITH_TASK, task="GOAL = 9\n"),
        write(tmp_path / "s006", solution=WITH_TASK, task="GOAL = 9\n"),  # one solution
    ):
        files = read_submission(path, CONTROL, GIVEN)
        assert files.sources["table.csv"] == b"1,2\n"
        with loaded_slots(files, CONTROL) as callbacks:
            assert callbacks["control"](None) == (3, 0)


def test_what_fails_at_the_start_is_told_with_its_line(tmp_path):
    for source, words, line in (
        ("x = 1\n1 / 0\n", "ZeroDivisionError: division by zero", 2),
        ("import not_there\n", "ModuleNotFoundError: No module named 'not_there'", 1),
        ("raise SystemExit\n", "SystemExit", 1),
        ("def control(a, b): ...\n", "one argument", None),
        ("control = 3\n", "got 3", None),
        ("def contol(step): ...\n", "contol", None),
        ("ENABLED = 1\n", "ENABLED", None),
        ("async def control(step): ...\n", "async def", None),
    ):
        error = failure(write(tmp_path / "s001", control=source))
        assert words in str(error)
        assert (error.slot, error.whose) == ("control", "submission")
        if line:
            assert (error.file, error.line) == ("control.py", line)
    (tmp_path / "mine.py").write_text("raise SystemExit\ncontrol = 3")
    assert failure(tmp_path / "mine.py").whose == "submission"


MASKED = Rules(slots=("control",), masked=("robsim.estimation.reference", "fractions"))


def test_what_is_masked_cannot_be_had(tmp_path):
    for line in (
        "import robsim.estimation.reference",
        "import robsim.estimation.reference as r",
        "from robsim.estimation import reference",
        "from robsim.estimation.reference import ExtendedKalmanFilter",
        "import robsim.estimation.reference.kalman",
        "from robsim.estimation.reference import _kalman",
        "import robsim\nrobsim.estimation.reference",
        "import importlib\nimportlib.import_module('robsim.estimation.reference')",
        "import importlib\nimportlib.import_module('robsim.estimation.reference.kalman')",
        "__import__('robsim.estimation.reference')",
    ):
        error = failure(write(tmp_path / "s001", control=f"{line}\n{PLAIN}"), MASKED)
        assert "NotHereError: robsim.estimation.reference is unavailable" in str(error)
        assert error.line == 1 + line.count("\n")
        late = f"def control(step):\n    {line.replace(chr(10), chr(10) + '    ')}\n"
        files = sent(write(tmp_path / "s002", control=late), MASKED)
        masked = pytest.raises(ImportError, match=r"robsim\.estimation\.reference is unavailable")
        with loaded_slots(files, MASKED) as callbacks, masked:
            callbacks["control"](None)
        assert importlib.import_module("robsim.estimation.reference") is robsim.estimation.reference


@pytest.mark.parametrize("home", ["robsim", "robsim.vision"])
@pytest.mark.parametrize("is_loaded", [True, False])
def test_a_masked_function_cannot_be_had(tmp_path, monkeypatch, home, is_loaded):
    module = importlib.import_module(home)
    if is_loaded:
        assert module.locate
    else:
        monkeypatch.delitem(vars(module), "locate", raising=False)
    rules = Rules(slots=("control",), masked=(f"{home}.locate",))
    for use in (f"{home}.locate()", f"{home}.locate(None)", f"{home}.locate.__doc__"):
        source = f"import {home}\n\n\ndef control(step):\n    {use}\n"
        files = sent(write(tmp_path / "s001", control=source), rules)
        with loaded_slots(files, rules) as callbacks:
            with pytest.raises(ImportError, match=f"{home}.locate is unavailable"):
                callbacks["control"](None)
            robsim.Simulation(measure=True).run(2)  # robsim itself has it
    error = failure(write(tmp_path / "s002", control=f"from {home} import locate\n{PLAIN}"), rules)
    assert f"{home}.locate is unavailable" in str(error)
    assert module.locate.__name__ == "locate"
    assert robsim.locate is robsim.vision.locate


LOCATE = ("robsim.locate", "robsim.vision.locate")


@pytest.mark.parametrize("masks", [LOCATE[:1], LOCATE[1:], LOCATE, TASKS["measure"].masked])
def test_a_mask_holds_at_the_top_and_in_the_wing(tmp_path, monkeypatch, masks):
    rules = Rules(slots=("control",), masked=masks)
    for home in ("robsim", "robsim.vision"):
        monkeypatch.delitem(vars(robsim), "locate", raising=False)
        source = f"import robsim\n\n\ndef control(step):\n    {home}.locate(None)\n"
        files = sent(write(tmp_path / "s001", control=source), rules)
        with loaded_slots(files, rules) as callbacks, pytest.raises(ImportError, match="unavail"):
            callbacks["control"](None)
        assert robsim.locate.__name__ == "locate"
    harmless = f"from robsim import __version__\n{PLAIN}"
    assert answer(write(tmp_path / "s002", control=harmless), rules) == (1, 2)


@pytest.mark.parametrize(
    "source",
    [
        "from robsim._core import locate",
        "from robsim import _core",
        "import sys\nlocate = vars(sys.modules['robsim._core'])['locate']\nlocate(None)",
        "import robsim\nrobsim.Experiment([], measure=True)",
        "from robsim.simulation.simulation import Simulation\nSimulation()",
        "import robsim.simulation.simulation as s\ns.Simulation()",
    ],
)
def test_a_mask_takes_the_object_wherever_it_lies(tmp_path, source):
    rules = Rules(slots=("control",), masked=TASKS["measure"].masked)
    folder = write(tmp_path / "s001", control=f"{source}\n{PLAIN}")
    assert "is unavailable" in str(failure(folder, rules))
    assert robsim.Simulation(measure=True).run(2).seen.any()


@pytest.mark.parametrize(
    "source",
    [
        "exec(inspect.getsource(robsim.control.path_following), {'__name__': 'mine'})",
        "exec(compile(pathlib.Path(FILE).read_text(), 'mine.py', 'exec'), {'__name__': 'mine'})",
        "spec = importlib.util.spec_from_file_location('mine', FILE)\n"
        "spec.loader.exec_module(importlib.util.module_from_spec(spec))",
        "code = compile(pathlib.Path(FILE).read_text(), FILE, 'exec')\n"
        "parts = [part for part in code.co_consts if isinstance(part, types.CodeType)]\n"
        "[types.FunctionType(part, {}) for part in parts]",
    ],
)
def test_a_mask_is_of_code_too(tmp_path, source):
    rules = Rules(slots=("control",), masked=TASKS["follow"].masked)
    imports = "import importlib.util, inspect, pathlib, types\nimport robsim\n"
    code = f"{imports}FILE = {path_following.__file__!r}\n{source}\n{PLAIN}"
    assert "copy of robsim." in str(failure(write(tmp_path / "s001", control=code), rules))
    exec(inspect.getsource(path_following), {"__name__": __name__})  # outside it is allowed


def test_a_masked_function_written_out_is_a_copy_whatever_its_variables_are_called(tmp_path):
    rules = Rules(slots=("control",), masked=TASKS["follow"].masked)
    source = inspect.getsource(path_following).replace("position", "place").replace("ahead", "on")
    folder = write(tmp_path / "s001", control=f"{source}\n{PLAIN}")
    assert "copy of robsim." in str(failure(folder, rules))


def test_a_subclass_of_a_masked_class_is_it_by_another_name(tmp_path):
    rules = Rules(slots=("control",), masked=TASKS["follow"].masked)
    drives = "sys.modules['robsim.control.path_following']._Drive.__subclasses__()"
    find = f"next(kind for kind in {drives} if kind.__name__ == 'FollowPath')"
    code = f"import sys\nclass Mine({find}):\n    pass\ncontrol = Mine([(300, 300)])\n"
    files = sent(write(tmp_path / "s001", control=code), rules)
    words = r"control is a robsim\.FollowPath by another name"
    with pytest.raises(SubmissionError, match=words), loaded_slots(files, rules):
        pass
    with pytest.raises(ValueError, match="by another name"):
        try_solution(task("follow"), tmp_path / "s001", runs=1)


def test_masks_hold_while_other_threads_import(tmp_path, monkeypatch):
    class Name(str):
        def __format__(self, spec):
            sys.modules["imported_meanwhile"] = sys
            return str(self)

    monkeypatch.setitem(sys.modules, Name("a_first_name"), sys)
    try:
        assert answer(write(tmp_path / "s001", control=PLAIN), MASKED) == (1, 2)
        assert "imported_meanwhile" in sys.modules
    finally:
        sys.modules.pop("imported_meanwhile", None)


def test_only_what_is_allowed_can_be_imported(tmp_path):
    rules = Rules(slots=("control",), imports=("math", "numpy"))
    source = "import math\nimport numpy.linalg\nfrom helper import A\n" + PLAIN
    folder = write(tmp_path / "s001", control=source, helper="from math import pi as A")
    assert answer(folder, rules) == (1, 2)
    folder = write(tmp_path / "s002", control="import os.path\n" + PLAIN)
    error = failure(folder, rules)
    assert "os may not be imported" in str(error)
    folder = write(tmp_path / "s003", control="import helper\n" + PLAIN, helper="import json")
    assert "json may not be imported" in str(failure(folder, rules))
    path = notebook(tmp_path / "s004.ipynb", "import json", "def control(step):\n    json.x")
    assert "json may not be imported" in str(failure(path, rules))
    # What a library needs in its turn is its own affair.
    source = (
        "import numpy as np\n\n\ndef control(step):\n    return np.polyfit([0, 1], [0, 1], 1)\n"
    )
    assert answer(write(tmp_path / "s005", control=source), rules).shape == (2,)


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


# --- in a worker


WORLD = robsim.Scenario(measure=True, robot="lab", resolution=(240, 240))


def inputs(path, **options):
    return (
        Submission(path, slots="control", limits=PATIENT, **options)
        .run(WORLD, seed=3, steps=4)
        .u.tolist()
    )


def failure_in_a_worker(path, **options):
    with pytest.raises(SubmissionError) as caught:
        inputs(path, **options)
    return caught.value


@pytest.mark.long
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


@pytest.mark.long
def test_names_of_files_reach_no_message_as_they_are(tmp_path):
    for name in ("\x1b[31m\n.py", "\u202egnp.py", "-rf.py", "a\x07.py"):
        (tmp_path / name).write_text("1 / 0\ndef control(step): return 0, 0\n")
        with pytest.raises(SubmissionError) as failed:
            inputs(tmp_path / name)
        assert str(failed.value).isprintable()


@pytest.mark.long
def test_a_notebook_that_fails_is_told_by_cell_and_line(tmp_path):
    cells = (
        "import math\n\n\ndef helper(k):\n    return 1 / (2 - k)",
        "control = lambda s: (0, helper(s.k))",
    )
    error = failure_in_a_worker(notebook(tmp_path / "s001.ipynb", *cells))
    told = (error.slot, error.step, error.file, error.line)
    assert told == ("control", 2, "s001.ipynb, cell 1", 5)
    assert "ZeroDivisionError: division by zero" in str(error)


@pytest.mark.long
def test_data_files_are_there(tmp_path):
    source = (
        "from pathlib import Path\n\nHERE = Path(__file__).parent\n"
        "U = float((HERE / 'data/left.txt').read_text()), float(open('right.txt').read())\n"
        "\n\ndef control(step):\n    return U\n"
    )
    files = {"control.py": source, "data/left.txt": "0.25", "right.txt": "0.75"}
    assert inputs(packed(tmp_path / "s001.zip", files)) == [[0.25, 0.75]] * 4


@pytest.mark.long
def test_what_is_masked_is_told_in_a_worker(tmp_path):
    body = "    return robsim.estimation.reference.nothing\n"
    source = f"import robsim\n\n\ndef control(step):\n{body}"
    hidden = "robsim.estimation.reference"
    error = failure_in_a_worker(write(tmp_path / "s001", control=source), masked=[hidden])
    assert (error.step, error.file, error.line) == (0, "control.py", 5)
    assert "robsim.estimation.reference is unavailable" in str(error)
