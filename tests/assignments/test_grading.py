"""Submissions are graded: points, sentences, numbers, and whose fault it is."""

import gc
import math
import re
import shutil
import textwrap
from dataclasses import replace

import pytest

from graded import graded_run
from graded_results import FailedRun
from robsim.teach import (
    AssignmentError,
    Key,
    ScoreLimit,
    SubmissionError,
    grade_submission,
    play_run,
    task,
)
from robsim.teach.assignments.assignment import TaskTest
from robsim.teach.assignments.marking import marking, references, task_runs
from robsim.teach.assignments.marking import references as seeds
from robsim.teach.grading.calling import judged
from robsim.teach.submissions.reading import open_submission
from robsim.trace import Trace
from small_assignments import LIMITS, drawn_quickly

pytestmark = pytest.mark.long


@pytest.fixture(autouse=True)
def quickly():
    with drawn_quickly():
        yield


@pytest.fixture
def hw3(graded_class):
    return graded_class.assignment


@pytest.fixture
def right(graded_class):
    return graded_class.submissions / "s001"


@pytest.fixture
def graded(graded_class):
    """What came of the reference, handed in."""
    return graded_class.of("s001")


def written(folder, text):
    folder.mkdir()
    (folder / "estimate_state.py").write_text(textwrap.dedent(text))
    return folder


def test_the_reference_itself_has_all_points(graded):
    assert (graded.points, graded.most) == (6, 6)
    assert graded.is_done
    assert not graded.has_errors
    assert graded.isolation.startswith("isolation: ")
    for test in graded.tests:
        position, heading, _ = test.scores
        # the same code in the same worlds
        assert position.values == pytest.approx(position.reference, rel=1e-9)
        assert heading.statistic == pytest.approx(1, rel=1e-9)
        assert (test.status, test.failed, test.finding) == ("passed", (), "")
    assert "s001, Through dropouts" in str(graded)


def test_a_student_name_without_a_folder_has_a_folder_of_another_name(hw3, right, tmp_path):
    with pytest.raises(ValueError, match="student"):
        grade_submission(hw3, right, tmp_path / "out/in", student="")
    assert grade_submission(hw3, right, tmp_path / "out/in", student="../b").student == "../b"
    (result,) = tmp_path.rglob("result.json")
    assert result.parent.parent == tmp_path / "out/in"


def test_a_naive_solution_loses_points_and_is_told_why(graded_class):
    shown, hidden = graded_class.of("s002").tests
    assert shown.points < shown.most
    assert shown.status in ("partial", "failed")
    for sentence in (shown.sentence, hidden.sentence):
        assert re.search("position|heading|NEES", sentence)
    # By how much is told of what is public.
    assert "times the reference" in shown.sentence
    assert not re.search(r"\d\.\d", hidden.sentence)
    # The doctor says what is wrong, and where.
    assert "covariance" in shown.finding
    assert "estimate_state.py:" in shown.finding
    assert hidden.finding == shown.finding


def test_a_submission_that_fails_is_told_the_slot_the_step_and_the_line(graded_class):
    result = graded_class.of("s003")
    shown, hidden = result.tests
    assert (result.points, shown.status, shown.whose) == (0, "failed", "submission")
    first = shown.failed[0]
    assert (first.slot, first.step) == ("estimate_state", 7)
    assert (first.file, first.line) == ("estimate_state.py", 5)
    assert "ValueError: at 7" in shown.sentence
    assert all(math.isnan(score.statistic) for score in shown.scores)
    assert "failed" in hidden.sentence
    assert "7" not in hidden.sentence
    assert result.is_done
    assert (shown.worst, shown.picture) == (0, "shown.png")


