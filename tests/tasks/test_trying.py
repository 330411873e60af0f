"""Trials: a solution in the runs of the reference, and what that comes to."""

from dataclasses import replace

import numpy as np
import pytest

import robsim
from robsim.teach import (
    FollowTask,
    MeasureTask,
    ParkTask,
    ScoreLimit,
    solution_folder,
    try_solution,
)
from robsim.teach.tasks import trial as _trying
from small_assignments import solution
from submissions import notebook

SHORT = {"steps": 40, "runs": 2}


class Calibration:
    """Limits as they ship, made by hand."""

    task_digest = "of another task"

    def __init__(self, **limits):
        self.limits = limits


@pytest.fixture(autouse=True)
def limits(monkeypatch):
    wide = {"position": 3, "heading": 3, "lost": 3}
    hand_made = {
        "measure": Calibration(**{n: ScoreLimit(full=f, zero=12) for n, f in wide.items()})
    }
    monkeypatch.setattr(_trying, "shipped_calibrations", lambda: hand_made)


def tried(task, *args, **options):
    return try_solution(task, *args, progress=False, **options)


def shipped(task, name):
    return next(one for one in task.solutions if one.name == name)


def test_the_reference_is_as_good_as_itself_and_naive_is_not(tmp_path):
    task = MeasureTask(**SHORT)
    own = tried(task, shipped(task, "reference"))
    assert any("default parameters" in remark for remark in own.remarks)
    assert own.verdict == "as good as the reference"
    assert set(own.statistics.values()) == {1.0}
    assert own.points == 1
    assert own.values == own.reference
    naive = tried(task, solution(tmp_path / "mine", "naive", "measure"))
    assert naive.verdict == "no better than a naive solution"
    assert naive.points < 0.1
    assert naive.reference == own.reference


def test_the_worst_run_is_drawn_beside_the_reference():
    task = MeasureTask(**SHORT)
    trial = tried(task, shipped(task, "whole_pixels"))
    assert trial.worst in (0, 1)
    losses = [trial.values["position"][i] / trial.reference["position"][i] for i in (0, 1)]
    assert trial.worst == int(np.argmax(losses))
    assert task.score(trial.trace)["position"] == trial.values["position"][trial.worst]
    assert np.array_equal(trial.trace.pose_true, trial.reference_trace.pose_true)
    assert len(trial.figure().axes) == 3


def test_a_file_and_a_folder_are_read_anew_and_told_the_values(tmp_path):
    file = tmp_path / "control.py"
    file.write_text("from task import GOAL\n\n\ndef control(step):\n    return GOAL[0] * 0, 0.5\n")
    (tmp_path / "task.py").write_text("GOAL = None  # what another task has said\n")
    task = ParkTask(steps=5, runs=1)
    trial = tried(task, file)
    assert trial.solution == "control.py"
    assert trial.trace.u[0].tolist() == [0, 0.5]
    file.write_text("def control(step):\n    return 0.1, 0.1\n")
    assert tried(task, tmp_path).trace.u[0].tolist() == [0.1, 0.1]


def test_a_class_is_made_anew_for_each_run():
    made = []

    class Counting:
        def __init__(self):
            self.calls = 0
            made.append(self)

        def __call__(self, step):
            self.calls += 1
            return 0.0, 0.1

    task = ParkTask(steps=5, runs=3)
    trial = tried(task, control=Counting)
    assert trial.solution == "Counting"
    assert {one.calls for one in made} <= {0, 5}  # one is made to look at it
    assert sum(one.calls == 5 for one in made) >= 3


def test_runs_that_fail_are_told_with_their_line():
    def broken(step):
        if step.k == 3 and step.measurement.pose[0] > 0:
            raise KeyError("speed")
        return 0.0, 0.0

    trial = tried(ParkTask(steps=5, runs=2, dropout=0), control=broken)
    assert trial.verdict == "fails"
    assert list(trial.failed) == [0, 1]
    assert "KeyError: 'speed' (test_trying.py:" in str(trial)
    assert np.isnan(list(trial.statistics.values())).all()
    with pytest.raises(ValueError, match="failed"):
        trial.figure()


