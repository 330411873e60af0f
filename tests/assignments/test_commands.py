"""The examples of ``robsim assignment`` and ``robsim grade``, from a new folder to marks."""

import shlex
import shutil

import pytest

from commands import command
from robsim.cli.assignment import calibrate, check, new, pack
from robsim.cli.grading import grade
from robsim.tasks._marks import calibrate as marks
from small_assignments import solution


def run(line, *more, cwd, status=(0,)):
    words = shlex.split(line.removeprefix("Example: "))
    assert words[0] == "robsim"
    done = command(*words[1:], *more, cwd=cwd)
    assert done.exit_code in status, done.stderr
    return done


@pytest.mark.slow
@pytest.mark.timeout(300)
def test_the_examples_lead_from_a_new_folder_to_marks(tmp_path, monkeypatch):
    monkeypatch.setattr(marks, "PILOT_TESTS", 3)
    monkeypatch.setattr(marks, "WRONG_TESTS", 2)
    made = run(new.EXAMPLE, "--no-calibrate", "--seed", "1", cwd=tmp_path)
    assert "next: robsim assignment calibrate hw1" in made.stdout
    folder = tmp_path / "hw1"
    file = folder / "assignment.toml"
    text = file.read_text().replace("runs = 10", "runs = 2").replace("steps = 150", "steps = 40")
    file.write_text(text.partition("# Tests of your own")[0])
    for wrong in (folder / "solutions/park/wrong").iterdir():
        if wrong.name != "naive":
            shutil.rmtree(wrong)
    few = ("--false-fail", "0.5", "--confidence", "0.5")
    assert "written to hw1/limits.json" in run(calibrate.EXAMPLE, *few, cwd=tmp_path).stdout
    # With limits of so few tests, right ones may fail.
    assert "right: reference" in run(check.EXAMPLE, cwd=tmp_path, status=(0, 1)).stdout
    run(pack.EXAMPLE, cwd=tmp_path)
    assert (tmp_path / "hw1-students.zip").is_file()
    folder.rename(tmp_path / "hw3")
    solution(tmp_path / "submissions/anna", kind="park")
    (tmp_path / "submissions/ben").mkdir()
    graded = run(grade.EXAMPLE, cwd=tmp_path, status=(1,))
    assert "anna" in graded.stdout
    assert (tmp_path / "graded/class.html").is_file()


@pytest.mark.parametrize("name", ["", "new", "calibrate", "check", "pack"])
def test_help_speaks_of_what_there_is(name):
    from robsim.assignments._making.template import TEMPLATES

    words = ["assignment", name, "--help"] if name else ["assignment", "--help"]
    told = " ".join(command(*words).stdout.split())
    assert "Example: robsim assignment" in told or "Start with: robsim assignment" in told
    if name == "new":
        assert all(template in told for template in TEMPLATES)


def test_packing_nothing_is_refused(tmp_path):
    done = command("assignment", "pack", str(tmp_path))
    assert done.exit_code == 2
    assert "what is to be packed? --students ZIP, --gradescope ZIP, or both" in done.stderr
    done = command("assignment", "pack", str(tmp_path), "--students", "a.zip", "--install", "x")
    assert "--install is for an autograder" in done.stderr


def test_a_new_folder_is_refused_where_there_is_one(tmp_path):
    done = command("assignment", "new", "state", str(tmp_path), "--no-calibrate")
    assert done.exit_code == 2
    assert "exists: give another name" in done.stderr
    done = command("assignment", "new", "stat", str(tmp_path / "x"), "--no-calibrate")
    assert "did you mean 'state'?" in done.stderr
