"""Campaigns as TOML files, and the command that runs them."""

import csv
import json
import sqlite3
import sys
from contextlib import closing

import numpy as np
import pytest

import robsim
from commands import command
from robsim.campaigns import campaign, launch
from robsim.campaigns.spec_file import EXAMPLE, load_spec

PLAIN = 'runs = 3\nsteps = 5\nseed = 2\nmetrics = ["parameters"]\n'
SCENARIO = "[scenario]\narea = [300, 300]\nestimate_parameters = true\n"


def run(spec):
    return launch.run_spec(spec, executor=None, store=None, progress=False)


@pytest.mark.long
def test_the_example_is_the_campaign_that_it_seems(tmp_path):
    (tmp_path / "example.toml").write_text(EXAMPLE)
    spec = load_spec(tmp_path / "example.toml", runs=2)
    noise = robsim.GaussianNoise
    result = campaign(
        robsim.Scenario(
            resolution=(480, 480), start="random", measure=True, control=robsim.DriveAround()
        ),
        vary={"camera_delay": [0, 1], "noise": {0: None, 10: noise(10), 20: noise(20)}},
        metrics=["tracking"],
        runs=2,
        steps=50,
        seed=1,
        progress=False,
    )
    read = run(spec)
    assert read.checksum == result.checksum
    np.testing.assert_array_equal(read["noise"], result["noise"])


def test_files_functions_and_folders_are_beside_the_file(tmp_path, monkeypatch):
    monkeypatch.setattr("sys.path", [*__import__("sys").path])
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine/control.py").write_text("def control(step):\n    return 0.5, 0.4\n")
    (tmp_path / "metrics_of_mine.py").write_text(
        "def x(trace):\n    return trace.pose_true[-1, 0]\n"
    )
    robsim.Scenario(area=(300, 300)).save(tmp_path / "world.toml")
    (tmp_path / "campaign.toml").write_text(
        'runs = 2\nsteps = 5\nmetrics = ["metrics_of_mine:x"]\nscenario = "world.toml"\n'
        '[vary]\ncontrol = ["mine", {kind = "Spin"}]\nestimate_state = ["none"]\n'
    )
    result = run(load_spec(tmp_path / "campaign.toml"))
    sim = robsim.Simulation(area=(300, 300), control=lambda step: (0.5, 0.4))
    assert result["x"][0] == sim.run(5).pose_true[-1, 0]
    assert result["control"].tolist()[:3] == ["mine", "mine", "Spin(voltage=0.05)"]


def test_scores_of_paths_and_poses_are_tables(tmp_path):
    text = PLAIN.replace(
        '["parameters"]',
        '[{kind = "score_path", waypoints = [[200, 150]], waypoint_radius = 5},'
        ' {kind = "score_pose", pose = [200, 150, 0]}]',
    )
    (tmp_path / "campaign.toml").write_text(text + "[scenario]\narea = [300, 300]\n")
    result = run(load_spec(tmp_path / "campaign.toml"))
    trace = result.trace(0, 1)
    path = robsim.score_path(trace, [(200, 150)], waypoint_radius=5)
    assert result["score_path_rmse"][1] == path.rmse
    pose = robsim.control.score_pose(trace, (200, 150, 0))
    assert result["score_pose_final_heading_error"][1] == pose.final_heading_error
    assert np.isnan(result["score_pose_settled_step"]).all()


# The file, and what the message must have.
WRONG = [
    (PLAIN.replace('"parameters"', '{kind = "score_pat"}'), "score_pat"),
    (PLAIN.replace('"parameters"', "{waypoints = [[1, 2]]}"), "kind"),
    (PLAIN.replace('"parameters"', '{kind = "score_pose", poze = [1, 2, 3]}'), "poze"),
    ("runz = 3\n", "runz"),
    ("runs = 3\n", "steps"),
    ("runs =\n", "campaign"),
    (PLAIN + "[scenario]\nnoize = 3\n", "noize"),
    (PLAIN + '[vary]\nmotor_delay = ["a"]\n', "motor_delay"),
    (PLAIN.replace("parameters", "no_such_module:x"), "no_such_module:x"),
    (PLAIN.replace("parameters", ".x:f"), "module:function"),
    (PLAIN + '[vary]\ncontrol = ["nothing"]\n', "nothing"),
    (PLAIN + 'keep = "all"\n', "keep"),
]


