"""Tests of the teacher's own: plain files for pytest, whose functions have points."""

from dataclasses import replace

import pytest

from robsim.teach import AssignmentError, grade_submission, load_assignment
from small_assignments import PATIENT, assignment

pytestmark = pytest.mark.long

HEAD = """
name = "hw4"
title = "Drive"
slots = ["control"]
functions = ["fit"]

[[files]]
path = "own.py"
public = PUBLIC
"""
OWN = '''
import time
import numpy as np
import pytest
import robsim

WORLD = robsim.Scenario(area=(400, 400), resolution=(200, 200), measure=True)


@pytest.mark.points(2, success="Well driven.", failure="The robot stands still.")
def test_drives(submission):
    """The robot drives."""
    trace = submission.run(WORLD, steps=10)
    assert np.abs(trace.u).max() > 0.5


@pytest.mark.points(1)
def test_within_bounds(submission):
    trace = submission.run(WORLD, steps=10)
    assert np.abs(trace.u).max() < 3, "more than 3 V"


@pytest.mark.points(1.5)
@pytest.mark.robsim_submission(functions="fit")
def test_fits(submission):
    assert submission.call("fit", np.arange(3.0)) == pytest.approx(3.0)


@pytest.mark.points(1)
def test_of_a_teacher_who_errs(submission):
    WORLD.no_such_thing


def test_without_points(submission):
    pytest.skip("not today")
'''
GOOD = "def control(step):\n    return 1.0, 1.0\n"


def made(folder, own=OWN, public="true"):
    text = PATIENT + HEAD.replace("PUBLIC", public)
    return load_assignment(assignment(folder, text, limits=(), own=own))


def handed_in(folder, control=GOOD, **functions):
    folder.mkdir()
    (folder / "control.py").write_text(control)
    for name, text in functions.items():
        (folder / f"{name}.py").write_text(text)
    return folder


def results(hw4, submission, **limits):
    return {test.name: test for test in grade_submission(replace(hw4, **limits), submission).tests}


def test_a_good_submission_has_the_points_whatever_else_is_broken(tmp_path):
    hw4 = made(tmp_path / "hw4")
    good = handed_in(tmp_path / "s001", fit="def fit(x):\n    return x.sum()\n")
    result = grade_submission(hw4, good)
    told = {test.name: test for test in result.tests}
    drives = told["test_drives"]
    # Titles, points and messages come from the file.
    assert (drives.title, drives.points, drives.public) == ("The robot drives", 2, True)
    assert (drives.status, drives.sentence) == ("passed", "Well driven.")
    assert told["test_within_bounds"].title == "within bounds"
    assert told["test_fits"].points == 1.5
    erring = told["test_of_a_teacher_who_errs"]
    assert (erring.status, erring.whose, erring.points) == ("error", "assignment", 0)
    assert "AttributeError" in erring.sentence
    assert told["test_without_points"].status == "not run"
    assert (result.points, result.most) == (4.5, 5.5)
    assert result.has_errors
    assert not result.is_done
    with pytest.raises(AssignmentError, match="test_drives"):  # twice
        grade_submission(replace(hw4, files=hw4.files * 2), good)


@pytest.mark.slow
def test_what_the_submission_does_is_its_fault(tmp_path):
    hw4 = made(tmp_path / "hw4")
    wild = handed_in(tmp_path / "s002", "def control(step):\n    return 0.1 / (step.k - 3), 9.0\n")
    told = results(hw4, wild)
    fails, bounds = told["test_drives"], told["test_within_bounds"]
    assert (fails.status, fails.whose) == ("failed", "submission")
    assert "The robot stands still." in fails.sentence
    assert "control at step 3" in fails.sentence
    assert "ZeroDivisionError" in bounds.sentence
    source = "def control(step):\n    print('fast')\n    return 9.0, 9.0\n"
    fast = results(hw4, handed_in(tmp_path / "s003", source))
    assert fast["test_within_bounds"].output.startswith("fast\n")
    assert fast["test_within_bounds"].sentence == "more than 3 V"
    assert fast["test_drives"].status == "passed"
    assert "fit" in fast["test_fits"].sentence


@pytest.mark.slow
def test_of_hidden_tests_nothing_is_told_but_their_own_message(tmp_path):
    hw4 = made(tmp_path / "hw4", public="false")
    text = "def control(step):\n    raise OSError('7')\n"
    told = results(hw4, handed_in(tmp_path / "s003", text))
    assert told["test_drives"].sentence == "The robot stands still."
    assert told["test_within_bounds"].sentence == "It has failed."


@pytest.mark.slow
def test_a_file_that_hangs_or_ends_leaves_what_came_before(tmp_path):
    first, *_ = OWN.partition("@pytest.mark.points(1)\n")
    ending = first + "def test_ends(submission):\n    import os\n    os._exit(0)\n"
    told = results(made(tmp_path / "a", ending), handed_in(tmp_path / "s001"))
    assert told["test_drives"].status == "passed"
    assert (told["test_ends"].status, told["test_ends"].whose) == ("error", "assignment")
    hanging = first + "def test_hangs(submission):\n    time.sleep(3000)\n"
    told = results(made(tmp_path / "b", hanging), handed_in(tmp_path / "s002"), seconds=5.0)
    assert told["test_drives"].status in ("passed", "not run")  # where the machine is too busy
    assert told["test_hangs"].status == "not run"


@pytest.mark.parametrize(
    ("own", "named"),
    [
        ("def test_x(submission:\n", "SyntaxError"),
        ("x = 1\n", "no tests"),
        ("import pytest\n@pytest.mark.points('2')\ndef test_x(): ...\n", "points"),
    ],
)
def test_a_file_that_is_broken_scores_nothing(tmp_path, own, named):
    hw4 = made(tmp_path / "hw4", own)
    with pytest.raises(AssignmentError, match=rf"own\.py(.|\n)*{named}"):
        grade_submission(hw4, handed_in(tmp_path / "s001"))