@pytest.mark.parametrize(
    ("does", "limits", "how"),
    [
        ("while True: pass", {"call": 0.2, "first_call": 0.2}, "took too long"),
        ("import os; os._exit(0)", {}, "ended its process"),
        ("raise ValueError('its process exited: it took longer than 1 s')", {}, "failed"),
    ],
)
def test_a_hidden_test_says_how_a_run_ended_and_no_more(
    hw3, tmp_path, monkeypatch, does, limits, how
):
    monkeypatch.setattr("robsim.teach.assignments.marking.findings._SECONDS", 0.2)
    limited = replace(hw3, limits=replace(hw3.limits, **limits))
    result = grade_submission(
        limited, written(tmp_path / "s004", f"def estimate_state(step):\n    {does}\n")
    )
    shown, hidden = result.tests
    assert hidden.sentence == f"All runs ended early: estimate_state {how}."
    assert (shown.worst, shown.picture) == (0, None)


def test_a_run_that_fails_is_shown_where_that_costs_more(hw3, graded):
    failed = (FailedRun(run=1, reason="it ended", step=3),)
    half = marking.marked_anew(hw3.tests[0], replace(graded.tests[0], failed=failed))
    assert half.points == half.most / 2
    assert half.status == "partial"
    assert "Run 1: it ended" in half.sentence
    assert marking.run_to_show(half, [0]) == 1
    at_once = FailedRun(run=0, reason="it ended", step=0)
    assert marking.run_to_show(replace(half, failed=(at_once, *failed)), []) == 1
    assert marking.run_to_show(replace(half, failed=(at_once,)), [1]) == 0
    bad = tuple(replace(score, fraction=0.0) for score in half.scores)
    assert marking.run_to_show(replace(half, failed=failed, scores=bad, runs=4), [2, 0]) == 0
    assert marking.run_to_show(replace(half, failed=()), [1, 0]) == 0


def test_a_lost_score_is_told_in_a_sentence():
    told = {}
    for name in ("measure", "follow"):
        one = task(name, runs=1)
        limits = {score.name: ScoreLimit(full=2.0, zero=9.0) for score in one.scores}
        numbers = {score.name: [1.0] for score in one.scores}
        for lost in one.scores:
            for public in (False, True):
                test = TaskTest(
                    name="t", title="T", task=one, points=1, public=public, limits=limits
                )
                mark = marking.mark_of(test, (), numbers | {lost.name: [100.0]}, numbers)
                told[lost.name, public] = mark.sentence
    frames = (
        "The share of frames with a false pose, or without one where the robot can be seen, is "
    )
    assert told["lost", False] == f"{frames}too large."
    assert told["lost", True].startswith(f"{frames}too large: ")
    assert told["left", False].startswith("The share of missed waypoints ")
    assert told["heading", False] == "The error of the heading is too large."


def test_runs_without_a_number_are_counted_and_the_next_costly_score_orders_them():
    one = task("park", runs=3)
    limits = {score.name: ScoreLimit(full=1.5, zero=3.0) for score in one.scores}
    test = TaskTest(name="t", title="T", task=one, points=1, limits=limits)
    met = {score.name: [10.0] * 3 for score in one.scores}
    mark = marking.mark_of(
        test, (), met | {"settling": [math.nan] * 3, "heading": [60, 80, 25]}, met
    )
    told = "3 of 3 runs have no settling time at the pose, and count as the worst."
    assert mark.sentence == f"{told} The heading error at the end is 25 to 80 deg."
    assert marking.runs_by_badness(test, mark) == [2, 0, 1]


def test_a_run_that_fails_is_played_up_to_there(graded_class, tmp_path):
    hw3 = graded_class.assignment
    again = play_run(hw3, graded_class.submissions / "s003", "hidden", 1)
    assert len(again.trace) == 7
    assert "ValueError: at 7" in again.failed
    assert again.picture().startswith(b"\x89PNG")
    never = written(tmp_path / "s005", "def estimate_state(step):\n    raise ValueError\n")
    with pytest.raises(SubmissionError, match="at step 0"):
        play_run(hw3, never, "hidden", 1)


