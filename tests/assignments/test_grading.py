"""Submissions are graded: points, sentences, numbers, and whose fault it is."""

import gc
import math
import re
import textwrap
from dataclasses import replace

import numpy as np
import pytest

from robsim.assignments import Assignment
from robsim.assignments._grading.marking import marked
from robsim.assignments._grading.references import References
from robsim.assignments._grading.seeds import seeds_of
from robsim.assignments._grading.task_runs import graded_task, run_to_show
from robsim.assignments._reports.words import caption_text
from robsim.assignments._results import FailedRun
from robsim.grading import AssignmentError, Key, Limits, SubmissionError
from robsim.grading._calls.judging import judged
from robsim.grading._graded_run import GradedSimulation, graded_run
from robsim.tasks import Limit
from small_assignments import LIMITS, assignment, drawn_quickly, solution

RAISES = """
import numpy as np, robsim
def estimate_state(step):
    if step.k == 7:
        raise ValueError(f"at {step.k}")
    return robsim.Estimate((600.0, 600.0, 0.0), np.eye(3))
"""

pytestmark = pytest.mark.long


@pytest.fixture(autouse=True)
def quickly():
    with drawn_quickly():
        yield


@pytest.fixture(scope="module")
def hw3(tmp_path_factory):
    return Assignment.load(assignment(tmp_path_factory.mktemp("a") / "hw3"))


@pytest.fixture(scope="module")
def right(hw3, tmp_path_factory):
    return solution(tmp_path_factory.mktemp("s") / "s001")


@pytest.fixture(scope="module")
def graded(hw3, right):
    with drawn_quickly():
        return hw3.grade(right)


def written(folder, text, slot="estimate_state"):
    folder.mkdir()
    (folder / f"{slot}.py").write_text(text)
    return folder


def test_the_reference_itself_has_all_points(graded):
    assert (graded.points, graded.most) == (6, 6)
    assert [test.status for test in graded.tests] == ["passed", "passed"]
    assert graded.is_done
    assert not graded.has_errors
    assert (graded.assignment, graded.student) == ("hw3", "s001")
    assert graded.isolation.startswith("isolation: ")
    assert set(graded.versions) == {"robsim", "numpy", "python"}
    for test in graded.tests:
        position, heading, _ = test.scores
        # the same code in the same worlds
        assert position.values == pytest.approx(position.reference, rel=1e-9)
        assert heading.statistic == pytest.approx(1, rel=1e-9)
        assert test.failed == ()
        assert test.worst in (0, 1)
        assert test.seconds > 0


def test_a_naive_solution_loses_points_and_is_told_where(hw3, tmp_path):
    tight = {name: Limit(full=1.0001, zero=1.5) for name in LIMITS}
    tests = tuple(replace(test, limits=tight) for test in hw3.tests)
    result = replace(hw3, tests=tests).grade(solution(tmp_path / "s002", "naive"))
    shown, hidden = result.tests
    assert shown.points < shown.most
    assert shown.status in ("partial", "failed")
    assert "too large" in shown.sentence
    assert "times that of the reference" in shown.sentence
    assert "too large" in hidden.sentence
    titles = r"(rms error of the (position|heading)|mean NEES of the pose / 3)"
    assert re.fullmatch(
        rf"The {titles}((, the {titles})? and the {titles} are| is) too large.", hidden.sentence
    )


def test_a_submission_that_fails_is_told_the_slot_the_step_and_the_line(hw3, tmp_path):
    result = hw3.grade(written(tmp_path / "s003", RAISES))
    shown, hidden = result.tests
    assert (result.points, shown.status, shown.whose) == (0, "failed", "submission")
    first = shown.failed[0]
    assert (first.slot, first.step, first.file, first.line) == (
        "estimate_state",
        7,
        "estimate_state.py",
        5,
    )
    assert "ValueError: at 7" in shown.sentence
    assert all(math.isnan(score.statistic) for score in shown.scores)
    assert hidden.sentence == "All runs ended early: estimate_state failed."
    assert result.is_done
    assert (shown.worst, shown.picture) == (0, "shown.png")
    assert caption_text(shown).startswith("Run 0, until it failed. ")


