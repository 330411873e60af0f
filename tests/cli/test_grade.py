"""``robsim grade``: the check of isolation, and the grades of a class."""

import csv
import dataclasses
import json
import re
import shlex
import shutil
import zipfile

import pytest

from commands import command
from html_outline import Outline
from robsim.teach import GraderError, IsolationError, SubmissionResult, check_isolation
from robsim.trace import Trace
from small_assignments import TESTS, assignment, drawn_quickly, solution

pytestmark = pytest.mark.long


# --- the check of isolation


CHECK = ("grade", "--check-isolation")
WHERE = "robsim.teach.isolation.check.check_isolation"


@pytest.fixture(scope="module")
def report():
    return check_isolation()


def test_what_holds_is_printed_and_a_level_that_asks_for_little_can_be_had(report):
    run = command(*CHECK)
    assert run.exit_code == 0, run.stderr
    assert "isolation: process" in run.stdout
    told = json.loads(command(*CHECK, "--json").stdout)
    assert told["attempts"] == len(report.attempts)
    run = command(*CHECK, "--isolation", "none")
    assert run.exit_code == 0, run.stderr
    assert "open: " in run.stdout.splitlines()[0]


def test_the_status_says_whether_strict_can_be_had(report, monkeypatch):
    assert command(*CHECK, "--isolation", "strict").exit_code == (0 if report.strict else 3)
    through = {**report.attempts, "connect": (False, "connected")}
    leaky = dataclasses.replace(report, attempts=through)
    monkeypatch.setattr(WHERE, lambda *, isolation: leaky)
    assert command(*CHECK, "--isolation", "strict").exit_code == 3
    assert command(*CHECK).exit_code == 0

    def without_files(*, isolation):
        if isolation == "strict":
            raise IsolationError("isolation='strict' needs files")
        return dataclasses.replace(report, closed={**report.closed, "files": False})

    monkeypatch.setattr(WHERE, without_files)
    run = command(*CHECK, "--isolation", "strict")
    assert run.exit_code == 3
    assert "open: files" in run.stdout
    assert "needs files" in run.stderr


def test_a_machine_that_starts_no_process_is_no_isolation(monkeypatch):
    def nothing(*, isolation):
        raise GraderError("no worker can be started")

    monkeypatch.setattr(WHERE, nothing)
    run = command(*CHECK)
    assert (run.exit_code, run.stdout) == (2, "")
    assert "no worker can be started" in run.stderr


def test_what_cannot_be_checked_is_refused():
    for arguments in (("grade",), (*CHECK, "--isolation", "full")):
        assert command(*arguments).exit_code == 2


# --- a class


@pytest.fixture(autouse=True, scope="module")
def quickly():
    with drawn_quickly(), pytest.MonkeyPatch.context() as patch:
        patch.setattr("robsim.campaigns.engines.engine.processors", lambda: 1)
        yield


@pytest.fixture(scope="module")
def course(tmp_path_factory, quickly):
    """An assignment and two submissions, one right, one wrong, graded; and what was printed."""
    folder = tmp_path_factory.mktemp("course")
    assignment(folder / "hw3", 'points = 7\nseeds = "class"\n' + TESTS)
    solution(folder / "subs/s001")
    (folder / "subs/s002.py").write_text("def estimate_state(step):\n    return step.k / 0\n")
    return folder, command("grade", "hw3", "subs", cwd=folder)


