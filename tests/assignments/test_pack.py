"""What is packed: for students nothing that is hidden, for Gradescope what its format asks for."""

import json
import os
import re
import shlex
import shutil
import subprocess
import sys
import zipfile

import pytest

from commands import command
from robsim.teach import (
    AssignmentError,
    ParkTask,
    load_assignment,
    new_assignment,
    pack_gradescope,
    pack_students,
)
from robsim.teach.assignments.packing.autograder import student_in
from small_assignments import LIMITS, retell, solution

REFERENCE = "assignment/solutions/estimate/right/reference"
on_unix = pytest.mark.skipif(sys.platform == "win32", reason="they are scripts of bash")


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """An assignment with short runs and limits that somebody has written."""
    folder = tmp_path_factory.mktemp("made") / "hw1"
    new_assignment("estimate", folder, seed=1)
    change(folder, ("steps = 60", "steps = 20"), ("runs = 10", "runs = 2"))
    retell(folder, steps=20, runs=2)
    tests = {name: {"limits": LIMITS, "power": 1.0} for name in ("public", "hidden")}
    (folder / "limits.json").write_text(json.dumps({"format": 1, "tests": tests}))
    return folder


def change(folder, *changes):
    file = folder / "assignment.toml"
    text = file.read_text()
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    file.write_text(text)


@pytest.fixture
def with_own_tests(made, tmp_path):
    shutil.copytree(made, tmp_path / "hw1")
    return load_assignment(tmp_path / "hw1")


@pytest.fixture
def calibrated(with_own_tests):
    """The same without tests of the teacher's own, which are loaded by pytest each time."""
    change(with_own_tests.folder, ('[[files]]\npath = "own_tests.py"\npublic = true\n', ""))
    return load_assignment(with_own_tests.folder)


@pytest.mark.long
def test_students_get_the_public_part(with_own_tests, tmp_path):
    pack_students(with_own_tests, tmp_path / "students.zip")
    with zipfile.ZipFile(tmp_path / "students.zip") as archive:
        names = set(archive.namelist())
        archive.extractall(tmp_path / "theirs")
    assert names == {
        "hw1/assignment.toml",
        "hw1/limits.json",
        "hw1/own_tests.py",
        "hw1/sheet.md",
        "hw1/start/estimate_state.py",
        "hw1/start/task.py",
    }
    theirs = load_assignment(tmp_path / "theirs/hw1")
    (public,) = theirs.tests
    mine = with_own_tests.tests[0]
    assert (public.name, theirs.key, theirs.points) == ("public", None, 10)
    assert (public.task, public.limits) == (mine.task, mine.limits)
    assert len(public.reference_values["position"]) == 2
    assert (theirs.masked, theirs.given) == (with_own_tests.masked, with_own_tests.given)
    assert "power" not in (tmp_path / "theirs/hw1/limits.json").read_text()


def test_a_folder_is_written_once_and_the_same_files_give_the_same_zip(calibrated, tmp_path):
    pack_students(calibrated, tmp_path / "out")
    assert load_assignment(tmp_path / "out").name == "hw1"
    with pytest.raises(FileExistsError, match="out"):
        pack_students(calibrated, tmp_path / "out")
    first, second = (pack_students(calibrated, tmp_path / f"{i}.zip") for i in range(2))
    assert first.read_bytes() == second.read_bytes()


def test_students_get_the_numbers_of_the_tests(tmp_path):
    made = new_assignment("park", tmp_path / "hw1", seed=1)
    goal = list(made.tests[0].task.goal)
    change(made.folder, ("runs = 10", "runs = 5"), (f"goal = {goal}", "goal = [450, 250, 1.57]"))
    shown = made.tests[0].task.goal
    text = re.escape(f"runs (5, not 10), goal ([450.0, 250.0, 1.57], not {goal}): calibrate")
    with pytest.raises(AssignmentError, match=f"limits of the test public: .* in {text}"):
        pack_students(load_assignment(made.folder), tmp_path / "out")
    limits = {score.name: {"full": 2.0, "zero": 4.0} for score in ParkTask.scores}
    tests = {name: {"limits": limits} for name in ("public", "hidden")}
    (made.folder / "limits.json").write_text(json.dumps({"format": 1, "tests": tests}))
    text = re.escape(f"GOAL is {shown}, must be (450.0, 250.0, 1.57); runs is 10, must be 5")
    with pytest.raises(AssignmentError, match=rf"sheet\.md differs.*: {text}"):
        pack_students(load_assignment(made.folder), tmp_path / "out")
    retell(made.folder, GOAL="(450, 250, 1.57)", runs=5)
    (made.folder / "start/task.py").write_text(f"GOAL = {shown}\n")  # of an older robsim
    pack_students(load_assignment(made.folder), tmp_path / "out")
    assert "GOAL = (450.0, 250.0, 1.57)\n" in (tmp_path / "out/start/task.py").read_text()


def test_hidden_tests_of_the_teachers_own_stay_here(calibrated, tmp_path):
    file = calibrated.folder / "assignment.toml"
    file.write_text(file.read_text() + '\n[[files]]\npath = "secret_tests.py"\npublic = false\n')
    (calibrated.folder / "secret_tests.py").write_text("def test_secret(submission):\n    pass\n")
    pack_students(load_assignment(calibrated.folder), tmp_path / "out")
    files = [one for one in (tmp_path / "out").rglob("*") if one.is_file()]
    assert files
    assert not any(b"secret" in one.read_bytes() for one in files)


