"""The doctor and tasks: whether a folder solves one, what is short, and why."""

import json
import textwrap
import zipfile

import pytest

from commands import command
from robsim.teach import (
    TASKS,
    EstimateTask,
    IdentifyTask,
    MeasureTask,
    ParkTask,
    TaskReport,
    check_folder,
    try_solution,
)
from robsim.teach.submissions.imports import masked_in
from sizes import thorough
from submissions import notebook

pytestmark = pytest.mark.usefixtures("unhurried")

# What is found first of each of the wrong solutions that ship.
CAUSES = {
    "park": {
        "naive": "heading of the goal",
        "no_braking": "does not brake",
        "no_heading": "heading of the goal",
        "no_wrap": "heading not wrapped",
        "stops_short": "stops short",
        "swapped_motors": "motors exchanged",
        "too_much_voltage": "against the rules",
        "y_up": "y axis",
    },
    "follow": {
        "naive": "slow",
        "cuts_corners": "cuts corners",
        "no_braking": "does not brake",
        "no_wrap": "heading not wrapped",
        "slow": "slow",
        "swapped_motors": "motors exchanged",
    },
    "estimate": {
        "naive": "covariance does not grow",
        "half_the_measurements": "gain too small",
        "heading_not_wrapped": "heading not wrapped",
        "input_late": "inputs late",
        "no_input": "prediction",
        "no_q": "gain too small",
        "q_too_large": "gain too large",
        "r_too_large": "gain too small",
        "r_too_small": "gain too large",
        "stops_when_hidden": "covariance does not grow",
    },
    "identify": {
        "naive": "no adaptation",
        "constant_covariance": "gain stays",
        "every_second_sample": "leaves samples out",
        "forgets_fast": "windup",
        "gain_sign": "wrong sign",
        "gradient": "gain stays",
        "late_regressor": "sample mismatched",
        "one_covariance": "axes mixed",
        "small_initial_covariance": "does not settle",
    },
    "measure": {
        "naive": "red square",
        "box_centers": "inexact",
        "degrees": "heading in degrees",
        "half_pixel_off": "off by a constant",
        "hold_last": "last pose",
        "no_offset": "position of midpoint",
        "swapped_markers": "offset reversed",
        "whole_pixels": "inexact",
    },
}
# Of the right ones the first of each task, or all.
SHIPPED = [
    (name, one)
    for name, kind in TASKS.items()
    for one in kind().solutions
    if thorough(True, one.name == "reference") or not one.is_right
]


def folder_of(tmp_path, files):
    for name, source in files.items():
        content = source if isinstance(source, bytes) else textwrap.dedent(source).encode()
        (tmp_path / f"{name}.py").write_bytes(content)
    return tmp_path


def shipped(task, name):
    return next(one for one in task.solutions if one.name == name).files


def test_each_wrong_solution_has_a_cause():
    wrong = {name: {one.name for one in kind().solutions if not one.is_right}
             for name, kind in TASKS.items()}  # fmt: skip
    assert {name: {*causes} for name, causes in CAUSES.items()} == wrong
    assert sum(map(len, wrong.values())) == 41


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "solution"), SHIPPED, ids=[f"{name}-{one.name}" for name, one in SHIPPED]
)
def test_what_ships_is_told_apart_and_explained(tmp_path, name, solution):
    runs = thorough(10, 5 if name == "estimate" else 3)
    task = TASKS[name](runs=runs)
    report = check_folder(folder_of(tmp_path, solution.files), task=task)
    if masked_in(solution.files, task.masked):
        assert [one.kind for one in report.problems] == ["not handed in"]
        return
    assert report.is_solved == solution.is_right
    if solution.is_right:
        assert report.ok, report.sentences
        assert not report.short
    else:
        assert not report.ok
        assert report.short
        assert report.problems[0].kind == CAUSES[name][solution.name], report.sentences