@pytest.fixture
def hw3(course, tmp_path, monkeypatch):
    """A copy of the course; what was graded is not graded again."""
    shutil.copytree(course[0], tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def result_of(folder, student):
    return SubmissionResult.from_json((folder / f"graded/{student}/result.json").read_text())


def test_a_class_has_a_line_for_each_and_a_table(course, hw3):
    run = course[1]
    assert run.exit_code == 1, run.stderr
    assert "s001  6 of 6\n" in run.stdout
    assert "s002  0 of 6  loses points in shown, hidden\n" in run.stdout
    assert {file.name for file in (hw3 / "graded").iterdir()} == {
        *("s001", "s002", "class.html", "class.csv", "by_hand.csv", "similar.json")
    }
    again = command("grade", "hw3", "subs", "--json")
    told = [SubmissionResult.from_json(json.dumps(one)) for one in json.loads(again.stdout)]
    assert [(one.student, one.points) for one in told] == [("s001", 6), ("s002", 0)]


def test_what_cannot_be_read_and_what_was_not_asked_for_are_told(hw3):
    (hw3 / "subs/s003").mkdir()
    shutil.rmtree(hw3 / "graded")
    run = command("grade", "hw3", "subs", "--only", "shown")
    assert run.exit_code == 1, run.stderr
    for line in ("s001  2 of 2\n", "s002  0 of 2  loses points in shown\n", "s003  0 of 6  "):
        assert line in run.stdout
    with (hw3 / "graded/class.csv").open(newline="") as file:
        marks = {row["student"]: row for row in csv.DictReader(file)}
    assert [marks[name]["hidden"] for name in ("s001", "s002", "s003")] == ["", "", "0"]
    assert "estimate_state.py" in marks["s003"]["notes"]
    assert "estimate_state.py" in (hw3 / "graded/s003/index.html").read_text()


def test_a_single_submission_is_told_whole_and_for_gradescope(hw3):
    run = command("grade", "hw3", "subs/s001", "--gradescope", "results.json")
    assert run.exit_code == 0, run.stderr
    assert "s001: 6 of 6 points" in run.stdout
    assert json.loads((hw3 / "results.json").read_text())["score"] == 6
    # With a student's name the folder is one submission, which has no file of a slot.
    run = command("grade", "hw3", "subs", "--student", "s009", "--gradescope", "results.json")
    assert run.exit_code == 1
    told = json.loads((hw3 / "results.json").read_text())
    assert [test["max_score"] for test in told["tests"]] == [2, 4]


def test_students_run_the_public_tests(hw3):
    (hw3 / "hw3/key").unlink()
    (hw3 / "subs/s001").rename(hw3 / "mine")
    run = command("grade", "hw3", "mine", "--public")
    assert run.exit_code == 0, run.stderr
    assert "mine: 2 of 2 points" in run.stdout
    assert "2 of 7 points" in run.stdout
    assert "hidden" not in run.stdout


def test_points_are_marked_anew_after_limits_have_changed(hw3):
    toml = (hw3 / "hw3/assignment.toml").read_text()
    (hw3 / "hw3/assignment.toml").write_text(toml.replace("points = 2", "points = 3"))
    run = command("grade", "hw3", "--regrade")
    assert run.exit_code == 1, run.stderr
    assert result_of(hw3, "s001").points == 7
    assert "s001: 6 -> 7\n" in run.stdout
    (hw3 / "graded/by_hand.csv").write_text("student,points\ns002,4.5\n")
    run = command("grade", "hw3", "--regrade", "--feedback", "feedback.zip")
    assert "s002: 0 -> 4.5\n" in run.stdout
    assert "s001: " not in run.stdout
    with zipfile.ZipFile("feedback.zip") as archive:
        assert "4.5 of 7" in archive.read("s002/result.txt").decode()
    assert "no points have changed" in command("grade", "hw3", "--regrade").stdout


def test_a_page_for_the_teacher_says_how_to_do_a_run_again(hw3, tmp_path):
    shutil.move(hw3 / "subs", hw3 / "of us")
    shutil.move(hw3 / "graded", hw3 / "marks")
    command("grade", "hw3", "of us", "--out", "marks", "--teacher-pages")
    assert "s001/teacher.html" in (hw3 / "marks/class.html").read_text()
    page = Outline((hw3 / "marks/s001/teacher.html").read_text())
    (line,) = re.findall("robsim (grade (?:(?!robsim).)* --play hidden --run [01])", page.text)
    run = command(*shlex.split(line))
    assert run.exit_code == 0, run.stderr
    assert list((hw3 / "marks/s001").glob("hidden-run*.npz"))
    assert "of us" not in (hw3 / "marks/s001/index.html").read_text()


def test_a_run_is_played_again_for_an_appeal(hw3):
    run = command("grade", "hw3", "subs/s001", "--play", "hidden")
    assert run.exit_code == 0, run.stderr
    worst = result_of(hw3, "s001").tests[1].worst
    assert f"s001, hidden, run {worst}" in run.stdout
    assert len(Trace.load(hw3 / f"graded/s001/hidden-run{worst}.npz")) == 20
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

    monkeypatch.setattr("robsim.gui.hosts.page.Page.wait", wait)
    monkeypatch.setattr("robsim.gui.hosts.page.Page.open", lambda page: False)
    monkeypatch.delenv("SSH_CONNECTION", raising=False)
    run = command("grade", "hw4", "anna", "--play", "shown", "--gui")
    assert run.exit_code == 0, run.stderr
    ((trace, goals, error),) = shown
    kept = Trace.load(tmp_path / "graded/anna/shown-run0.npz")
    assert trace.pose_true.tolist() == kept.pose_true.tolist()
    assert (goals.tolist(), error) == ([250, 400, -0.8], None)
    alone = command("grade", "hw4", "anna", "--gui")
    assert alone.exit_code == 2
    assert "--play" in alone.stderr


def test_what_makes_no_sense_is_said_and_nothing_is_graded(hw3):
    shutil.rmtree(hw3 / "graded")
    for named, arguments in {
        "SUBMISSIONS": ("hw3",),
        "nowhere": ("nowhere", "subs"),
        "submission": ("hw3", "nothing"),
        "'show'": ("hw3", "subs", "--only", "show"),
        "--jobs": ("hw3", "subs", "--jobs", "0"),
        "isolation": ("hw3", "subs", "--isolation", "full"),
        "moodle": ("hw3", "subs", "--columns", "moodel"),
        "out": ("hw3", "subs", "--out", "subs"),
        "hw3 is a folder": ("hw3", "subs", "--feedback", "hw3"),
        "results": ("hw3", "--regrade"),
        "of 2 submissions": ("hw3", "subs", "--play", "shown"),
        "run must": ("hw3", "subs/s001", "--play", "shown", "--run", "7"),
    }.items():
        run = command("grade", *arguments)
        assert (run.exit_code, run.stdout) == (2, ""), arguments
        assert named in run.stderr, arguments
    assert not (hw3 / "graded").exists()


def test_jobs_are_the_cores_by_default(hw3, monkeypatch):
    asked = []
    monkeypatch.setattr("robsim.campaigns.engines.engine.processors", lambda: 3)
    monkeypatch.setattr(
        "robsim.cli.marks.grade_class", lambda *_, executor, **__: asked.append(executor) or 1 / 0
    )
    for more in ((), ("--jobs", "2")):
        with pytest.raises(ZeroDivisionError):
            command("grade", "hw3", "subs", *more)
    assert asked == [3, 2]


def test_a_broken_assignment_is_the_teachers_fault(hw3):
    (hw3 / "hw3/limits.json").unlink()
    run = command("grade", "hw3", "subs")
    assert run.exit_code == 2
    assert "assignment: " in run.stderr
