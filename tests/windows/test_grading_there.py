"""Grading on Windows, from the command and from pytest, with processes of campaigns, too."""

import csv
import subprocess
import sys

import pytest

from small_assignments import assignment, solution

pytestmark = [
    pytest.mark.skipif(sys.platform != "win32", reason="tries what differs on Windows"),
    pytest.mark.long,
]

MINE = """
import pytest
import robsim

pytestmark = pytest.mark.robsim_submission(slots="control")
SCENARIO = robsim.Scenario(resolution=(200, 200), measure=True)


def test_a_run(submission):
    assert submission.run(SCENARIO, steps=6, seed=1).seen.all()


def test_runs_in_other_processes(submission):
    options = {"runs": 3, "steps": 4, "seed": 1, "metrics": "tracking"}
    there = submission.runs(SCENARIO, **options, executor=2)
    assert len(there) == 3
    assert there.to_dict()["failed"] == 0
"""


def ran(folder, *words):
    """What a program of Python's says, and its status."""
    command = [sys.executable, "-m", *words]
    done = subprocess.run(command, cwd=folder, stdin=subprocess.DEVNULL, capture_output=True)
    return done.returncode, (done.stdout + done.stderr).decode().replace("\r\n", "\n")


@pytest.fixture
def handed_in(tmp_path):
    assignment(tmp_path / "hw3")
    solution(tmp_path / "handed/anna")
    for name, code in [
        ("ben", "def estimate_state(step):\n    1/0\n"),
        ("zoe", "import os\nos._exit(0)"),
    ]:
        (tmp_path / "handed" / name).mkdir()
        (tmp_path / "handed" / name / "estimate_state.py").write_text(code)
    return tmp_path


def test_a_class_is_graded(handed_in):
    status, said = ran(handed_in, "robsim", "grade", "hw3", "handed", "--out", "graded")
    assert status == 1, said
    assert "isolation: process, job object; not: user, files" in said
    with (handed_in / "graded/class.csv").open(encoding="utf-8-sig", newline="") as file:
        points = {row["student"]: float(row["points"]) for row in csv.DictReader(file)}
    assert points == {"anna": 6, "ben": 0, "zoe": 0}


def test_strict_isolation_is_refused(handed_in):
    status, said = ran(handed_in, "robsim", "grade", "hw3", "handed", "--isolation", "strict")
    assert status == 3
    assert "robsim knows no way on Windows" in said


def test_the_plugin_grades(tmp_path):
    (tmp_path / "m").mkdir()
    (tmp_path / "m/control.py").write_text("def control(step):\n    return 0.1, 0.2\n")
    (tmp_path / "test_mine.py").write_text(MINE)
    status, said = ran(tmp_path, "pytest", "-q", "--robsim-submission=m", "test_mine.py")
    assert status == 0, said
    assert "2 passed" in said