@pytest.mark.parametrize(
    ("does", "how"),
    [
        ("while True: pass", "took too long"),
        ("import os; os._exit(0)", "ended its process"),
        ("raise ValueError('x: its process ended by itself')", "failed"),
        ("raise ValueError('it took longer than 1 s')", "failed"),
    ],
)
def test_a_hidden_test_says_how_a_run_ended_and_no_more(hw3, tmp_path, does, how):
    text = f"def estimate_state(step):\n    {does}\n"
    quick = replace(hw3, limits=replace(hw3.limits, call=0.2, first_call=0.2))
    result = quick.grade(written(tmp_path / "s003", text))
    shown, hidden = result.tests
    assert hidden.sentence == f"All runs ended early: estimate_state {how}."
    assert (shown.worst, shown.picture) == (0, None)
    assert caption_text(shown) == "There is no picture: run 0 failed in its first step."


def test_a_run_that_fails_is_shown_where_that_costs_more(hw3, graded):
    failed = (FailedRun(run=1, reason="it ended", step=3),)
    half = marked(hw3.tests[0], replace(graded.tests[0], failed=failed))
    assert half.points == half.most / 2
    assert run_to_show(half, [0]) == 1
    at_once = FailedRun(run=0, reason="it ended", step=0)
    assert run_to_show(replace(half, failed=(at_once, *failed)), []) == 1
    assert run_to_show(replace(half, failed=(at_once,)), [1]) == 0
    bad = tuple(replace(score, fraction=0.0) for score in half.scores)
    assert run_to_show(replace(half, failed=failed, scores=bad, runs=4), [2, 0]) == 0
    assert run_to_show(replace(half, failed=()), [1, 0]) == 0


def test_a_run_that_fails_is_played_up_to_there(hw3, tmp_path):
    again = hw3.play(written(tmp_path / "s003", RAISES), "hidden", 1)
    assert len(again.trace) == 7
    assert "ValueError: at 7" in again.failed
    assert "the run ended early: " in str(again)
    assert again.picture().startswith(b"\x89PNG")
    never = written(tmp_path / "s005", "def estimate_state(step):\n    raise ValueError\n")
    with pytest.raises(SubmissionError, match="at step 0"):
        hw3.play(never, "hidden", 1)


def test_a_run_that_fails_takes_its_part_of_the_points(hw3, graded):
    test, result = hw3.tests[0], graded.tests[0]
    half = replace(
        result,
        failed=(FailedRun(run=1, reason="it ended"),),
        scores=tuple(
            replace(score, values=score.values[:1], reference=score.reference[:1])
            for score in result.scores
        ),
    )
    again = marked(test, half)
    assert again.points == pytest.approx(1.0)
    assert again.status == "partial"
    assert "1 of 2 runs ended early. Run 1: it ended." in again.sentence


def test_points_are_linear_in_the_logarithm_between_the_limits(hw3, graded):
    test, result = hw3.tests[0], graded.tests[0]
    wide = {name: Limit(full=10.0, zero=20.0) for name in LIMITS}
    assert marked(replace(test, limits=wide), result).points == 2
    # the statistic of position and heading is 1: half way between 1 / 2 and 2
    middle = wide | {name: Limit(full=0.5, zero=2.0) for name in ("position", "heading")}
    again = marked(replace(test, limits=middle), result)
    assert again.points == pytest.approx(2 * (0.5 * 0.7 + 0.3))


def test_a_submission_that_cannot_be_read_has_no_points_and_a_reason(hw3, tmp_path):
    (tmp_path / "s004.txt").write_text("my solution")
    result = hw3.grade(tmp_path / "s004.txt")
    assert result.points == 0
    assert {test.status for test in result.tests} == {"failed"}
    assert "is none of what can be graded" in result.tests[0].sentence
    assert result.student == "s004.txt"


