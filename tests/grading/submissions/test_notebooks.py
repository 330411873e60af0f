"""Callbacks out of notebooks: what counts, what is refused, what never runs."""

import json
import sys
import traceback
from pathlib import Path

import pytest

import robsim
from robsim.teach import SubmissionError
from submissions import (
    BOTH,
    CONTROL,
    PLAIN,
    Rules,
    answer,
    loaded_slots,
    notebook,
    read_submission,
    refused,
    sent,
)

OURS = Path(robsim.__file__).parent / "notebooks"
DRIVE = "class Drive:\n    def __call__(self, step):\n        return 1, 2"
READS = "def control(step): return K"
FORBIDDEN = 'raise SystemExit("this cell must not run")'


def gives(path, *cells, rules=CONTROL, **options):
    return answer(notebook(path / "s001.ipynb", *cells, **options), rules)


def says(path, *cells, rules=CONTROL, **options):
    error = refused(notebook(path / "s001.ipynb", *cells, **options), rules)
    assert str(error).isprintable()
    return str(error)


DEF = "def drive(step):\n    return 1, 2"


@pytest.mark.parametrize(
    "cells",
    [
        ("def control(step):\n    return 1, 2",),
        ("@sim.control\n" + DEF,),
        ("@sim.control\ndef control(step):\n    return 1, 2", "sim.run(10)"),
        (DEF, "sim.control = drive\nsim.run(10)"),
        (DEF, "old = sim.control = drive"),
        (DEF, "sim.control = drive", "sim.control = drive"),
        ("control = lambda step: (1, 2)", "sim.control = control"),
        (DEF, "sim = robsim.Simulation(control=drive, seed=1)", "Simulation(control=drive)"),
        (DEF, "for s in range(3):\n    Simulation(control=drive)"),
        (DRIVE, "sim.control = Drive()"),
        (DRIVE, "control = Drive()"),
        ("def drive(step):\n    step and step.run()\n    return 1, 2", "control = drive"),
        ("def make(u):\n    return lambda step: (u, 2)", "sim.control = make(1)"),
        ("import robsim\nsim.control = robsim.Spin() and (lambda step: (1, 2))",),
        ("async def other(): ...\ndef control(step):\n    return 1, 2", "await other()"),
        ("from __future__ import annotations", "def control(step: NotThere):\n    return 1, 2"),
        pytest.param(
            ("type Two = tuple[float, float]", "def control(step) -> Two:\n    return 1, 2"),
            marks=pytest.mark.skipif(
                sys.version_info < (3, 12), reason="a statement of Python 3.12"
            ),
        ),
    ],
)
def test_a_slot_is_found_by_name(tmp_path, cells):
    assert tuple(gives(tmp_path, *cells, FORBIDDEN)) == (1, 2)


def test_what_a_slot_needs_comes_with_it_and_nothing_else(tmp_path):
    assert gives(
        tmp_path,
        "import math, json\nimport not_there",
        "from collections import deque\nGAINS = {'a': 1.0}\nLOG = []\nUNUSED = open('/etc/passwd')",
        "def scaled(x):\n    return x * FACTOR[0]\n\n\ndef show(sim):\n    not_there.plot(sim)",
        "FACTOR = [1, 1]\nFACTOR[0] = 2\nGAINS['b'] = GAINS['a'] * 2",
        "GAINS.update(c=math.floor(3.5))",
        "K = 5\nK += 1\nM, N = deque([7]), 8",
        "if K > 3:\n    BIG = True\nelse:\n    BIG = False",
        "table = []\nfor i in range(3):\n    table.append(i)",
        "sim = robsim.Simulation()\ntrace = sim.run(100)\nplt.plot(trace.u)",
        "for i in range(9):\n    sim.step()",
        "def control(step):\n    return [scaled(GAINS['b']), GAINS['c'], K, M[0], N, BIG, table]",
    ) == [4, 3, 6, 7, 8, True, [0, 1, 2]]