def test_what_is_wrong_in_a_file_is_named(tmp_path):
    for text, message in WRONG:
        (tmp_path / "campaign.toml").write_text(text)
        with pytest.raises((ValueError, FileNotFoundError), match=rf"\b{message}\b"):
            load_spec(tmp_path / "campaign.toml")


@pytest.mark.parametrize("end", ["SystemExit(0)", "GeneratorExit"])
@pytest.mark.parametrize("name", ["metrics_that_end.py", "control.py"])
def test_code_that_ends_python_is_named(tmp_path, monkeypatch, end, name):
    monkeypatch.setattr("sys.path", [*sys.path])
    (tmp_path / name).write_text(f"raise {end}\n")
    metric = "metrics_that_end:x" if name.startswith("metrics") else "parameters"
    text = PLAIN.replace("parameters", metric) + '[vary]\ncontrol = ["."]\n'
    (tmp_path / "few.toml").write_text(text)
    ended = command("campaign", "few.toml", cwd=tmp_path)
    assert ended.exit_code == 1
    assert name in ended.stderr


@pytest.mark.long
def test_the_command_runs_a_file_and_goes_on(tmp_path):
    (tmp_path / "few.toml").write_text(PLAIN + SCENARIO + "[vary]\nmotor_delay = [0, 1]\n")
    words = ("campaign", "few.toml", "--store", "few.sqlite")
    first = command(*words, "--csv", "few.csv", cwd=tmp_path)
    assert first.exit_code == 0, first.stderr
    assert "2 x 3 runs of 5 steps" in first.stdout
    with open(tmp_path / "few.csv", newline="") as file:
        assert len(list(csv.DictReader(file))) == 6
    more = command(*words, "--runs", "5", "--by", "motor_delay", "--json", cwd=tmp_path)
    record = json.loads(more.stdout)
    assert (record["cases"], record["runs"], record["failed"]) == (2, 5, 0)
    spec = load_spec(tmp_path / "few.toml", runs=5)
    assert record["checksum"] == run(spec).checksum


@pytest.mark.long
def test_a_file_may_ask_for_traces_which_need_a_store(tmp_path):
    (tmp_path / "few.toml").write_text(PLAIN + 'keep = "traces"\n' + SCENARIO)
    refused = command("campaign", "few.toml", cwd=tmp_path)
    assert (refused.exit_code, "give store" in refused.stderr) == (2, True)
    ended = command("campaign", "few.toml", "--store", "few.sqlite", cwd=tmp_path)
    assert ended.exit_code == 0, ended.stderr
    with closing(sqlite3.connect(tmp_path / "few.sqlite")) as database:
        assert database.execute("SELECT count(*) FROM traces").fetchone() == (3,)


def test_the_command_writes_an_example_but_not_over_a_file(tmp_path):
    assert command("campaign", "--example", "mine.toml", cwd=tmp_path).exit_code == 0
    assert (tmp_path / "mine.toml").read_text() == EXAMPLE
    again = command("campaign", "--example", "mine.toml", cwd=tmp_path)
    assert again.exit_code == 2
    assert "mine.toml exists" in again.stderr


def test_the_command_ends_with_1_if_all_runs_failed(tmp_path):
    (tmp_path / "all.toml").write_text(PLAIN.replace("parameters", "nees") + SCENARIO)
    ended = command("campaign", "all.toml", cwd=tmp_path)
    assert ended.exit_code == 1
    assert "3 runs failed" in ended.stdout
    for words in ((), ("all.toml", "--example", "b.toml"), ("nothing.toml",)):
        wrong = command("campaign", *words, cwd=tmp_path)
        assert wrong.exit_code == 2
        assert wrong.stderr.strip()