def test_a_controller_with_another_goal_hears_the_goal_of_the_task(tmp_path):
    source = shipped(ParkTask(), "reference")["control"]
    other = source.replace(b"from task import GOAL", b"GOAL = (120.0, 480.0, 3.14)")
    assert other != source
    files = {**shipped(ParkTask(), "reference"), "control": other}
    report = check_folder(folder_of(tmp_path, files), task=ParkTask(runs=1))
    (found,) = (one for one in report.findings if one.kind == "another goal")
    assert "it stays at (1" in found.sentence
    assert "The goal of this task is (380, 300): from task import GOAL" in found.sentence


@pytest.fixture(scope="module")
def too_sure(tmp_path_factory):
    """A folder whose filter has too small an R, and a file that the task does not ask for."""
    files = shipped(EstimateTask(), "r_too_small") | {"control": "no Python"}
    return folder_of(tmp_path_factory.mktemp("too_sure"), files)


def test_a_page_says_what_is_short_and_why(too_sure):
    task = EstimateTask(runs=4)
    report = check_folder(too_sure, task=task)
    assert isinstance(report, TaskReport)
    assert not report.is_solved
    assert list(report.short) == ["position", "heading", "consistency"]
    assert report.trial.points == pytest.approx(try_solution(task, too_sure, progress=False).points)
    assert report.verdicts["control"] == "not used"
    assert any("control.py" in remark for remark in report.remarks)
    (problem,) = report.problems
    assert "R, the noise of the measurements, is too small" in problem.sentence
    assert problem.situation == f"run {report.trial.worst} of the task"


def test_the_command_gives_the_report(too_sure):
    report = check_folder(too_sure, task="estimate")
    run = command("check", str(too_sure), "--task", "estimate", "--json")
    assert run.exit_code == 1
    assert json.loads(run.stdout) == report.to_dict()
    page = command("check", str(too_sure), "--task", "estimate").stdout
    assert ["control", "not", "used"] in [line.split() for line in page.splitlines()]
    assert "default" not in page


def test_the_file_says_nothing_of_the_values_and_the_task_does(tmp_path):
    """What another sheet has said is not believed."""
    folder = folder_of(tmp_path, shipped(EstimateTask(), "reference") | {"task": "AREA = None\n"})
    assert check_folder(folder, task=EstimateTask(runs=2)).trial.failed == {}


def test_a_problem_of_an_estimator_is_reported_for_one_of_its_files(tmp_path):
    folder = folder_of(tmp_path, shipped(IdentifyTask(), "naive"))
    of_files = check_folder(folder).problems
    assert [problem.kind for problem in of_files] == ["no adaptation"] * 2
    problems = check_folder(folder, task=IdentifyTask(runs=1)).problems
    assert [problem for problem in problems if problem.kind == "no adaptation"] == [of_files[0]]


def test_what_cannot_be_loaded_is_not_tried(tmp_path):
    folder = folder_of(tmp_path, {"control": "def control(step)\n    return 0, 0\n"})
    report = check_folder(folder, task="park")
    assert (report.trial, report.ok, report.is_solved) == (None, False, False)
    assert report.problems[0].kind == "not loaded"


def test_runs_that_fail_are_told(tmp_path):
    late = """
        import robsim
        from task import DT
        calls = 0

        def measure(step):
            global calls
            calls += 1
            if calls == 25:
                raise KeyError("late")
            return None
        """
    report = check_folder(
        folder_of(tmp_path, {"measure": late}), task=MeasureTask(runs=2, steps=30)
    )
    (failed,) = (one for one in report.findings if one.kind == "run fails")
    assert all(word in failed.sentence for word in ("2 of 2", "KeyError: 'late'", "measure.py"))


def test_a_file_that_is_switched_off_is_told(tmp_path):
    off = "ENABLED = False\n\n\ndef control(step):\n    return 0, 0\n"
    folder = folder_of(tmp_path, {"control": off})
    report = check_folder(folder, task=ParkTask(steps=20, runs=1))
    assert report.verdicts["control"] == "default"
    assert any("ENABLED = True" in remark for remark in report.remarks)