def test_masked_modules_cannot_be_had(hw3, tmp_path):
    text = "import robsim.reference\ndef estimate_state(step):\n    return None\n"
    shown, _ = hw3.grade(written(tmp_path / "s005", text)).tests
    assert "robsim.reference is not there for this assignment" in shown.sentence


def test_each_student_has_worlds_of_their_own_but_in_public_tests(hw3, right):
    shown, hidden = hw3.tests
    references = References(hw3)
    assert references.numbers(shown, "s001", 0) == references.numbers(shown, "s002", 0)
    assert references.numbers(hidden, "s001", 0) != references.numbers(hidden, "s002", 0)
    alike = References(replace(hw3, own_seeds=False))
    assert alike.numbers(hidden, "s001", 0) == alike.numbers(hidden, "s002", 0)


def test_public_runs_need_no_key_and_are_the_same_everywhere(hw3, right):
    public = hw3.grade(right, public=True, student="somebody")
    (shown,) = public.tests
    here = replace(hw3, key=None).grade(right, public=True).tests[0]
    assert shown.scores == here.scores
    assert public.is_done


def test_numbers_of_the_reference_can_stand_in_for_it(hw3, right, graded):
    shown, _ = hw3.tests
    numbers = References(hw3).of_public_runs(shown)
    known = replace(
        shown,
        reference=None,
        reference_values={name: tuple(values) for name, values in numbers.items()},
    )
    result = replace(hw3, tests=(known,), key=None).grade(right)
    assert result.tests[0].scores == graded.tests[0].scores


def test_a_run_played_again_is_the_one_that_was_graded(hw3, right, graded):
    hidden = graded.tests[1]
    again = hw3.play(right, "hidden", 1)
    position = hidden.scores[0]
    assert again.numbers["position"] == position.values[1]
    assert again.reference_numbers["position"] == position.reference[1]
    seeds = seeds_of(hw3, hw3.tests[1], "s001", 1)
    task = graded_task(hw3, hw3.tests[1], str(right))
    other = graded_run(task, hw3.tests[1].task.scenario, 20, seeds).result
    assert np.array_equal(other.pose_true, again.trace.pose_true)
    assert again.picture().startswith(b"\x89PNG")
    assert "s001, hidden, run 1" in str(again)
    with pytest.raises(ValueError, match=r"run must lie within 0\.\.1, got 2"):
        hw3.play(right, "hidden", 2)
    with pytest.raises(ValueError, match="has no test by a task 'hiden': did you mean 'hidden'"):
        hw3.play(right, "hiden", 1)


def test_a_run_that_failed_gives_its_steps_and_keeps_no_worker(hw3, tmp_path):
    task = graded_task(hw3, hw3.tests[0], str(written(tmp_path / "s003", RAISES)))
    seeds = seeds_of(hw3, hw3.tests[0], "s003", 0)
    gc.collect()
    gc.disable()
    try:
        try:
            graded_run(task, hw3.tests[0].task.scenario, 20, seeds)
        except SubmissionError as error:
            steps = len(error.trace)
        kept = [one for one in gc.get_objects() if type(one) is GradedSimulation]
    finally:
        gc.enable()
    assert (steps, kept) == (7, [])


def test_tests_that_are_not_asked_for_are_not_run(hw3, right):
    result = hw3.grade(right, only=["shown"])
    assert [test.status for test in result.tests] == ["passed", "not run"]
    assert not result.is_done
    with pytest.raises(ValueError, match="hw3 has no test 'show': did you mean 'shown'"):
        hw3.grade(right, only="show")


