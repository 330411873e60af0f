"""The commands check and tasks, with the input of a student at midnight."""

import json
import textwrap
from typing import ClassVar

import pytest

import robsim
from commands import command
from robsim.teach import TASKS, ParkTask, ScoreLimit, check_folder
from robsim.teach.tasks import trial as _trying
from small_assignments import solution

pytestmark = [pytest.mark.long, pytest.mark.usefixtures("unhurried")]


# --- check


@pytest.fixture
def write(tmp_path):
    """Return a function that writes callback files to a folder, by their names."""

    def files(**sources):
        folder = tmp_path / "mine"
        folder.mkdir(exist_ok=True)
        for name, source in sources.items():
            (folder / f"{name}.py").write_text(textwrap.dedent(source))
        return folder

    return files


def test_a_page_has_a_verdict_for_each_slot_and_the_line_at_fault(write):
    folder = write(
        measure="import robsim\n\n\ndef measure(step):\n    return robsim.lokate(step.blobs)\n",
        control="def control(step)\n    return 1, 1\n",
        define_model="def define_modell():\n    return 1\n",
        estimate_parameters="ENABLED = False\n",
    )
    run = command("check", "mine", cwd=folder.parent)
    assert run.exit_code == 1
    lines = [line.split() for line in run.stdout.splitlines()]
    assert ["measure", "ill", "measure.py"] in lines
    assert ["estimate_parameters", "off"] in lines
    assert ["evaluate_model", "default"] in lines
    page = " ".join(run.stdout.split())
    for place in ("measure.py:5", "control.py:1", "define_modell", "locate"):
        assert place in page


def test_a_line_tells_of_each_check_when_it_is_done(write):
    folder = write(
        control="def control(step):\n    return 1, 1\n",
        define_model="import robsim\n\n\ndef define_model():\n    return robsim.RobotModel()\n",
    )
    run = command("check", "mine", cwd=folder.parent)
    told = run.stderr.splitlines()
    assert "mine" in told[0]
    assert len([line for line in told if line.startswith("control, ")]) == 3
    lines = []
    check_folder(folder, progress=lines.append)
    assert lines == told[1:]
    assert not command("check", "mine", "--json", cwd=folder.parent).stderr


def test_json_and_python_say_the_same(write):
    folder = write(control="def control():\n    return 1, 1\n", measurement="")
    run = command("check", str(folder), "--json")
    assert run.exit_code == 1
    content = json.loads(run.stdout)
    assert content["callbacks"]["control"] == {"verdict": "ill", "file": "control.py"}
    assert content["callbacks"]["measure"] == {"verdict": "off", "file": ""}
    report = check_folder(folder)
    assert content == report.to_dict()
    assert not report
    assert "measurement.py" in report.remarks[0]
    (sentence,) = report.sentences
    assert "step" in sentence
    assert "control.py:1" in sentence


def test_one_file_and_one_slot(write):
    folder = write(
        control="def control(step):\n    return 1\n", measure="raise ValueError('no camera')\n"
    )
    report = check_folder(folder / "control.py")
    assert list(report.checks) == ["control"]
    assert "(u1, u2)" in report.sentences[0]
    (sentence,) = check_folder(folder, slots="measure").sentences
    assert "measure.py" in sentence
    assert "ValueError: no camera" in sentence


def test_what_cannot_be_checked_is_refused(write, tmp_path):
    folder = write(controll="", helper="")
    wrong = folder / "controll.py"
    for words in ([], [tmp_path / "nix"], [folder], [wrong], [folder, "--slot", "contrl"]):
        assert command("check", *map(str, words)).exit_code == 2, words


def test_endless_files_are_ended(write, monkeypatch):
    monkeypatch.setattr("robsim.teach.doctor._trial.TIME_LIMIT", 0.2)
    folder = write(
        define_model="while True:\n    pass\n",
        adjust_background="def adjust_background(image):\n    while True:\n        pass\n",
    )
    first, second = check_folder(folder).problems
    assert first.line.place == "define_model.py:1"
    assert second.line.function == "adjust_background"


def test_helpers_are_found_when_they_are_imported_late(write):
    folder = write(
        define_model="""
            def define_model():
                from sizes import parameters
                import robsim
                return robsim.RobotModel(parameters())
        """,
        sizes="import robsim\ndef parameters():\n    return robsim.RobotParameters(mass=0.4)\n",
    )
    assert check_folder(folder).ok