def test_what_is_masked_is_told(tmp_path):
    folder = folder_of(tmp_path, shipped(MeasureTask(), "reference"))
    report = check_folder(folder, task=MeasureTask(runs=1, steps=20))
    assert any("robsim.locate" in problem.sentence for problem in report.problems)
    assert "robsim.locate" in report.headline


def test_what_cannot_be_is_refused(tmp_path):
    folder = folder_of(tmp_path, {"control": "def control(step):\n    return 0, 0\n"})
    with pytest.raises(ValueError, match="parc"):
        check_folder(folder, task="parc")
    with pytest.raises(TypeError, match="task"):
        check_folder(folder, task=ParkTask)
    with pytest.raises(ValueError, match=r"measure\.py"):
        check_folder(folder, task="measure")


def test_advice_names_nothing_that_is_masked(tmp_path):
    task = MeasureTask(runs=1, steps=20)
    task.begin(tmp_path)
    folder_of(tmp_path, shipped(task, "centroids"))
    assert "robsim.locate" in str(check_folder(tmp_path))
    advice = str(check_folder(tmp_path, task=task))
    assert "have no covariance" in advice
    assert not any(mask in advice for mask in task.masked)


@pytest.mark.parametrize(
    "call", ["def measure(step):\n    return robsim.lokate()", "robsim.lokate"]
)
def test_no_name_that_is_masked_is_suggested(tmp_path, call):
    folder = folder_of(tmp_path, {"measure": f"import robsim\n\n{call}\n"})
    alone, for_task = check_folder(folder), check_folder(folder, task=MeasureTask(runs=1, steps=9))
    for report, is_suggested in ((alone, True), (for_task, False)):
        assert ("'locate'" in str(report)) == is_suggested
        assert ("'locate'" in str(report.checks["measure"])) == is_suggested


@pytest.mark.parametrize("words", ["check", "check --task park", "tasks try park"])
def test_a_zip_is_refused_with_what_to_do(tmp_path, words):
    path = tmp_path / "hw.zip"
    with zipfile.ZipFile(path, "w") as packed:
        packed.writestr("control.py", "def control(step): return 0, 0")
    run = command(*words.split(), str(path))
    assert run.exit_code == 2
    assert f"{path} is a zip: unpack it, and name the folder" in run.stderr


def test_a_notebook_has_the_values_of_the_task_beside_it(tmp_path):
    ParkTask().begin(tmp_path)
    drives = "def control(step):\n    return GOAL[0] / 0, 0"
    file = notebook(tmp_path / "s1.ipynb", "from task import *", drives)
    (tmp_path / "control.py").unlink()
    for path in (file, tmp_path):
        problem = check_folder(path).problems[0]
        assert "ZeroDivisionError" in problem.sentence
        assert problem.line.place == "s1.ipynb, cell 2, line 2"


def test_a_notebook_without_a_needed_name_is_told_its_cell_alone(tmp_path):
    file = notebook(tmp_path / "s1.ipynb", "from math import *\ndef control(step): return K, K")
    (problem,) = check_folder(file).problems
    assert "s1.ipynb, cell 1, line 2: no cell that counts gives K" in problem.sentence
    assert problem.line is None  # the generated file has no line to look at


def test_a_notebook_is_checked_as_the_grader_takes_it(tmp_path):
    cells = ("x = 1", "print(1)\ndef control(step):\n    return 1, 1 / (5 - step.k)")
    file = notebook(tmp_path / "s1.ipynb", *cells)
    for report in (check_folder(file), check_folder(file, task=ParkTask(runs=1, steps=10))):
        problem = report.problems[0]
        assert problem.line.place == "s1.ipynb, cell 2, line 3"
        assert "ZeroDivisionError" in problem.sentence
        assert report.verdicts["control"] == "ill"
        assert report.name == str(file)
    page = command("check", str(file)).stdout
    assert "s1.ipynb, cell 2" in " ".join(page.split())
    assert "control.py" not in page
    two = notebook(tmp_path / "s2.ipynb", *cells, cells[1])
    for task in (None, "park"):
        with pytest.raises(ValueError, match=r"cell 2, line 2.*cell 3, line 2"):
            check_folder(two, task=task)
