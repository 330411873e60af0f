"""The folder of an assignment: made, and read as a whole."""

import json
import os
import pickle
import re
import stat
import sys
import tracemalloc
from dataclasses import replace

import pytest

from prose import page
from robsim.teach import AssignmentError, Key, ScoreLimit, load_assignment, new_assignment, task
from robsim.teach.tasks.marks import calibration
from robsim.teach.tasks.solutions import solutions_in
from small_assignments import LIMITS, SHORT, TESTS, assignment

# --- new folders


each = pytest.mark.parametrize("template", ["park", "follow", "identify", "measure", "estimate"])


@each
def test_a_new_folder_is_an_assignment_with_the_solutions_that_ship(tmp_path, template):
    made = new_assignment(template, tmp_path / "hw1", seed=1)
    names = {file.name for file in made.folder.iterdir()}
    assert {"assignment.toml", "sheet.md", "start", "own_tests.py", "solutions", "key"} <= names
    read = load_assignment(tmp_path / "hw1")
    assert read == made
    public, hidden = read.tests
    assert (public.public, hidden.public) == (True, False)
    assert public.task == hidden.task
    assert public.points + hidden.points == 9
    assert [file.public for file in read.files] == [True]
    task = public.task
    found = solutions_in(made.folder / "solutions" / task.name, task.slots)
    assert [replace(one, folder=None) for one in found] == list(task.solutions)
    sheet = (made.folder / "sheet.md").read_text()
    for slot in made.slots:
        assert f"`{slot}" in sheet
        assert (made.folder / f"start/{slot}.py").is_file()
    for name, value in task.values.items():
        assert f"| `{name}` | `{value!r}` |" in sheet
    assert "A file may have 1 MiB, all files together 5 MiB." in sheet
    assert "robsim tasks" not in sheet  # whose numbers are others
    rule = sheet[sheet.index("The grader takes these parts of a notebook") :].partition("\nA call")[
        0
    ]
    assert rule.strip() in page("folders")


@each
def test_no_two_have_the_same_numbers_or_the_same_key(tmp_path, template):
    made = [new_assignment(template, tmp_path / f"hw{i}", seed=i) for i in range(4)]
    assert len({one.tests[0].task for one in made}) == 4
    again = new_assignment(template, tmp_path / "again", seed=0)
    assert again.tests[0].task == made[0].tests[0].task
    assert len({one.key for one in [*made, again]}) == 5


@pytest.mark.skipif(sys.platform == "win32", reason="modes of files are those of Unix")
def test_nobody_else_can_read_the_key(tmp_path):
    new_assignment("measure", tmp_path / "hw1")
    assert stat.S_IMODE(os.stat(tmp_path / "hw1/key").st_mode) == 0o600
    assert not Key.load(tmp_path / "hw1/key").is_public


def test_the_name_is_that_of_the_folder_or_what_is_given(tmp_path, monkeypatch):
    assert new_assignment("measure", tmp_path / "a/b/hw1").name == "hw1"
    assert new_assignment("measure", tmp_path / "x", name='Übung "1"').name == 'Übung "1"'
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    assert new_assignment("measure", "hw1").name == "hw1"


def test_wrong_arguments_are_refused_before_anything_is_written(tmp_path):
    (tmp_path / "taken").mkdir()
    with pytest.raises(FileExistsError, match="taken"):
        new_assignment("measure", tmp_path / "taken")
    for template, wrong in (("mesure", {}), ("measure", {"seed": -1})):
        with pytest.raises(ValueError, match="seed" if wrong else "mesure"):
            new_assignment(template, tmp_path / "hw1", **wrong)
    assert list(tmp_path.rglob("*")) == [tmp_path / "taken"]