def test_a_run_that_fails_takes_its_part_of_the_points():
    task = MeasureTask(steps=20, runs=4)
    with solution_folder(task, shipped(task, "reference")).callbacks() as callbacks:
        reference = callbacks["measure"]

    def measure(step):
        if step.k == 19 and step.frame.image[0, 0, 0] % 2:
            raise RuntimeError("sometimes")
        return reference(step)

    trial = tried(task, measure=measure)
    assert 0 < len(trial.failed) < 4
    assert trial.points == pytest.approx(1 - len(trial.failed) / 4)
    assert trial.worst not in trial.failed


def test_without_limits_there_is_no_verdict_and_another_seed_is_another_run():
    task = ParkTask(steps=5, runs=1)
    trials = [tried(task, control=robsim.Spin, seed=seed) for seed in (4, 4, 5)]
    broken = tried(task, control=lambda step: (0, 3))
    assert broken.broken == (0,)
    assert "3 V at step 0" in str(broken)
    assert trials[0].verdict is None
    assert np.isnan(trials[0].points)
    one, same, other = (trial.trace.pose_true for trial in trials)
    assert np.array_equal(one, same)
    assert not np.array_equal(one, other)


@pytest.mark.parametrize(
    ("call", "named"),
    [
        (lambda task: try_solution(task), "callbacks by name"),
        (lambda task: try_solution(task, contrl=3), "'contrl'"),
        (lambda task: try_solution(task, control=robsim.GoToPoint(1, 2)), "^control"),
        (lambda task: try_solution(task, lambda step: (0, 0)), "by name"),
    ],
)
def test_what_is_wrong_is_named(call, named):
    with pytest.raises((TypeError, ValueError), match=named):
        call(ParkTask(steps=5, runs=1))


def test_files_that_are_missing_or_misspelled_are_named(tmp_path):
    task = ParkTask(steps=5, runs=1)
    with pytest.raises(FileNotFoundError):
        tried(task, tmp_path / "nothing")
    (tmp_path / "contrl.py").write_text("def control(step):\n    return 0, 0\n")
    for path in (tmp_path, tmp_path / "contrl.py"):
        with pytest.raises(ValueError, match=r"control\.py"):
            tried(task, path)
    (tmp_path / "control.py").write_text("import nothing_of_that_name\n")
    with pytest.raises(ModuleNotFoundError, match="nothing_of_that_name"):
        tried(task, tmp_path)


def test_what_a_run_does_not_use_may_name_what_is_masked(tmp_path):
    mine = solution(tmp_path / "mine", "centroids", "measure")
    (mine / "run_it.py").write_text("import robsim\nrobsim.Simulation(measure=True).run(9)\n")
    file = mine / "measure.py"
    run = '\n\nif __name__ == "__main__":\n    robsim.Simulation(measure=measure).run(9)\n'
    file.write_text(file.read_text() + run)
    assert not tried(MeasureTask(**SHORT), mine).failed
    file.write_text(file.read_text() + "\n\nlocate = robsim.locate\n")
    with pytest.raises(ValueError, match=r"measure\.py has robsim\.locate"):
        tried(MeasureTask(**SHORT), mine)


@pytest.mark.parametrize(
    "source",
    [
        "from robsim.vision.markers import locate",
        "from robsim import vision\nlocate = vision.locate",
        "import robsim as r\nlocate = r.locate",
        "import robsim.vision.markers as room\nlocate = room.locate",
        "from robsim._core import locate",
    ],
)
def test_what_is_masked_is_found_in_every_room_that_offers_it(tmp_path, source):
    mine = solution(tmp_path / "mine", "centroids", "measure")
    file = mine / "measure.py"
    file.write_text(f"{file.read_text()}\n\n{source}\n")
    with pytest.raises(ValueError, match=r"measure\.py has robsim\.(vision\.)?locate"):
        tried(MeasureTask(**SHORT), mine)