def test_points_are_linear_in_the_logarithm_between_the_limits(hw3, graded):
    test, result = hw3.tests[0], graded.tests[0]
    wide = {name: ScoreLimit(full=10.0, zero=20.0) for name in LIMITS}
    assert marking.marked_anew(replace(test, limits=wide), result).points == 2
    # the statistic of position and heading is 1: half way between 1 / 2 and 2
    middle = wide | {name: ScoreLimit(full=0.5, zero=2.0) for name in ("position", "heading")}
    again = marking.marked_anew(replace(test, limits=middle), result)
    assert again.points == pytest.approx(2 * (0.5 * 0.7 + 0.3))


def test_a_submission_that_cannot_be_read_or_has_what_is_masked_is_told_so(hw3, tmp_path):
    (tmp_path / "s004.txt").write_text("my solution")
    result = grade_submission(hw3, tmp_path / "s004.txt")
    assert (result.points, result.student) == (0, "s004.txt")
    assert "s004.txt" in result.tests[0].sentence
    text = "import robsim.estimation.reference\ndef estimate_state(step):\n    return None\n"
    result = grade_submission(hw3, written(tmp_path / "s005", text), only="shown")
    assert "robsim.estimation.reference is unavailable" in result.tests[0].sentence
    assert [test.status for test in result.tests] == ["failed", "not run"]
    with pytest.raises(ValueError, match="'show'"):
        grade_submission(hw3, tmp_path / "s005", only="show")


def test_each_student_has_worlds_of_their_own_but_in_public_tests(hw3):
    shown, hidden = hw3.tests
    own = references.References(hw3)
    assert own.numbers(shown, "s001", 0) == own.numbers(shown, "s002", 0)
    mine = own.numbers(hidden, "s001", 0)
    assert mine != own.numbers(hidden, "s002", 0)
    assert mine != references.References(replace(hw3, key=Key.new())).numbers(hidden, "s001", 0)
    alike = references.References(replace(hw3, own_seeds=False))
    assert alike.numbers(hidden, "s001", 0) == alike.numbers(hidden, "s002", 0)


def test_public_runs_need_no_key_and_the_numbers_of_the_reference_can_stand_in_for_it(
    hw3, right, graded
):
    shown, _ = hw3.tests
    own = references.References(hw3)
    runs = [own.numbers(shown, "", run) for run in range(shown.task.runs)]
    values = {name: tuple(run[name] for run in runs) for name in runs[0]}
    known = replace(shown, reference=None, reference_values=values)
    public = grade_submission(
        replace(hw3, tests=(known,), key=None), right, public=True, student="student"
    )
    assert [test.scores for test in public.tests] == [graded.tests[0].scores]
    assert public.is_done


def test_a_run_played_again_is_the_one_that_was_graded(hw3, right, graded):
    hidden = graded.tests[1]
    again = play_run(hw3, right, "hidden", 1)
    position = hidden.scores[0]
    assert again.numbers["position"] == position.values[1]
    assert again.reference_numbers["position"] == position.reference[1]
    with pytest.raises(ValueError, match="run must lie within"):
        play_run(hw3, right, "hidden", 2)
    with pytest.raises(ValueError, match="'hiden'"):
        play_run(hw3, right, "hiden", 1)


def test_the_worst_run_is_played_and_written_where_results_are(graded_class, tmp_path):
    hw3, subs = graded_class.assignment, graded_class.submissions
    out = shutil.copytree(graded_class.out, tmp_path / "out")
    again = play_run(hw3, subs / "s002", "hidden", out=out)
    assert again.run == graded_class.of("s002").tests[1].worst
    trace, picture = again.files
    assert trace == out / f"s002/hidden-run{again.run}.npz"
    assert len(Trace.load(trace)) == 20
    assert picture.read_bytes() == again.picture()
    other = play_run(hw3, subs / "s002", "hidden")
    assert (other.run, other.files) == (0, ())
    assert "worst" in str(other)


def task_for(hw3, path):
    """Return the task of a submission in the first test."""
    contents = open_submission(path, hw3._rules())
    files = task_runs.files_for(hw3, hw3.tests[0], contents)
    return task_runs.graded_task(hw3, hw3.tests[0], files)


