"""Grading on Windows, from the command and from pytest."""

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
"""


def ran(folder, *words):
    """What a program of Python's says, and its status."""
    command = [sys.executable, "-m", *words]
    done = subprocess.run(command, cwd=folder, stdin=subprocess.DEVNULL, capture_output=True)
    return done.returncode, (done.stdout + done.stderr).decode().replace("\r\n", "\n")


def test_a_class_is_graded(tmp_path):
    assignment(tmp_path / "hw3")
    solution(tmp_path / "handed/anna")
    (tmp_path / "handed/zoe").mkdir()
    (tmp_path / "handed/zoe/estimate_state.py").write_text("import os\nos._exit(0)")
    words = ("robsim", "grade", "hw3", "handed", "--out", "graded", "--jobs", "1")
    status, said = ran(tmp_path, *words)
    assert status == 1, said
    assert "isolation: process; not: user, files" in said
    with (tmp_path / "graded/class.csv").open(encoding="utf-8-sig", newline="") as file:
        points = {row["student"]: float(row["points"]) for row in csv.DictReader(file)}
    assert points == {"anna": 6, "zoe": 0}


def test_the_plugin_grades(tmp_path):
    (tmp_path / "m").mkdir()
    (tmp_path / "m/control.py").write_text("def control(step):\n    return 0.1, 0.2\n")
    (tmp_path / "test_mine.py").write_text(MINE)
    status, said = ran(tmp_path, "pytest", "-q", "--robsim-submission=m", "test_mine.py")
    assert status == 0, said
    assert "1 passed" in said
