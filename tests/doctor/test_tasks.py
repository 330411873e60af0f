"""The doctor and tasks: whether a folder solves one, what is short, and why."""

import json
import textwrap

import numpy as np
import pytest

import robsim
from commands import command
from robsim.doctor import TaskReport, check_folder
from robsim.doctor._callbacks.scenes import Setting
from robsim.tasks import TASKS, EstimateState, Identify, Measure, Park

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
        "input_late": "prediction",
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
SHIPPED = [(name, one) for name, kind in TASKS.items() for one in kind().solutions]


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
    report = check_folder(folder_of(tmp_path, solution.files), task=name)
    assert report.is_solved == solution.is_right
    if solution.is_right:
        assert report.ok, report.sentences
        assert not report.short
    else:
        assert not report.ok
        assert report.short
        assert report.problems[0].kind == CAUSES[name][solution.name], report.sentences


def test_a_page_says_what_is_short_and_why(tmp_path):
    task = EstimateState()
    folder = folder_of(tmp_path, shipped(task, "r_too_small") | {"control": "no Python"})
    report = check_folder(folder, task=task)
    assert isinstance(report, TaskReport)
    assert "does not solve the task estimate" in report.heading
    assert list(report.short) == ["position", "heading", "consistency"]
    assert report.trial.points == pytest.approx(task.try_out(folder, progress=False).points)
    assert report.verdicts["control"] == "not used"
    assert "control.py is not used: the task estimate asks for estimate_state.py" in report.remarks
    (problem,) = report.problems
    assert "R, the noise of the measurements, is too small" in problem.sentence
    assert problem.situation == f"run {report.trial.worst} of the task"
    run = command("check", str(folder), "--task", "estimate")
    assert run.exit_code == 1
    page = " ".join(run.stdout.split())
    assert "rms error of the heading: 1.39 times that of the reference" in page
    assert "what the runs of the task show 1. its estimates are 0.48 times as far" in page
    assert ["control", "not", "used"] in [line.split() for line in run.stdout.splitlines()]
    assert not [line for line in run.stdout.splitlines() if "default" in line]


def test_python_and_json_say_the_same(tmp_path):
    folder = folder_of(tmp_path, shipped(EstimateState(), "reference"))
    report = check_folder(folder, task="estimate")
    assert report
    assert report.heading.endswith("solves the task estimate: as good as the reference")
    run = command("check", str(folder), "--task", "estimate", "--json")
    assert run.exit_code == 0
    assert json.loads(run.stdout) == report.to_dict()
    assert report.to_dict()["points"] == 1
    assert "Check of" in report.title


def test_the_file_says_nothing_of_the_values_and_the_task_does(tmp_path):
    """What another sheet has said is not believed."""
    folder = folder_of(tmp_path, shipped(EstimateState(), "reference") | {"task": "AREA = None\n"})
    assert check_folder(folder, task=EstimateState(runs=2)).trial.failed == {}


def test_what_cannot_be_loaded_is_not_tried(tmp_path):
    folder = folder_of(tmp_path, {"control": "def control(step)\n    return 0, 0\n"})
    report = check_folder(folder, task="park")
    assert (report.trial, report.ok, report.is_solved) == (None, False, False)
    assert "was not tried on the task park: it cannot be loaded" in report.heading
    assert "not valid Python" in report.sentences[0]


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
    report = check_folder(folder_of(tmp_path, {"measure": late}), task=Measure(runs=2, steps=30))
    (failed,) = (one for one in report.findings if one.kind == "run fails")
    assert failed.sentence.startswith("2 of 2 runs end with an error: KeyError: 'late' (measure.py")


def test_a_file_that_is_switched_off_is_told(tmp_path):
    off = "ENABLED = False\n\n\ndef control(step):\n    return 0, 0\n"
    folder = folder_of(tmp_path, {"control": off})
    report = check_folder(folder, task=Park(steps=20, runs=1))
    assert report.verdicts["control"] == "default"
    assert "control.py is switched off: set ENABLED = True in it" in report.remarks


def test_what_is_masked_is_told(tmp_path):
    folder = folder_of(tmp_path, shipped(Measure(), "reference"))
    report = check_folder(folder, task=Measure(runs=1, steps=20))
    assert "measure.py has robsim.locate, which cannot be had where the task is graded" in (
        report.remarks
    )


@pytest.mark.parametrize(
    ("task", "error", "message"),
    [
        ("parc", ValueError, "there is no task 'parc': did you mean 'park'"),
        (Park, TypeError, "task must be a Task, or its name, got"),
        ("measure", ValueError, r"has no solution: it must have measure\.py"),
    ],
)
def test_what_cannot_be_is_refused(tmp_path, task, error, message):
    folder = folder_of(tmp_path, {"control": "def control(step):\n    return 0, 0\n"})
    with pytest.raises(error, match=message):
        check_folder(folder, task=task)


def test_a_setting_is_that_of_the_task():
    setting = Setting.of(Park().scenario)
    assert (setting.robot.name, setting.area, setting.resolution) == ("lab", (640, 640), (320, 320))
    assert setting.noise.percent == Park().noise
    scene = setting.turned("stands", (300, 900), [0.5])
    assert scene.poses.tolist() == [[160, 480, 0.5]]
    assert Setting.of(robsim.Scenario(noise=None)).noise == Setting.usual().noise
    assert (Setting.of(Measure().scenario).place((600, 600))) == (600, 600)


@pytest.mark.slow
def test_a_parameter_estimator_is_told_once(tmp_path):
    folder = folder_of(tmp_path, shipped(Identify(), "gain_sign"))
    report = check_folder(folder, task="identify")
    assert [problem.kind for problem in report.problems] == ["wrong sign"]
    assert np.isfinite(report.trial.points)
