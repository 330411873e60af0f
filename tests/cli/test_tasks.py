"""The commands of tasks, as a student at midnight types them."""

import json
from typing import ClassVar

import pytest

from commands import command
from robsim.tasks import TASKS, Park, _trying
from robsim.tasks._limit import Limit


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
    run = command("tasks", "show", "park")
    assert run.stdout.startswith("# Park the robot")
    run = command("tasks", "show", "park", "--to", "mine", cwd=tmp_path)
    assert run.stdout.splitlines() == [
        "written to mine: sheet.md, control.py, task.py",
        "read mine/sheet.md; then: robsim tasks try park mine",
    ]
    assert (tmp_path / "mine" / "sheet.md").read_text() == Park().sheet
    (tmp_path / "mine" / "control.py").write_text("mine")
    run = command("tasks", "show", "park", "--to", "mine", cwd=tmp_path)
    assert run.exit_code == 2
    assert "mine has sheet.md, control.py, task.py already: nothing was written" in run.stderr
    assert (tmp_path / "mine" / "control.py").read_text() == "mine"


@pytest.mark.parametrize("name", TASKS)
def test_what_one_begins_with_can_be_tried(name, tmp_path):
    command("tasks", "show", name, "--to", "mine", cwd=tmp_path)
    run = command("tasks", "try", name, "mine", "--runs", "1", cwd=tmp_path)
    assert run.exit_code == 1
    assert run.stdout.startswith(f"Task {name}, mine")
    assert "failed   0" in run.stdout
    assert f"why: robsim check mine --task {name}" in run.stderr


def test_a_solution_is_as_good_as_the_reference(tmp_path):
    folder = str(Park().solutions[0].folder)
    run = command("tasks", "try", "park", folder, "--runs", "2", "--figure", "a.png", cwd=tmp_path)
    assert run.exit_code == 0
    assert run.stdout.startswith("Task park, reference: as good as the reference")
    assert "is drawn in a.png" in run.stderr
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")
    run = command("tasks", "try", "park", folder, "--runs", "2", "--json")
    assert json.loads(run.stdout)["points"] == 1


def test_an_error_in_a_run_is_told_with_its_line(tmp_path):
    (tmp_path / "control.py").write_text(
        "def control(step):\n    return step.mesurement.pose[0], 0\n"
    )
    run = command("tasks", "try", "park", "control.py", "--runs", "1", cwd=tmp_path)
    assert run.exit_code == 1
    assert run.stdout.startswith("Task park, control.py: fails")
    assert "control.py:2 in control" in " ".join(run.stdout.split())


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["show", "mesure"], "there is no task 'mesure': did you mean 'measure'?"),
        (["try", "park", "nothing"], "nothing: No such file or directory"),
        (["try", "park", ".", "--runs", "0"], "--runs must lie within 1..1000, got 0"),
        (["try", "park", ".", "--figure", "a.txt"], "the name of a figure must end in"),
        (["try", "park", "."], "has no solution: it must have control.py"),
    ],
)
def test_what_is_wrong_is_told_in_a_sentence(words, message, tmp_path):
    run = command("tasks", *words, cwd=tmp_path)
    assert run.exit_code == 2
    assert message in " ".join(run.stderr.split())


def test_an_error_while_loading_has_a_traceback(tmp_path):
    (tmp_path / "control.py").write_text("import nonsense_of_mine\n")
    run = command("tasks", "try", "park", ".", cwd=tmp_path)
    assert run.exit_code == 1
    assert "control.py" in run.stderr
    assert "nonsense_of_mine" in run.stderr
