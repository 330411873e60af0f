"""A class is graded: whatever its submissions do, and wherever it is ended."""

import json
import os
import signal
import sys
import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import pytest

from clusters import local_cluster
from robsim.assignments import Assignment, SubmissionResult
from robsim.assignments._grading import work
from robsim.grading import AssignmentError
from robsim.tasks import Limit
from small_assignments import LIMITS, TESTS, assignment, drawn_quickly, solution

HOSTILE = {
    "exits": "import os\ndef estimate_state(step):\n    os._exit(0)\n",
    "hangs": "while True:\n    pass\n",
    "floods": "def estimate_state(step):\n    while True:\n        print('x' * 10**6)\n",
    "kills": "import os, signal\ndef estimate_state(step):\n    os.kill(os.getppid(), 9)\n",
}
QUICK = 'limits = { call = 1.0, first_call = 2.0 }\nseeds = "class"\n'

pytestmark = pytest.mark.long


@pytest.fixture(autouse=True)
def quickly():
    with drawn_quickly():  # where this process grades
        yield


@pytest.fixture
def hw3(tmp_path):
    return Assignment.load(assignment(tmp_path / "hw3", QUICK + TESTS))


def handed_in(folder, names=("s001", "s003")):
    for name in names:
        solution(folder / name)
    return folder


def written(folder, name, text):
    place = folder / name
    place.mkdir(parents=True)
    (place / "estimate_state.py").write_text(text)


def result_of(out, student):
    return SubmissionResult.from_json((out / student / "result.json").read_text())


@pytest.mark.slow
def test_hostile_submissions_do_not_keep_others_from_their_points(hw3, tmp_path):
    subs = handed_in(tmp_path / "subs")
    for name, text in HOSTILE.items():
        written(subs, name, text)
    (subs / "s002.zip").write_bytes(b"no zip")
    (subs / ".DS_Store").write_bytes(b"left by a tool")
    result = hw3.grade_class(subs, tmp_path / "out", executor=2)
    points = {one.student: one.points for one in result.results}
    assert points == {"s001": 6, "s003": 6, "s002": 0} | dict.fromkeys(HOSTILE, 0)
    assert not result.has_errors
    assert not result.is_full
    assert [one.student for one in result.results] == sorted(points)
    for student in points:
        assert result_of(tmp_path / "out", student).is_done
        assert (tmp_path / "out" / student / "index.html").exists()
    assert (tmp_path / "out/class.html").exists()
    assert "hw3: 7 submissions" in str(result)


@pytest.mark.parametrize(
    "executor",
    [
        "threads",
        *(
            pytest.param(one, marks=pytest.mark.slow)
            for one in (None, 2, ThreadPoolExecutor, ProcessPoolExecutor)
        ),
    ],
)
def test_the_results_are_the_same_wherever_they_are_computed(hw3, tmp_path, executor):
    subs = handed_in(tmp_path / "subs")
    written(subs, "s002", "def estimate_state(step):\n    return None\n")
    if isinstance(executor, type):
        with executor(2) as pool:
            result = hw3.grade_class(subs, tmp_path / "out", executor=pool)
    else:
        result = hw3.grade_class(subs, tmp_path / "out", executor=executor)
    expected = [hw3.grade(subs / name) for name in ("s001", "s002", "s003")]
    for one, other in zip(result.results, expected, strict=True):
        assert one.student == other.student
        for test, same in zip(one.tests, other.tests, strict=True):
            assert repr(test.scores) == repr(same.scores)  # there are NaN among them
            assert (test.points, test.sentence) == (same.points, same.sentence)


@pytest.mark.slow
def test_a_cluster_gives_the_same_results(hw3, tmp_path):
    subs = handed_in(tmp_path / "subs")
    with local_cluster(tmp_path) as client:
        result = hw3.grade_class(subs, tmp_path / "out", executor=client)
    assert [one.points for one in result.results] == [6, 6]
    here = hw3.grade_class(subs, tmp_path / "here")
    for one, other in zip(result.results, here.results, strict=True):
        assert [test.scores for test in one.tests] == [test.scores for test in other.tests]


def counting(monkeypatch):
    """Count the tests that are run."""
    ran = []
    true = work.run_task_test

    def counted(assignment, test, path, student, *others):
        ran.append((student, test.name))
        return true(assignment, test, path, student, *others)

    monkeypatch.setattr(work, "run_task_test", counted)
    return ran


def test_what_is_done_is_not_done_again(hw3, tmp_path, monkeypatch):
    subs, out = handed_in(tmp_path / "subs"), tmp_path / "out"
    ran = counting(monkeypatch)
    first = hw3.grade_class(subs, out)
    assert len(ran) == 4
    assert hw3.grade_class(subs, out) == first
    assert len(ran) == 4
    handed_in(subs, ["s004"])
    hw3.grade_class(subs, out)
    assert ran[4:] == [("s004", "shown"), ("s004", "hidden")]