def test_line_numbers_are_those_of_the_cell(tmp_path):
    path = notebook(
        tmp_path / "s003.ipynb",
        "import math",
        "%matplotlib inline\n!ls\n\ndef control(step):\n    return helper(step)",
        "x = 1\n\ndef helper(step):\n    # a line\n    return 1 / 0",
    )
    with loaded_slots(sent(path), CONTROL) as callbacks, pytest.raises(ZeroDivisionError) as caught:
        callbacks["control"](None)
    told = traceback.extract_tb(caught.tb)[1:]
    frames = [(frame.filename, frame.lineno, frame.line) for frame in told]
    assert frames == [
        ("s003.ipynb, cell 2", 5, "return helper(step)"),
        ("s003.ipynb, cell 3", 5, "return 1 / 0"),
    ]


def test_markdown_cells_count_in_the_numbers(tmp_path):
    path = notebook(tmp_path / "s001.ipynb", "x = 1", "def control(step):\n    return (")
    content = json.loads(path.read_text())
    content["cells"].insert(0, {"cell_type": "markdown", "metadata": {}, "source": "# Hello"})
    path.write_text(json.dumps(content))
    error = refused(path)
    assert str(error).startswith("s001.ipynb, cell 3, line 2: '(' was never closed")
    assert (error.file, error.line) == ("s001.ipynb, cell 3", 2)


TWO = ("def control(step):\n    return 1, 1", "def control(step):\n    return 2, 2", FORBIDDEN)


def test_tags_decide(tmp_path):
    assert gives(tmp_path, *TWO, tags={1: "robsim"}) == (1, 1)
    assert gives(tmp_path, *TWO, tags={2: "Robsim "}) == (2, 2)
    assert gives(tmp_path, *TWO, tags={1: "robsim-skip"}) == (2, 2)
    assert gives(tmp_path, "# robsim: mine\n" + TWO[0], *TWO[1:]) == (1, 1)
    assert gives(tmp_path, TWO[0], "# robsim-skip\n" + TWO[1]) == (1, 1)
    whole = "U = []\nwhile len(U) < 2:\n    U.append(4)\nsim.control = lambda step: U"
    assert gives(tmp_path, whole, *TWO, tags={1: "robsim"}) == [4, 4]
    assert "more than one value" in says(tmp_path, *TWO, tags={1: "robsim", 2: "robsim"})
    assert "more than one value" in says(tmp_path, *TWO, tags={3: "robsim"})
    assert gives(tmp_path, TWO[0], "nonlocal a", "x = (", tags={1: "robsim"}) == (1, 1)


def test_a_tag_for_one_slot_leaves_the_other_to_the_rule(tmp_path):
    cells = (*TWO, "def measure(step):\n    return 3")
    for added, slots in (((), ("control", "measure")), (("x = (",), ("control",))):
        path = notebook(tmp_path / "s001.ipynb", *cells, *added, tags={1: "robsim"})
        found = read_submission(path, BOTH)
        assert found.slots == slots
        assert bool(added) == ("cell 5, line 1" in found.notes[-1])
        assert answer(path, BOTH) == (1, 1)


def test_a_cell_with_a_tag_counts_whole_and_what_it_needs_with_it(tmp_path):
    cells = ("K = []", "while len(K) < 2:\n    K.append(3)", READS)
    assert gives(tmp_path, *cells, FORBIDDEN, tags={2: "robsim"}) == [3, 3]
    assert gives(tmp_path, "globals()['K'] = 3", READS, FORBIDDEN, tags={1: "robsim"}) == 3
    assert gives(tmp_path, "K = 1", "K = 2", READS, tags={1: "robsim"}) == 1
    text = says(tmp_path, "sim = Simulation()", "t = sim.run(3)", PLAIN, tags={2: "robsim"})
    assert "cell 2 needs sim" in text
    with pytest.raises(SubmissionError, match="cell 2, line 1: no cell that counts gives L"):
        gives(tmp_path, "K = 3", READS.replace("K", "L"), tags={1: "robsim"})