@pytest.mark.slow
def test_an_untouched_folder_is_well(tmp_path):
    assert command("new", "mine", cwd=tmp_path).exit_code == 0
    for file in (tmp_path / "mine").glob("*.py"):
        file.write_text(file.read_text().replace("ENABLED = False", "ENABLED = True"))
    report = check_folder(tmp_path / "mine").raise_for_problems()
    assert set(report.verdicts.values()) <= {"well", "remark"}
    assert report.verdicts["measure"] == "well"


@pytest.mark.slow
def test_a_folders_estimator_and_background_are_used(write):
    folder = write(
        init_parameter_estimator="""
            import robsim

            def init_parameter_estimator(model):
                return robsim.RecursiveLeastSquares(5, n_filters=3)
        """,
        estimate_parameters="""
            def estimate_parameters(step):
                return step.sample and step.estimator.update(step.sample.phi, step.sample.y)
        """,
        adjust_background="def adjust_background(background):\n    return background\n",
        measure="""
            import robsim

            def measure(step):
                if step.blobs["red"] and step.blobs["blue"]:
                    return robsim.locate(step.blobs, step.markers, step.frame.plane_map)
        """,
    )
    report = check_folder(folder).raise_for_problems()
    assert "red square" not in report.to_dict()["measure_errors"]


def test_estimates_that_nobody_makes_are_a_remark(write, monkeypatch):
    found = robsim.teach.CheckReport(name="control")
    report = "robsim.teach.doctor.callbacks.folder.controller_report"
    monkeypatch.setattr(report, lambda make, setting, **options: found)
    folder = write(
        control="""
            def control(step):
                return (0, 0) if step.estimate is None else step.estimate.pose[:2] / 1e4
        """
    )
    (remark,) = check_folder(folder).remarks
    assert "estimate_state" in remark


# --- tasks


@pytest.fixture
def limits(monkeypatch):
    """Limits made by hand, as wide as they never are."""

    class Calibration:
        task_digest = ""
        limits: ClassVar = {score.name: ScoreLimit(full=5, zero=20) for score in ParkTask.scores}

    monkeypatch.setattr(_trying, "shipped_calibrations", lambda: {"park": Calibration})


@pytest.mark.usefixtures("limits")
def test_the_list_has_all_tasks():
    run = command("tasks", "list")
    assert run.exit_code == 0
    for name, kind in TASKS.items():
        assert name in run.stdout
        assert kind.title in run.stdout


@pytest.mark.usefixtures("limits")
def test_a_task_is_shown_and_written_once(tmp_path):
    assert command("tasks", "show", "park").stdout.startswith("# Park the robot")
    command("tasks", "show", "park", "--to", "mine", cwd=tmp_path)
    mine = tmp_path / "mine"
    assert {file.name for file in mine.iterdir()} == {"sheet.md", "control.py", "task.py"}
    assert (mine / "sheet.md").read_text() == ParkTask().sheet
    (mine / "control.py").write_text("mine")
    run = command("tasks", "show", "park", "--to", "mine", cwd=tmp_path)
    assert run.exit_code == 2
    assert "control.py" in run.stderr
    assert (mine / "control.py").read_text() == "mine"


@pytest.mark.usefixtures("limits")
@pytest.mark.parametrize("name", TASKS)
def test_what_one_begins_with_is_tried_once_it_is_changed(name, tmp_path):
    command("tasks", "show", name, "--to", "mine", cwd=tmp_path)
    run = command("tasks", "try", name, "mine", "--runs", "1", cwd=tmp_path)
    assert run.exit_code == 2
    assert "untouched" in run.stderr
    slot = TASKS[name].slots[0]
    with open(tmp_path / f"mine/{slot}.py", "a") as file:
        file.write(f"\n\nbegun = {slot}\n\n\ndef {slot}(step):\n    return begun(step)\n")
    run = command("tasks", "try", name, "mine", "--runs", "1", cwd=tmp_path)
    assert run.exit_code == 1
    assert run.stdout.startswith(f"Task {name}, mine")
    assert "failed   0" in run.stdout


@pytest.mark.usefixtures("limits")
def test_a_solution_is_as_good_as_the_reference(tmp_path):
    solution(tmp_path / "mine", kind="park")
    words = ("tasks", "try", "park", "mine", "--runs", "1")
    run = command(*words, "--figure", "a.png", "--json", cwd=tmp_path)
    assert run.exit_code == 0
    assert json.loads(run.stdout)["verdict"] == "as good as the reference"
    assert json.loads(run.stdout)["points"] == 1
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.usefixtures("limits")
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


@pytest.mark.usefixtures("limits")
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