DRIVES = "from task import GOAL\ndef control(step):\n    return 0.0, GOAL[0] / 1000"


def test_a_notebook_is_tried_as_the_grader_takes_it(tmp_path):
    cells = ("%matplotlib inline\nraise SystemExit", DRIVES, "robsim.Simulation().run(9)")
    file = notebook(tmp_path / "s1.ipynb", *cells, tags={1: "robsim-skip"})
    trial = tried(ParkTask(steps=5, runs=1), file)
    assert trial.solution == "s1.ipynb"
    assert trial.trace.u[0].tolist() == [0, 0.38]
    late = DRIVES.replace("return 0.0", "return 1 / (3 - step.k)")
    failed = tried(ParkTask(steps=5, runs=1), notebook(tmp_path / "s2.ipynb", "K = 1", late))
    assert "s2.ipynb, cell 2, line 3" in failed.failed[0]


def test_a_notebook_in_a_folder_is_tried_with_its_helpers(tmp_path):
    (tmp_path / "own.py").write_text("def pace(k):\n    return 0.5\n")
    (tmp_path / "other.py").write_text("import robsim\nsimulate = robsim.Simulation\n")
    cells = ("from task import *\nfrom own import pace", "sim = robsim.Simulation()")
    drives = "def control(step):\n    return GOAL[0] * 0, pace(step.k)"
    notebook(tmp_path / "s1.ipynb", *cells, drives)
    trial = tried(ParkTask(steps=5, runs=1), tmp_path)
    assert trial.trace.u.tolist() == [[0, 0.5]] * 5
    notebook(tmp_path / "s1.ipynb", "from other import *", *cells, drives)
    with pytest.raises(ValueError, match=r"other\.py has robsim\.Simulation"):
        tried(ParkTask(steps=5, runs=1), tmp_path)


@pytest.mark.parametrize(
    ("cells", "named"),
    [
        ((DRIVES, "def control(step):\n    return 1, 1"), "cell 1, line 2.* and cell 2, line 1"),
        (("import robsim\n\ncontrol = robsim.GoToPoint(1, 2)",), r"robsim\.GoToPoint"),
        (("def control(step):\n    return K, K", "K = 1 / 0"), "cell 2, line 1.*ZeroDivision"),
        (("x = 1",), "control"),
    ],
)
def test_a_notebook_that_the_grader_refuses_is_not_tried(tmp_path, cells, named):
    with pytest.raises(ValueError, match=named):
        tried(ParkTask(steps=5, runs=1), notebook(tmp_path / "s1.ipynb", *cells))


def test_what_is_printed_is_printed_by_the_runs_alone(tmp_path, capsys):
    file = tmp_path / "control.py"
    file.write_text("print('loaded')\n\n\ndef control(step):\n    return 0.1, 0.1\n")
    tried(ParkTask(steps=5, runs=2), file)
    assert capsys.readouterr().out.count("loaded") == 2
    file.write_text("print('loaded')\n1 / 0\n")
    with pytest.raises(ZeroDivisionError):
        tried(ParkTask(steps=5, runs=2), file)
    assert capsys.readouterr().out == "loaded\n"


def test_where_most_runs_do_not_arrive_there_is_no_median_of_times():
    goal = ((550.0, 550.0),)
    trial = tried(FollowTask(waypoints=goal, steps=5, runs=2), control=lambda step: (0, 0))
    half = replace(trial, values={**trial.values, "time": (np.nan, 7.0)})
    arrived = replace(trial, values={**trial.values, "time": (8.0, 7.0)})
    assert [one.to_dict()["scores"]["time until the last waypoint"]["own"]
            for one in (trial, half, arrived)] == [None, None, 7.5]  # fmt: skip
    without = "runs without time until the last waypoint, which count as the worst: "
    told = [[one for one in each.remarks if without in one] for each in (trial, half, arrived)]
    assert told == [[f"{without}2 (100 %)"], [f"{without}1 (50.0 %)"], []]