def test_two_values_are_refused_with_their_cells(tmp_path):
    for cells, words in (
        (TWO, ["cell 1, line 1 (def control(step):)", "cell 2, line 1 (def control(step):)"]),
        (("sim.control = lambda s: 1", "sim.control = lambda s: 2"), ["cell 1", "cell 2"]),
        (
            ("def f(s): ...", "def f(s): ...\nsim.control = f"),
            ["cell 1, line 1 (def f", "cell 2, line 1 (def f"],
        ),
        (
            ("class F:\n    pass", "class F:\n    pass", "sim.control = F()"),
            ["cell 1, line 1 (class F:)", "cell 2, line 1 (class F:)"],
        ),
        (("Simulation(control=f)", "Simulation(control=g)"), ["(Simulation(control=f))", "cell 2"]),
        (("control = F(1)", "control = F(2)"), ["(control = F(1))", "(control = F(2))"]),
        ([f'sim.control = f"""a\n{{{i}}}"""' for i in range(2)], ["cell 1", "cell 2"]),
    ):
        text = says(tmp_path, *cells)
        assert "control has more than one value" in text
        assert all(each in text for each in words), text
        assert "robsim-skip" in text


def test_a_slot_of_its_own_counts_more_than_an_argument_and_that_is_noted(tmp_path):
    path = notebook(tmp_path / "s001.ipynb", PLAIN, "Simulation(control=robsim.Spin())")
    counted, left = read_submission(path, CONTROL).notes
    assert counted == "s001.ipynb: these cells count: 1"
    assert "cell 2, line 1 (Simulation(control=robsim.Spin())) does not count" in left


def test_what_exists_only_by_running_a_cell_is_told(tmp_path):
    for cells, needs, where in (
        (("t = sim.run(10)", "def control(step):\n    return t.u[0]"), "t; t", "cell 1, line 1"),
        (
            ("sim = Simulation()", "t = sim.run(3)\nK = t.u[0]", "def control(s): return K"),
            "K, which needs t; t",
            "cell 2, line 1",
        ),
        (("K = [1]", "while True:\n    K[0] += 1", READS), "K; K", "cell 2, line 1"),
        (("def tune():\n    return sim.run(9)", "K = tune()", READS), "K; K", "cell 2, line 1"),
        (
            ("for f in (1, 2):\n    sim.run(f)\n    Simulation(control=lambda s: (f, f))",),
            "f; f",
            "cell 1, line 1",
        ),
        (("with SerialMotors() as m:\n    K = m.read()", READS), "K; K", "cell 1, line 1"),
        (("K = input('gain?')", READS), "K; K", "cell 1, line 1"),
        (("K = await f()", READS), "K; K", "cell 1, line 1"),
    ):
        text = says(tmp_path, *cells)
        assert f"control needs {needs}" in text
        assert f"only by running {where}" in text


def test_names_of_a_star_import_count(tmp_path):
    given = {"task.py": b"GOAL = 7\nsum = max"}
    for cells, expected in (
        (("from task import *", "def control(step):\n    return GOAL"), 7),
        (("from task import *", "def control(step):\n    return sum([1, 2])"), 2),
        (("from task import *", "GOAL = 8", "def control(step):\n    return GOAL"), 8),
        (("from math import *\nR = floor(3.5)", "control = lambda step: R"), 3),
        (("from not_there import *", "def control(step):\n    return 4"), 4),
    ):
        path = notebook(tmp_path / "s001.ipynb", *cells, FORBIDDEN)
        files = read_submission(path, CONTROL, given)
        with loaded_slots(files, CONTROL) as callbacks:
            assert callbacks["control"](None) == expected
    for first, words in (
        ("from task import *", "cell 3, line 2: no cell that counts gives GAOL a value"),
        ("from task import *\nK = GAOL", "cell 1, line 2: NameError"),
        ("from not_there import *", "cell 1, line 1: ModuleNotFoundError"),
        ("from not_there import *\nK = GAOL", "cell 1, line 1: ModuleNotFoundError"),
    ):
        cells = (first, "K = 1" if "K" not in first else "", "def control(step):\n    GAOL, K")
        path = notebook(tmp_path / "s001.ipynb", *cells)
        files = read_submission(path, CONTROL, given)
        with pytest.raises(SubmissionError, match=words), loaded_slots(files, CONTROL):
            pass