def test_what_has_changed_is_graded_anew(hw3, tmp_path, monkeypatch):
    subs, out = handed_in(tmp_path / "subs"), tmp_path / "out"
    hw3.grade_class(subs, out)
    ran = counting(monkeypatch)
    (subs / "s003/estimate_state.py").write_text("def estimate_state(step):\n    return None\n")
    result = hw3.grade_class(subs, out)
    assert ran == [("s003", "shown"), ("s003", "hidden")]
    assert result.results[1].points < 6
    shown, hidden = hw3.tests
    noisier = replace(hidden, task=replace(hidden.task, noise=14.0))
    replace(hw3, tests=(shown, noisier)).grade_class(subs, out)
    assert ran[2:] == [("s001", "hidden"), ("s003", "hidden")]


def test_other_limits_and_points_need_no_run(hw3, tmp_path, monkeypatch):
    subs, out = handed_in(tmp_path / "subs"), tmp_path / "out"
    hw3.grade_class(subs, out)
    ran = counting(monkeypatch)
    changed = replace(hw3, tests=tuple(replace(t, points=10, limits=STRICT) for t in hw3.tests))
    anew = changed.regrade(out)
    assert [one.most for one in anew.results] == [20, 20]
    assert all(one.points < 20 for one in anew.results)
    assert changed.grade_class(subs, out) == anew
    assert ran == []
    assert result_of(out, "s001") == anew.results[0]


STRICT = {name: Limit(full=0.5, zero=1.5) for name in LIMITS}


def test_regrading_refuses_what_was_graded_by_other_tests(hw3, tmp_path):
    subs, out = handed_in(tmp_path / "subs", ["s001"]), tmp_path / "out"
    with pytest.raises(FileNotFoundError, match="there are no results"):
        hw3.regrade(out)
    hw3.grade_class(subs, out)
    before = (out / "s001/result.json").read_bytes()
    shown, hidden = hw3.tests
    noisier = replace(hidden, task=replace(hidden.task, noise=14.0), limits=STRICT)
    with pytest.raises(ValueError, match="the test hidden is not the one that s001 was graded by"):
        replace(hw3, tests=(shown, noisier)).regrade(out)
    assert (out / "s001/result.json").read_bytes() == before


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="looks for processes in /proc")
def test_a_process_that_is_killed_loses_its_test_alone_which_is_done_again(hw3, tmp_path):
    subs, out = handed_in(tmp_path / "subs", ["s001", "s002", "s003", "s004"]), tmp_path / "out"
    with ProcessPoolExecutor(2) as others:
        killing = others.submit(kill_a_worker_of, os.getpid())
        result = hw3.grade_class(subs, out, executor=2)
        assert killing.result()
    assert result.is_full


def kill_a_worker_of(parent):
    """Kill one of the processes of a pool that grades, once it is there."""
    own = {os.getpid(), os.getppid()}
    for _ in range(600):
        for task in Path(f"/proc/{parent}/task").iterdir():
            for child in map(int, (task / "children").read_text().split()):
                name = Path(f"/proc/{child}/cmdline").read_bytes()
                if child not in own and b"spawn_main" in name and is_grading(child):
                    os.kill(child, signal.SIGKILL)
                    return True
        time.sleep(0.05)
    return False


def is_grading(process):
    """Whether a process has started a zygote."""
    tasks = Path(f"/proc/{process}/task").iterdir()
    return any((task / "children").read_text().strip() for task in tasks)


def test_two_submissions_of_one_student_are_refused(hw3, tmp_path):
    subs = handed_in(tmp_path / "subs", ["s001"])
    (subs / "s001.py").write_text("def estimate_state(step):\n    return None\n")
    with pytest.raises(AssignmentError, match=r"two submissions of s001, s001, s001\.py: keep"):
        hw3.grade_class(subs, tmp_path / "out")


def test_results_do_not_lie_among_submissions(hw3, tmp_path):
    subs = handed_in(tmp_path / "subs")
    for out in (subs / "out", subs / "s001/out", subs):
        with pytest.raises(ValueError, match="out must be apart from the submissions"):
            hw3.grade_class(subs, out)


def test_a_result_that_cannot_be_read_is_made_anew(hw3, tmp_path):
    subs, out = handed_in(tmp_path / "subs", ["s001"]), tmp_path / "out"
    (out / "s001").mkdir(parents=True)
    (out / "s001/result.json").write_text("{")
    assert hw3.grade_class(subs, out).is_full
    json.loads((out / "s001/result.json").read_text())