def test_a_run_that_failed_gives_its_steps_and_keeps_no_worker(graded_class):
    hw3 = graded_class.assignment
    task = task_for(hw3, graded_class.submissions / "s003")
    numbers = seeds.seeds_of(hw3, hw3.tests[0], "s003", 0)
    gc.collect()
    gc.disable()
    try:
        try:
            graded_run(task, hw3.tests[0].task.scenario, 20, numbers)
        except SubmissionError as error:
            steps = len(error.trace)
        kept = [one for one in gc.get_objects() if type(one).__name__ == "GradedSimulation"]
    finally:
        gc.enable()
    assert (steps, kept) == (7, [])


def test_a_submission_that_takes_all_the_time_does_not_keep_the_others(hw3, tmp_path):
    text = "import time\ndef estimate_state(step):\n    time.sleep(3000)\n"
    result = grade_submission(replace(hw3, seconds=1.0), written(tmp_path / "s006", text))
    shown, hidden = result.tests
    assert (shown.points, hidden.points) == (0, 0)
    assert "all the available time" in hidden.sentence
    assert hidden.status == "not run"
    assert result.is_done


@pytest.mark.parametrize(
    ("changes", "of_shown", "named"),
    [
        ({"key": None}, {}, "key"),
        ({}, {"stale": "the task is not"}, "shown.*the task is not"),
        ({}, {"limits": {}}, "shown.*position"),
        ({}, {"reference": None}, "shown.*reference"),
        ({}, {"reference": "broken"}, "shown.*ZeroDivisionError"),
        ({}, {"reference_values": dict.fromkeys(LIMITS, (1.0,))}, "shown, one per run, got 1"),
    ],
)
def test_an_assignment_that_is_broken_scores_nothing(hw3, right, changes, of_shown, named):
    shown, hidden = hw3.tests
    if of_shown.get("reference") == "broken":
        files = {"estimate_state": b"def estimate_state(step):\n    return 1 / 0\n"}
        of_shown = {"reference": replace(shown.reference, files=files)}
    broken = replace(hw3, tests=(replace(shown, **of_shown), hidden), **changes)
    with pytest.raises(AssignmentError, match=named) as caught:
        grade_submission(broken, right)
    assert caught.value.whose == "assignment"


def test_what_is_said_in_place_of_the_doctor_is_text_of_the_submission(hw3, tmp_path):
    text = """
    import socket, struct, sys, gc
    import robsim, numpy as np
    def estimate_state(step):
        for frame in [sys._getframe(n) for n in range(9)]:
            pass
        return robsim.Estimate((600.0, 600.0, 0.0), np.eye(3))
    for one in gc.get_objects():
        if type(one).__name__ == "Channel":
            said = b"\\x1b[31m<b>all points</b>"
            one._socket.sendall(struct.pack("<HHI", 8, 0, len(said)) + said)
    """
    place = written(tmp_path / "s008", text)
    task = task_for(hw3, place)
    said = judged(task, "robsim.teach.doctor._finding:first_finding", 300.0).result
    assert said == "\\x1b[31m<b>all points</b>"  # escaped, and for others to escape in HTML
    assert grade_submission(hw3, place, only="shown").points == 0


@pytest.mark.parametrize(
    "source",
    ["while True:\n    pass\n", "def estimate_state(step):\n    while True:\n        pass\n"],
)
def test_what_cannot_begin_is_not_tried_in_each_run(hw3, tmp_path, source):
    many = replace(hw3.tests[0], task=replace(hw3.tests[0].task, runs=5))
    slow = replace(hw3, tests=(many,), limits=replace(hw3.limits, first_call=0.1))
    result = grade_submission(slow, written(tmp_path / "s009", source)).tests[0]
    reasons = [run.reason for run in result.failed]
    assert all("0.1 s" in reason for reason in reasons[:3])
    assert reasons[3] == reasons[4] != reasons[0]
    assert "not run" in reasons[3]