@pytest.mark.parametrize(
    "cell",
    [
        "globals()['K'] = 3",
        "exec('K = 3')",
        "%run helper.py",
        "%%time\n# robsim-skip\nL = 3",
        "def init():\n    global K\n    K = 3\n\n\ninit()",
        "x = 1",
    ],
)
def test_a_name_without_a_value_is_refused_with_cell_and_line(tmp_path, cell):
    path = notebook(tmp_path / "s001.ipynb", cell, "def control(step):\n    x = 1\n    return K")
    error = refused(path)
    assert (error.file, error.line) == ("s001.ipynb, cell 2", 3)
    assert "no cell that counts gives K a value" in str(error)
    assert "tag the cell" in str(error)


def test_names_that_need_no_cell_are_not_refused(tmp_path):
    state = "global k\n    k += 1\n    return k"
    assert gives(tmp_path, "k = 0", f"def control(step):\n    {state}") == 1
    state = "global k\n    k = 2\n    return k"
    assert gives(tmp_path, f"def control(step):\n    {state}") == 2
    shown = "class Drive:\n    def show(self):\n        display(self)\n\n    "
    assert gives(
        tmp_path, f"{shown}def __call__(self, step):\n        return 1", "control = Drive()"
    )
    lazy = "@sim.control\ndef _(step):\n    return 1", "@sim.measure\ndef _(step):\n    return 2"
    assert gives(tmp_path, *lazy, rules=BOTH) == 1
    other = (
        "import math as control",
        f"{DRIVE.replace('1, 2', 'control.pi')}\nsim.control = Drive()",
    )
    assert gives(tmp_path, *other) > 3


def test_notes_say_which_cells_count_and_which_calls_do_not(tmp_path):
    path = notebook(
        tmp_path / "s001.ipynb",
        "import not_there",
        "%matplotlib inline\nimport math\nprint(math.pi)",
        "class Drive:\n    def __call__(self, step):\n        return math.pi",
        "drive = Drive()\ndrive.tune(3)\ndrive.plot(trace)\nmath.sqrt(2)",
        "sim.control = drive",
    )
    counted, left = read_submission(path, CONTROL).notes
    assert counted == "s001.ipynb: these cells count: 2 (in part), 3, 4 (in part), 5"
    assert "cell 4, line 2 (drive.tune(3)) does not count" in left


def test_commands_of_the_notebook_never_run(tmp_path):
    for cell in (
        "%matplotlib inline",
        "!pip install robsim",
        "!echo it's (",
        "robsim.Simulation?\n?robsim",
        "files = !ls\nt = %timeit -o f()",
        "if 1:\n    %time x = 1",
        "%%bash\nrm -rf /",
        "%%writefile control.py\ndef control(step:",
        "x = '''\n%d of %d\n!\n'''\ny = (7\n % 3)",
    ):
        assert gives(tmp_path, cell, PLAIN, cell) == (1, 2)
        assert gives(tmp_path, f"{cell}\n", f"%%time\n{PLAIN}") == (1, 2)
    assert "(%%writefile control.py) does not count" in says(
        tmp_path, f"%%writefile control.py\n{PLAIN}"
    )


def test_texts_of_a_cell_keep_their_percent_signs_and_real_mistakes_are_told(tmp_path):
    cell = 'TEXT = """\n%d\n!ls\n"""\nREST = (7\n    % 4)\ndef control(s): return TEXT, REST'
    assert gives(tmp_path, cell) == ("\n%d\n!ls\n", 3)
    assert "cell 2, line 2: '(' was never closed" in says(tmp_path, PLAIN, "%pylab\nx = (1")


def test_the_value_that_can_be_written_down_is_named(tmp_path):
    text = says(
        tmp_path,
        "trace = sim.run(9)\nmeasured = errors(trace)\nR = measured.sd ** 2",
        "class Filter:\n    def __call__(self, step):\n        return update(step)",
        "def update(step):\n    return R",
        "control = Filter()",
    )
    chain = ("update", "R", "measured", "trace")
    assert ", which ".join(f"needs {name}" for name in chain) in text
    assert "running cell 1, line 1 (trace = sim.run(9))" in text
    assert "Give R a value" in text


