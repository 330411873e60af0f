"""A grader that is killed at any moment loses one test, and the next call goes on."""

import os
import signal
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from robsim.teach import SubmissionResult, grade_class, load_assignment
from sizes import thorough
from small_assignments import PATIENT, TESTS, assignment, drawn_quickly, solution
from waiting import wait_for

pytestmark = [
    pytest.mark.long,
    pytest.mark.skipif(os.name == "nt", reason="there, processes are ended in another way"),
]
PROGRAM = Path(__file__).parents[1] / "support/killed_grading.py"
STUDENTS = ("s001", "s002", "s003")


@pytest.fixture
def course(tmp_path):
    hw3 = assignment(tmp_path / "hw3", 'seeds = "class"\n' + PATIENT + TESTS)
    for student in STUDENTS:
        solution(tmp_path / "subs" / student)
    return hw3, tmp_path / "subs", tmp_path / "out"


def started(paths):
    return subprocess.Popen([sys.executable, str(PROGRAM), *map(str, paths)])


def results(out):
    """What came of each submission so far; each file can be read."""
    files = sorted(out.glob("*/result.json"))
    return [SubmissionResult.from_json(file.read_text()) for file in files]


def done(out):
    """The tests that need not be run again, by the student."""
    return {(r.student, t.name) for r in results(out) for t in r.tests if t.digest}


def wait_for_tests(grader, out, tests):
    """Return once so many tests are done, or the grader has ended."""
    wait_for(lambda: grader.poll() is not None or len(done(out)) >= tests)


def go_on(course):
    """Grade what is left."""
    hw3, subs, out = course
    with drawn_quickly():
        assert grade_class(load_assignment(hw3), subs, out).is_full


def without_times(result):
    tests = tuple(replace(test, seconds=0.0, picture=None) for test in result.tests)
    return repr(replace(result, tests=tests, seconds=0.0, isolation="", command="").to_json())


@pytest.mark.parametrize("tests_done", [1, pytest.param(3, marks=pytest.mark.slow)])
def test_a_grader_that_is_killed_loses_one_test(course, ran, tests_done):
    grader = started(course)
    wait_for_tests(grader, course[2], tests_done)
    grader.send_signal(signal.SIGKILL)
    grader.wait()
    kept = done(course[2])
    assert len(kept) >= tests_done
    everything = {(s, t) for s in STUDENTS for t in ("shown", "hidden")}
    go_on(course)
    assert set(ran) == everything - kept


@pytest.mark.slow
def test_results_are_whole_whenever_the_grader_is_killed(course, tmp_path, rng):
    """Each time it is killed a moment after it has done another test."""
    hw3, subs, out = course
    deaths, most = 0, thorough(20, 4)
    while deaths < most:
        grader = started(course)
        wait_for_tests(grader, out, len(done(out)) + 1)
        try:
            grader.wait(rng.uniform(0, 0.3))
        except subprocess.TimeoutExpired:
            grader.send_signal(signal.SIGKILL)
            grader.wait()
            deaths += 1
        for result in results(out):  # raises for half a file
            assert 0 <= result.points <= result.most
        if grader.returncode == 0:
            break
        assert grader.returncode == -signal.SIGKILL
    assert deaths
    with drawn_quickly():
        grade_class(load_assignment(hw3), subs, out)
        grade_class(load_assignment(hw3), subs, tmp_path / "whole")
    for one, other in zip(results(out), results(tmp_path / "whole"), strict=True):
        assert without_times(one) == without_times(other)
    leftovers = [file for file in out.rglob("*") if file.name.startswith(".robsim-part")]
    assert len(leftovers) <= deaths
    assert np.isfinite([result.points for result in results(out)]).all()


@pytest.mark.slow
def test_ctrl_c_keeps_what_is_done(course, ran):
    grader = started(course)
    wait_for_tests(grader, course[2], 1)
    grader.send_signal(signal.SIGINT)
    grader.wait()
    kept = done(course[2])
    assert kept
    go_on(course)
    assert not set(ran) & kept