def test_a_folder_that_cannot_be_filled_is_removed(tmp_path, monkeypatch):
    folder = "robsim.teach.assignments.making"
    monkeypatch.setattr(f"{folder}.sheet_for", lambda assignment: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        new_assignment("measure", tmp_path / "hw1")
    assert list(tmp_path.iterdir()) == []


# --- reading


def refused(folder):
    with pytest.raises(AssignmentError) as caught:
        load_assignment(folder)
    return str(caught.value)


def test_what_a_file_does_not_say_comes_from_the_tasks(tmp_path):
    found = load_assignment(assignment(tmp_path / "hw3", TESTS))
    assert pickle.loads(pickle.dumps(found)) == found
    assert (found.name, found.title) == ("hw3", "Through dropouts")
    assert found.slots == ("estimate_state",)
    assert found.given == "pose"
    expected = {"estimation.reference", "teach.tasks", "teach.grading", "teach.assignments"}
    expected |= {"Simulation", "Experiment", "campaign", "teach.exercises"}
    assert {f"robsim.{room}" for room in expected} == set(found.masked)
    assert found.own_seeds
    assert found.seconds == 540
    shown, hidden = found.tests
    assert shown.task == task("estimate", **SHORT)
    assert hidden.task == task("estimate", **SHORT, noise=12)
    assert (shown.public, hidden.public) == (True, False)
    assert (hidden.number, hidden.points) == ("3.1", 4)
    assert shown.reference.name == "reference"
    assert shown.limits["consistency"] == ScoreLimit(full=3.0, zero=100.0, low=0.3, low_zero=0.01)
    assert found.key == Key.load(tmp_path / "hw3/key")


def test_all_that_can_be_said_is_taken(tmp_path):
    head = """
    slots = ["estimate_state", "control"]
    given = "frames"
    imports = ["numpy"]
    masked = ["robsim.estimation.reference", "robsim.locate"]
    seeds = "class"
    isolation = "process"
    limits = { call = 2.0, submission = 60 }
    files = [{ path = "more.py", public = true }]
    """
    folder = assignment(tmp_path / "hw3", head + TESTS, more="")
    (folder / "given").mkdir()
    (folder / "given/table.csv").write_bytes(b"1,2\n")
    found = load_assignment(folder)
    assert found.slots == ("estimate_state", "control")
    assert (found.given, found.imports, found.masked) == (
        "frames",
        ("numpy",),
        ("robsim.estimation.reference", "robsim.locate"),
    )
    assert (found.own_seeds, found.isolation) == (False, "process")
    assert (found.limits.call, found.seconds) == (2.0, 60)
    (more,) = found.files
    assert (more.path.name, more.public) == ("more.py", True)
    assert found.given_files == {"table.csv": b"1,2\n"}


def test_solutions_of_its_own_come_before_those_that_ship(tmp_path):
    folder = assignment(tmp_path / "hw3")
    place = folder / "solutions/estimate/right/reference"
    place.mkdir(parents=True)
    (place / "estimate_state.py").write_text("def estimate_state(step):\n    return None\n")
    (shown, _) = load_assignment(folder).tests
    assert b"return None" in shown.reference.files["estimate_state"]


def test_what_is_no_assignment_is_said_to_be_none(tmp_path):
    assert "nowhere" in refused(tmp_path / "nowhere")
    assert "assignment.toml" in refused(tmp_path)
    (tmp_path / "assignment.toml").write_text("name = ")
    assert "TOML" in refused(tmp_path)
    nothing = assignment(tmp_path, 'name = "hw3"\ntitle = "x"\nslots = ["control"]', limits=())
    assert "no tests" in refused(nothing)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no pipes")
def test_given_files_have_an_end_and_are_not_read_before_it_is_known(tmp_path):
    made = assignment(tmp_path, TESTS)
    (tmp_path / "given").mkdir()
    os.mkfifo(tmp_path / "given/pipe")
    assert "regular file" in refused(made)
    (tmp_path / "given/pipe").unlink()
    with (tmp_path / "given/much").open("wb") as file:
        file.truncate(2**30)
    tracemalloc.start()
    try:
        assert "MB" in refused(made)
        assert tracemalloc.get_traced_memory()[1] < 2**26
    finally:
        tracemalloc.stop()


def test_what_is_wrong_is_named_with_its_key(tmp_path):
    for named, old, new in [
        ("'titel'", "title =", "titel ="),
        ("name", 'name = "hw3"', ""),
        (r"line 5: \[tests\.1\] points", "points = 2", ""),
        ("points.*-2", "points = 2", "points = -2"),
        ("public.*'no'", "public = true", 'public = "no"'),
        ("name.*'a/b'", 'name = "shown"', 'name = "a/b"'),
        ("'hidden'", 'name = "shown"', 'name = "hidden"'),
        ("'estimat'", 'task = "estimate"', 'task = "estimat"'),
        (r"\[tests\.1\.?.*\] runs", "runs = 2", "runs = 0"),
        ("slots.*estimate_state", "name =", 'slots = ["control"]\nname ='),
        ("robsim.refrence", "name =", 'masked = ["robsim.refrence"]\nname ='),
        (r"\[limits\] call", "name =", "limits = { call = 0 }\nname ="),
        (r"\[limits\].*'cal'", "name =", "limits = { cal = 1 }\nname ="),
        ("x.py", "name =", 'files = [{path = "x.py", public = true}]\nname ='),
        ("path", "name =", 'files = [{path = "../x.py", public = true}]\nname ='),
    ]:
        message = refused(assignment(tmp_path, TESTS.replace(old, new, 1)))
        assert re.search(rf"^assignment\.toml.*{named}", message, re.DOTALL), message


def test_limits_that_are_wrong_are_named(tmp_path):
    folder = assignment(tmp_path)
    for named, limits in [
        ("zero", {"position": {"full": 1}}),
        ("positon", {"positon": {"full": 1, "zero": 2}}),
        ("zro", {"position": {"full": 1, "zro": 2, "zero": 3}}),
    ]:
        content = {"format": 1, "tests": {"shown": {"limits": limits}}}
        (folder / "limits.json").write_text(json.dumps(content))
        assert re.search(rf"^limits\.json.*{named}", refused(folder), re.DOTALL)


@pytest.mark.parametrize("said", [True, 1, ["x"], None])
def test_why_limits_are_provisional_is_a_text(tmp_path, said):
    folder = assignment(tmp_path)
    content = {"format": 1, "tests": {"shown": {"limits": LIMITS, "provisional": said}}}
    (folder / "limits.json").write_text(json.dumps(content))
    assert re.search(r"^limits\.json.*provisional", refused(folder), re.DOTALL)


def calibrated(folder, made):
    """Write the limits of the first test as those of a task, which come from its solutions."""
    record = calibration.TaskCalibration(
        task=made.name,
        parameters=made.parameters,
        limits={name: ScoreLimit(**limit) for name, limit in LIMITS.items()},
        false_fail=0.01,
        confidence=0.95,
        tests=299,
        pilot_tests=60,
        rank=1,
        seed=0,
        task_digest=calibration.task_digest(made),
        solutions_digest=calibration.solutions_digest(made.solutions),
        versions={},
        solutions=(),
    ).as_record()
    tests = {"shown": {"limits": LIMITS, "calibration": record}}
    (folder / "limits.json").write_text(json.dumps({"format": 1, "tests": tests}))
    return load_assignment(folder).tests[0]


def test_limits_of_another_task_or_of_other_solutions_are_stale(tmp_path):
    folder = assignment(tmp_path)
    assert calibrated(folder, task("estimate", **SHORT)).stale == ""
    assert "calibrate again" in calibrated(folder, task("estimate", **SHORT, noise=9)).stale
    place = folder / "solutions/estimate"
    for one in task("estimate").solutions:
        of_kind = place / ("right" if one.is_right else "wrong") / one.name
        of_kind.mkdir(parents=True)
        (of_kind / "estimate_state.py").write_bytes(one.files["estimate_state"] + b"\n")
    assert "the solutions differ" in calibrated(folder, task("estimate", **SHORT)).stale


def test_another_isolation_can_be_asked_for(tmp_path):
    folder = assignment(tmp_path / "hw3", TESTS)
    assert load_assignment(folder).isolation == "auto"
    assert load_assignment(folder, isolation="process").isolation == "process"
    with pytest.raises(ValueError, match="isolation"):
        load_assignment(folder, isolation="full")