def test_each_slot_has_what_it_needs(tmp_path):
    path = notebook(
        tmp_path / "s001.ipynb",
        "GAIN = 2\nSIGMA = sim.run(3).sd",
        "@sim.control\ndef drive(step):\n    return GAIN, GAIN",
        "@sim.measure\ndef see(step): ...",
        "sim.estimate_state = Filter(SIGMA)",
    )
    assert read_submission(path, BOTH).slots == ("control", "measure")
    assert answer(path, BOTH) == (2, 2)
    text = str(refused(path, Rules(slots=("control", "estimate_state"))))
    assert "estimate_state needs SIGMA; SIGMA gets its value only by running cell 1, line 2" in text


@pytest.mark.long
def test_our_own_notebooks(tmp_path):
    """As they ship: what has one value is taken, what has more is refused, and not guessed."""

    def ours(name, slot):
        (path,) = OURS.glob(f"{name}_*.ipynb")
        return path, Rules(slots=(slot,))

    path, rules = ours("12", "evaluate_model")
    with loaded_slots(sent(path, rules), rules) as callbacks:
        assert callbacks["evaluate_model"].__name__ == "with_load"
    text = str(refused(*ours("02", "control")))
    assert "line 5 (def drive_on(step):)" in text
    assert "line 1 (def slow_down(step):)" in text
    assert "only by running cell 4" in str(refused(*ours("07", "estimate_state")))
    robsim.teach.copy_notebooks(tmp_path / "solved", solutions=True)
    content = json.loads((tmp_path / "solved/02_park.ipynb").read_text())
    (cell,) = (one for one in content["cells"] if "def slow_down(" in "".join(one["source"]))
    cell["metadata"]["tags"] = ["robsim-skip"]
    (tmp_path / "s001.ipynb").write_text(json.dumps(content))
    with loaded_slots(sent(tmp_path / "s001.ipynb"), CONTROL) as callbacks:
        sim = robsim.Simulation(robot="lab", measure=True, start=(500, 500, 0), **callbacks)
        assert sim.run(3).u.any()


def test_what_is_no_notebook(tmp_path):
    code = '{"nbformat": 4, "cells": [{"cell_type": "code", "source": %s}]}'
    for content, words in (
        ("", "no JSON"),
        ("9" * 100_000, "is not a notebook"),
        ("[" * 100_000, "no JSON"),
        ("[" * 1_000_000, "too complex"),
        ("[]", "format"),
        ('{"nbformat": 3}', "format 3"),
        ('{"nbformat": 4}', "list of cells"),
        (code % "3", "cell 1 has no text"),
        (code % '"\\ud800"', "UTF-8"),
        ('{"nbformat": 4, "metadata": {"kernelspec": {"language": "R"}}, "cells": []}', "'R'"),
        ('{"nbformat": 4, "cells": []}', "fills no slot"),
        ('{"nbformat": 4, "cells": [' + "{}," * 1000 + "{}]}", "more than 1000 cells"),
    ):
        (tmp_path / "s001.ipynb").write_text(content)
        assert words in str(refused(tmp_path / "s001.ipynb"))


def test_outputs_do_not_count(tmp_path):
    path = notebook(tmp_path / "s001.ipynb", PLAIN)
    content = json.loads(path.read_text())
    content["cells"][0]["outputs"] = [{"data": {"image/png": "A" * 4_000_000}}]
    path.write_text(json.dumps(content))
    found = read_submission(path, CONTROL)
    assert sum(map(len, found.sources.values())) < 1000
    content["cells"][0]["outputs"] *= 2
    path.write_text(json.dumps(content))
    assert "more than 5 MiB" in str(refused(path))
    assert "more than 1 MiB of code" in says(tmp_path, PLAIN, "#" + "x" * 1_100_000)


@pytest.mark.long
def test_notebooks_that_keep_parsers_busy_are_refused(tmp_path):
    for source in (
        *("x\n" * 6_000, "x = " + "-" * 50_000 + "1", "x" + "()" * 30_000, "a." * 1000 + "a"),
        *("!x\n" * 20_000, "\n".join(f"def f{i}(): f{i + 1}()" for i in range(5_500))),
        *("x = " + "(" * 199 + ")" * 199 + "\n" * 9, "1 if 1 else " * 20_000 + "1"),
    ):
        says(tmp_path, source, "y")