def test_a_submission_that_takes_all_the_time_does_not_keep_the_others(hw3, tmp_path):
    text = "import time\ndef estimate_state(step):\n    time.sleep(60)\n"
    quick = Limits(call=1.0, first_call=1.0)
    short = replace(hw3, limits=quick, seconds=2.0)
    result = short.grade(written(tmp_path / "s006", text))
    shown, hidden = result.tests
    assert "took longer than" in shown.sentence
    assert "all the time that there is" in hidden.sentence
    assert (hidden.status, hidden.points) == ("not run", 0)
    assert result.is_done
    assert result.seconds < 20


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"key": None}, "hw3 has no key"),
        ({"tests": "stale"}, "the limits of the test shown: the task is not"),
        ({"tests": "no limits"}, "the test shown has no limit for position: calibrate"),
        ({"tests": "no reference"}, "the test shown has no reference"),
        ({"tests": "broken"}, "the reference of the test shown fails: ZeroDivisionError"),
        ({"tests": "short"}, "limits.json has 1 numbers of the reference of shown, which has 2"),
    ],
)
def test_an_assignment_that_is_broken_scores_nothing(hw3, tmp_path, change, said):
    shown, hidden = hw3.tests
    broken = {"estimate_state": b"def estimate_state(step):\n    return 1 / 0\n"}
    tests = {
        "stale": replace(shown, stale="the task is not"),
        "no limits": replace(shown, limits={}),
        "no reference": replace(shown, reference=None),
        "broken": replace(shown, reference=replace(shown.reference, files=broken)),
        "short": replace(shown, reference_values=dict.fromkeys(LIMITS, (1.0,))),
    }
    if "tests" in change:
        change = {"tests": (tests[change["tests"]], hidden)}
    with pytest.raises(AssignmentError) as caught:
        replace(hw3, **change).grade(solution(tmp_path / "s007"))
    assert said in str(caught.value)
    assert caught.value.whose == "assignment"


def test_a_result_shows_itself(graded):
    assert "s001, Through dropouts" in str(graded)
    assert repr(graded).startswith("<SubmissionResult: s001, Through dropouts")
    assert "<table" in graded._repr_html_()
    assert "hidden" in str(graded.report)


def test_another_key_gives_other_worlds(hw3):
    other = replace(hw3, key=Key.new())
    one, two = (References(each).numbers(each.tests[1], "s001", 0) for each in (hw3, other))
    assert one != two


def test_the_doctor_says_what_is_wrong_where_points_are_lost(hw3, graded, tmp_path):
    tight = {name: Limit(full=1.0001, zero=1.5) for name in LIMITS}
    tests = tuple(replace(test, limits=tight) for test in hw3.tests)
    result = replace(hw3, tests=tests).grade(solution(tmp_path / "s002", "naive"))
    finding = result.tests[0].finding
    assert "the covariance has to grow while the robot is not seen" in finding
    assert "estimate_state.py:" in finding
    assert result.tests[1].finding == finding
    assert [test.finding for test in graded.tests] == ["", ""]


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
            head = struct.pack("<IBB3Q", 1, 2, 1, len(said), 0, 0)
            one._socket.sendall(struct.pack("<HHI", 8, 0, len(head) + len(said)) + head + said)
    """
    place = written(tmp_path / "s008", textwrap.dedent(text))
    task = graded_task(hw3, hw3.tests[0], str(place))
    said = judged(task, "robsim.doctor._finding:first_finding", 20.0).result
    assert said == "\\x1b[31m<b>all points</b>"  # escaped, and for others to escape in HTML
    assert hw3.grade(place).points == 0


def test_what_cannot_be_loaded_is_not_loaded_for_each_run(hw3, tmp_path):
    many = replace(hw3.tests[0], task=replace(hw3.tests[0].task, runs=6))
    slow = replace(hw3, tests=(many,), limits=Limits(first_call=0.5))
    result = slow.grade(written(tmp_path / "s009", "while True:\n    pass\n")).tests[0]
    assert [run.reason for run in result.failed[3:]] == [
        "not run: it could not be loaded in the runs before"
    ] * 3
    assert "took longer than 0.5 s" in result.failed[2].reason
    assert "No run came through." in result.sentence
