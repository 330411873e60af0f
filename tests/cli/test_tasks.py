"""The commands of tasks, as a student at midnight types them."""

import json
from typing import ClassVar

import pytest

from commands import command
from robsim.teach import TASKS, Limit, Park
from robsim.teach.tasks import trial as _trying
from small_assignments import solution

pytestmark = pytest.mark.long


@pytest.fixture(autouse=True)
def limits(monkeypatch):
    """Limits made by hand, as wide as they never are."""

    class Calibration:
        task_digest = ""
        limits: ClassVar = {score.name: Limit(full=5, zero=20) for score in Park.scores}

    monkeypatch.setattr(_trying, "shipped_calibrations", lambda: {"park": Calibration})


def test_the_list_has_all_tasks():
    run = command("tasks", "list")
    assert run.exit_code == 0
    for name, kind in TASKS.items():
        assert name in run.stdout
        assert kind.title in run.stdout


def test_a_task_is_shown_and_written_once(tmp_path):
    assert command("tasks", "show", "park").stdout.startswith("# Park the robot")
    command("tasks", "show", "park", "--to", "mine", cwd=tmp_path)
    mine = tmp_path / "mine"
    assert {file.name for file in mine.iterdir()} == {"sheet.md", "control.py", "task.py"}
    assert (mine / "sheet.md").read_text() == Park().sheet
    (mine / "control.py").write_text("mine")
    run = command("tasks", "show", "park", "--to", "mine", cwd=tmp_path)
    assert run.exit_code == 2
    assert "control.py" in run.stderr
    assert (mine / "control.py").read_text() == "mine"


@pytest.mark.parametrize("name", TASKS)
def test_what_one_begins_with_can_be_tried(name, tmp_path):
    command("tasks", "show", name, "--to", "mine", cwd=tmp_path)
    run = command("tasks", "try", name, "mine", "--runs", "1", cwd=tmp_path)
    assert run.exit_code == 1
    assert run.stdout.startswith(f"Task {name}, mine")
    assert "failed   0" in run.stdout


def test_a_solution_is_as_good_as_the_reference(tmp_path):
    solution(tmp_path / "mine", kind="park")
    words = ("tasks", "try", "park", "mine", "--runs", "1")
    run = command(*words, "--figure", "a.png", "--json", cwd=tmp_path)
    assert run.exit_code == 0
    assert json.loads(run.stdout)["verdict"] == "as good as the reference"
    assert json.loads(run.stdout)["points"] == 1
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")


def test_an_error_is_told_with_its_line(tmp_path):
    file = tmp_path / "control.py"
    file.write_text("def control(step):\n    return step.mesurement.pose[0], 0\n")
    run = command("tasks", "try", "park", "control.py", "--runs", "1", cwd=tmp_path)
    assert run.exit_code == 1
    assert "control.py:2" in run.stdout
    file.write_text("import nonsense_of_mine\n")
    run = command("tasks", "try", "park", ".", cwd=tmp_path)
    assert run.exit_code == 1
    assert "control.py" in run.stderr
    assert "nonsense_of_mine" in run.stderr


def test_what_is_wrong_is_named(tmp_path):
    for named, words in {
        "mesure": ("show", "mesure"),
        "nothing": ("try", "park", "nothing"),
        "runs": ("try", "park", ".", "--runs", "0"),
        "a.txt": ("try", "park", ".", "--figure", "a.txt"),
        "control.py": ("try", "park", "."),
    }.items():
        run = command("tasks", *words, cwd=tmp_path)
        assert run.exit_code == 2
        assert named in run.stderr
