"""``robsim grade ASSIGNMENT SUBMISSIONS``: what is printed, what is written, the exit status."""

import csv
import json
import shutil

import pytest

from commands import command
from robsim.assignments import SubmissionResult
from robsim.gui._hosts.page import Page
from robsim.trace import Trace
from small_assignments import TESTS, assignment, drawn_quickly, solution

pytestmark = pytest.mark.long


@pytest.fixture(autouse=True)
def quickly():
    with drawn_quickly():
        yield


@pytest.fixture(scope="module")
def course(tmp_path_factory):
    """An assignment and two submissions, one right, one wrong."""
    folder = tmp_path_factory.mktemp("course")
    assignment(folder / "hw3", 'points = 7\nseeds = "class"\n' + TESTS)
    solution(folder / "subs/s001")
    (folder / "subs/s002.py").write_text("def estimate_state(step):\n    return step.k / 0\n")
    return folder


@pytest.fixture
def hw3(course, tmp_path, monkeypatch):
    shutil.copytree(course, tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_a_class_has_a_line_for_each_and_a_table(hw3):
    run = command("grade", "hw3", "subs")
    assert run.exit_code == 1, run.stderr
    assert "s001  6 of 6\n" in run.stdout
    assert "s002  0 of 6  not all of shown, hidden\n" in run.stdout
    assert "hw3: 2 submissions" in run.stdout
    assert "graded/class.html" in run.stdout
    out = hw3 / "graded"
    assert {file.name for file in out.iterdir()} == {
        *("s001", "s002", "class.html", "class.csv", "junit.xml")
    }
    again = command("grade", "hw3", "subs", "--json")
    told = [SubmissionResult.from_json(json.dumps(one)) for one in json.loads(again.stdout)]
    assert [(one.student, one.points) for one in told] == [("s001", 6), ("s002", 0)]


def test_what_cannot_be_read_and_what_was_not_asked_for_are_told(hw3):
    (hw3 / "subs/s003").mkdir()
    run = command("grade", "hw3", "subs", "--only", "shown")
    assert run.exit_code == 1, run.stderr
    assert "s001  2 of 2\n" in run.stdout
    assert "s002  0 of 2  not all of shown\n" in run.stdout
    assert "s003  0 of 6  s003 has no estimate_state.py: it is empty\n" in run.stdout
    assert "could not be read, which gives no points, as their pages say: s003" in run.stdout
    assert "some tests were not asked for: s001, s002" in run.stdout
    with (hw3 / "graded/class.csv").open(newline="") as file:
        marks = {row["student"]: row for row in csv.DictReader(file)}
    assert [marks[name]["hidden"] for name in ("s001", "s002", "s003")] == ["", "", "0"]
    assert marks["s003"]["notes"] == "s003 has no estimate_state.py: it is empty"
    page = (hw3 / "graded/s003/index.html").read_text()
    assert page.count("s003 has no estimate_state.py: it is empty") == 1
    assert "It could not be read, and nothing of it was run." in page
    assert "1 could not be read" in (hw3 / "graded/class.html").read_text()


def test_a_single_submission_is_told_whole(hw3):
    run = command("grade", "hw3", "subs/s001", "--out", "here")
    assert run.exit_code == 0, run.stderr
    assert "Through dropouts\ns001: 6 of 6 points" in run.stdout
    assert "with pictures: here/s001/index.html" in run.stdout
    assert not (hw3 / "here/class.html").exists()


def test_students_run_the_public_tests(hw3):
    (hw3 / "hw3/key").unlink()
    (hw3 / "subs/s001").rename(hw3 / "mine")
    run = command("grade", "hw3", "mine", "--public")
    assert run.exit_code == 0, run.stderr
    assert "mine: 2 of 2 points" in run.stdout
    assert "public tests only: 2 of 7 points shown" in run.stdout
    assert "hidden" not in run.stdout


def test_points_are_marked_anew_after_limits_have_changed(hw3):
    assert command("grade", "hw3", "subs").exit_code == 1
    toml = (hw3 / "hw3/assignment.toml").read_text()
    (hw3 / "hw3/assignment.toml").write_text(toml.replace("points = 2", "points = 3"))
    run = command("grade", "hw3", "--regrade")
    assert run.exit_code == 1, run.stderr
    assert "s001" in run.stdout
    assert SubmissionResult.from_json((hw3 / "graded/s001/result.json").read_text()).points == 7


def test_a_run_is_played_again_for_an_appeal(hw3):
    assert command("grade", "hw3", "subs/s001").exit_code == 0
    run = command("grade", "hw3", "subs/s001", "--play", "hidden")
    assert run.exit_code == 0, run.stderr
    worst = SubmissionResult.from_json((hw3 / "graded/s001/result.json").read_text()).tests[1].worst
    assert f"s001, hidden, run {worst}" in run.stdout
    assert "in the panel: the same command with --gui, or robsim gui" in run.stdout
    trace = Trace.load(hw3 / f"graded/s001/hidden-run{worst}.npz")
    assert len(trace) == 20
    other = command("grade", "hw3", "subs/s001", "--play", "hidden", "--run", f"{1 - worst}")
    assert f"run {1 - worst}" in other.stdout
    failing = command("grade", "hw3", "subs/s002", "--play", "shown")  # by the student's name
    assert failing.exit_code == 1
    assert "estimate_state at step 0" in failing.stderr


PARK = """\
name = "hw4"
title = "Park"

[[tests]]
name = "shown"
task = "park"
points = 1
public = true
parameters = { steps = 4, runs = 2, goal = [250.0, 400.0, -0.8] }
"""


def test_a_run_that_is_played_again_opens_in_the_panel(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name, text in {
        "hw4/assignment.toml": PARK,
        "anna/control.py": "def control(step):\n    return 0.5, 0.4\n",
    }.items():
        (tmp_path / name).parent.mkdir()
        (tmp_path / name).write_text(text)
    shown = []

    def wait(page, patience):
        page.view.driver.step().result()
        shown.append((page.view.record.trace, page.view.goals, page.view.driver.error))

    monkeypatch.setattr(Page, "wait", wait)
    monkeypatch.setattr(Page, "open", lambda page: False)
    monkeypatch.delenv("SSH_CONNECTION", raising=False)
    run = command("grade", "hw4", "anna", "--play", "shown", "--gui")
    assert run.exit_code == 0, run.stderr
    assert "run 0, as graded has no results of anna that tell the worst one" in run.stderr
    assert "draws the pictures again, with other noise" in run.stderr
    assert "no browser could be started: open this address in one" in run.stderr
    assert "the panel is at http://127.0.0.1:" in run.stdout
    ((trace, goals, error),) = shown
    kept = Trace.load(tmp_path / "graded/anna/shown-run0.npz")
    assert trace.pose_true.tolist() == kept.pose_true.tolist()
    assert (goals.tolist(), error) == ([250, 400, -0.8], None)
    alone = command("grade", "hw4", "anna", "--gui")
    assert alone.exit_code == 2
    assert "--gui shows the run to --play: give that, too" in alone.stderr


def test_gradescope_reads_what_is_written_for_it(hw3):
    run = command("grade", "hw3", "subs", "--student", "s009", "--gradescope", "results.json")
    assert run.exit_code == 1  # the folder is one submission then, which has no file of a slot
    told = json.loads((hw3 / "results.json").read_text())
    assert [test["max_score"] for test in told["tests"]] == [2, 4]
    assert command("grade", "hw3", "subs/s001", "--gradescope", "results.json").exit_code == 0
    assert json.loads((hw3 / "results.json").read_text())["score"] == 6


@pytest.mark.parametrize(
    ("arguments", "status", "said"),
    [
        ((), 2, "which assignment? robsim grade ASSIGNMENT SUBMISSIONS"),
        (("hw3",), 2, "what is to be graded? robsim grade ASSIGNMENT SUBMISSIONS"),
        (("nowhere", "subs"), 2, "assignment: nowhere is not an assignment: there is no such"),
        (("hw3", "nothing"), 2, "there is no such submission"),
        (("hw3", "subs", "--only", "show"), 2, "hw3 has no test 'show': did you mean 'shown'"),
        (("hw3", "subs", "--jobs", "0"), 2, "--jobs must be at least 1, got 0"),
        (("hw3", "subs", "--isolation", "full"), 2, "--isolation must be one of 'auto'"),
        (("hw3", "subs", "--columns", "moodel"), 2, "did you mean 'moodle'"),
        (("hw3", "subs", "--out", "subs"), 2, "--out must be apart from the submissions"),
        (("hw3", "--regrade"), 2, "there are no results to be marked anew"),
        (("hw3", "subs", "--play", "shown"), 2, "has 2: name one of them, such as subs/s001"),
        (("hw3", "subs", "--gradescope", "a.zip"), 2, "subs is no submission, but has 2: name"),
        (("hw3", "subs/s001", "--play", "shown", "--run", "7"), 2, "--run must lie within 0..1"),
    ],
)
def test_what_makes_no_sense_is_said_and_nothing_is_graded(hw3, arguments, status, said):
    run = command("grade", *arguments)
    assert (run.exit_code, run.stdout) == (status, "")
    assert said in run.stderr
    assert not (hw3 / "graded").exists()


def test_a_broken_assignment_is_the_teachers_fault(hw3):
    (hw3 / "hw3/limits.json").unlink()
    run = command("grade", "hw3", "subs")
    assert run.exit_code == 2
    assert "assignment: the test shown has no limit for position" in run.stderr