@pytest.mark.parametrize("secret", ["key", "solutions/estimate/right/reference/kalman.py"])
def test_what_is_hidden_is_found_wherever_it_was_copied_to(calibrated, secret, tmp_path):
    content = (calibrated.folder / secret).read_bytes()
    (calibrated.folder / "start/notes.txt").write_bytes(b"see this:\n" + content)
    with pytest.raises(AssignmentError, match=r"start/notes\.txt"):
        pack_students(calibrated, tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_without_limits_nothing_is_packed(tmp_path):
    folder = new_assignment("estimate", tmp_path / "hw1").folder
    (folder / "limits.json").unlink()
    made = load_assignment(folder)
    for pack in (pack_students, pack_gradescope):
        with pytest.raises(AssignmentError, match=r"public.*limit"):
            pack(made, tmp_path / "packed.zip")
    assert {file.name for file in tmp_path.iterdir()} == {"hw1"}


@on_unix
@pytest.mark.long
def test_the_autograder_is_as_its_specification_has_it_and_grades(with_own_tests, tmp_path):
    archive = pack_gradescope(with_own_tests, tmp_path / "autograder.zip", install="robsim==9.9")
    with zipfile.ZipFile(archive) as opened:
        modes = {one.filename: one.external_attr >> 16 & 0o777 for one in opened.infolist()}
    assert set(modes) == {
        *("setup.sh", "run_autograder", "requirements.txt"),
        *("assignment/assignment.toml", "assignment/key", "assignment/limits.json"),
        *("assignment/own_tests.py", f"{REFERENCE}/estimate_state.py", f"{REFERENCE}/kalman.py"),
    }
    assert modes["run_autograder"] == modes["setup.sh"] == 0o755
    assert modes["assignment/key"] == 0o600
    root = autograder(tmp_path, archive)
    assert (root / "source/requirements.txt").read_text().split() == ["robsim==9.9", "pytest"]
    for name in ("setup.sh", "run_autograder"):
        subprocess.run(["bash", "-n", root / "source" / name], check=True)
    solution(root / "submission")
    done, results = run_autograder(root)
    assert done.returncode == 0, done.stderr
    assert [test["max_score"] for test in results["tests"]] == [3, 6, 1]
    assert sum(test["score"] for test in results["tests"]) == 10
    assert with_own_tests.key._secret.hex() not in json.dumps(results)


def test_a_wheel_goes_along(calibrated, tmp_path):
    wheel = tmp_path / "robsim-1.0-cp311-cp311-linux_x86_64.whl"
    wheel.write_bytes(b"a wheel")
    pack_gradescope(calibrated, tmp_path / "autograder.zip", install=wheel)
    with zipfile.ZipFile(tmp_path / "autograder.zip") as archive:
        assert archive.read(wheel.name) == b"a wheel"
        assert archive.read("requirements.txt").decode().startswith(f"./{wheel.name}\n")
    with pytest.raises(FileNotFoundError):
        pack_gradescope(calibrated, tmp_path / "b.zip", install=tmp_path / "none.whl")
    with pytest.raises(ValueError, match=r"\bpath\b"):
        pack_gradescope(calibrated, tmp_path / "autograder")


@pytest.mark.slow
def test_students_try_the_public_tests_with_what_they_get(calibrated, tmp_path):
    theirs = tmp_path / "theirs/hw1"
    pack_students(calibrated, theirs)
    shutil.copytree(theirs / "start", theirs / "mine")
    run = command("grade", ".", "mine", "--public", cwd=theirs)
    assert run.exit_code == 1, run.stderr  # what they begin with keeps the last pose
    assert "3 of 9 points" in run.stdout
    solution(theirs / "better")
    run = command("grade", ".", "better", "--public", cwd=theirs)
    assert run.exit_code == 0, run.stdout


def autograder(folder, archive):
    """What Gradescope makes of an autograder: source unpacked, run_autograder copied out of it."""
    root = folder / "autograder"
    (root / "results").mkdir(parents=True)
    shutil.unpack_archive(archive, root / "source")
    shutil.copy(root / "source/run_autograder", root / "run_autograder")
    (root / "source/assignment/key").chmod(0o600)  # as setup.sh does it
    (root / "venv/bin").mkdir(parents=True)
    python = root / "venv/bin/python"
    python.write_text(f'#!/bin/sh\nexec {shlex.quote(sys.executable)} "$@"\n')
    python.chmod(0o755)
    return root


def run_autograder(root):
    done = subprocess.run(
        ["bash", root / "run_autograder"],
        cwd=root,
        env={**os.environ, "AUTOGRADER": str(root)},
        capture_output=True,
        text=True,
        timeout=300,
    )
    return done, json.loads((root / "results/results.json").read_text())


@on_unix
@pytest.mark.slow
def test_a_grader_that_fails_says_so_in_the_results(calibrated, tmp_path):
    root = autograder(tmp_path, pack_gradescope(calibrated, tmp_path / "autograder.zip"))
    (root / "source/assignment/limits.json").unlink()
    solution(root / "submission")
    done, results = run_autograder(root)
    assert done.returncode == 2
    assert "limit" in done.stderr  # for the teacher
    assert "without a fault of your submission" in results["output"]


def test_a_student_is_known_by_who_has_handed_it_in(tmp_path):
    file = tmp_path / "submission_metadata.json"
    assert student_in(file) == "submission"
    for users, name in [
        ([{"email": "b@x.org", "id": 7}, {"email": "a@x.org", "id": 8}], "a@x.org+b@x.org"),
        ([{"email": None, "id": 7}], "7"),
        ([3], "submission"),
    ]:
        file.write_text(json.dumps({"users": users}))
        assert student_in(file) == name
