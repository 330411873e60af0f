"""A grader that is killed at any moment loses one test, and the next call goes on."""

import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from robsim.assignments import Assignment, SubmissionResult
from robsim.assignments._grading import work
from small_assignments import TESTS, assignment, drawn_quickly, solution

pytestmark = [
    pytest.mark.long,
    pytest.mark.skipif(os.name == "nt", reason="there, processes are ended in another way"),
]
PROGRAM = Path(__file__).parents[1] / "support/killed_grading.py"


def made(tmp_path):
    hw3 = assignment(tmp_path / "hw3", 'seeds = "class"\n' + TESTS)
    for student in ("s001", "s002", "s003"):
        solution(tmp_path / "subs" / student)
    return hw3, tmp_path / "subs", tmp_path / "out"


def started(*paths):
    return subprocess.Popen([sys.executable, str(PROGRAM), *map(str, paths)])


def results(out):
    """What came of each submission so far; each file can be read."""
    files = sorted(out.glob("*/result.json"))
    return [SubmissionResult.from_json(file.read_text()) for file in files]


def done(out):
    """The tests that need not be run again, by the student."""
    return {(r.student, t.name) for r in results(out) for t in r.tests if t.digest}


def went_on(hw3, subs, out, monkeypatch):
    """Grade what is left; return the tests that were run for it."""
    ran = set()
    true = work.run_task_test

    def counted(assignment, test, path, student, *others):
        ran.add((student, test.name))
        return true(assignment, test, path, student, *others)

    monkeypatch.setattr(work, "run_task_test", counted)
    with drawn_quickly():
        result = Assignment.load(hw3).grade_class(subs, out)
    assert result.is_full
    return ran


def without_times(result):
    tests = tuple(replace(test, seconds=0.0, picture=None) for test in result.tests)
    return repr(result.replace(tests=tests, seconds=0.0, isolation="").to_json())


@pytest.mark.parametrize("tests_done", [1, pytest.param(3, marks=pytest.mark.slow)])
def test_a_grader_that_is_killed_loses_one_test(tmp_path, monkeypatch, tests_done):
    hw3, subs, out = made(tmp_path)
    grader = started(hw3, subs, out)
    while grader.poll() is None and len(done(out)) < tests_done:
        time.sleep(0.01)
    grader.send_signal(signal.SIGKILL)
    grader.wait()
    kept = done(out)
    assert len(kept) >= tests_done
    everything = {(s, t) for s in ("s001", "s002", "s003") for t in ("shown", "hidden")}
    assert went_on(hw3, subs, out, monkeypatch) == everything - kept


@pytest.mark.slow
def test_results_are_whole_whenever_the_grader_is_killed(tmp_path, monkeypatch, rng):
    hw3, subs, out = made(tmp_path)
    deaths = 0
    while True:
        grader = started(hw3, subs, out)
        try:
            grader.wait(rng.uniform(0.5, 5.0))
        except subprocess.TimeoutExpired:
            grader.send_signal(signal.SIGKILL)
            grader.wait()
            deaths += 1
        for result in results(out):  # raises for half a file
            assert 0 <= result.points <= result.most
        if grader.returncode == 0:
            break
        assert grader.returncode == -signal.SIGKILL
        assert deaths < 100
    whole = made(tmp_path / "again")[2]
    with drawn_quickly():
        Assignment.load(hw3).grade_class(subs, whole)
    for one, other in zip(results(out), results(whole), strict=True):
        assert without_times(one) == without_times(other)
    leftovers = [file for file in out.rglob("*") if file.name.startswith(".robsim-part")]
    assert len(leftovers) <= deaths
    assert np.isfinite([result.points for result in results(out)]).all()


@pytest.mark.slow
def test_ctrl_c_keeps_what_is_done(tmp_path, monkeypatch):
    hw3, subs, out = made(tmp_path)
    grader = started(hw3, subs, out)
    while grader.poll() is None and not done(out):
        time.sleep(0.01)
    grader.send_signal(signal.SIGINT)
    assert grader.wait() != 0
    kept = done(out)
    assert not went_on(hw3, subs, out, monkeypatch) & kept
