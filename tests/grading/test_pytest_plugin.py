"""The plugin of pytest: off unless asked for, says whose fault it is, runs nothing of a student."""

import re
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from xml.etree import ElementTree

import pytest

import robsim
from graded import PATIENT, folder_of
from robsim.teach import (
    AssignmentError,
    GraderError,
    IsolationError,
    Key,
    Submission,
    SubmissionError,
)
from robsim.teach.grading import pytest_plugin as _pytest_plugin

TESTS = """
import pytest
import robsim

LIMITS = robsim.teach.WorkerLimits(call=300.0, first_call=300.0, run=600.0)
pytestmark = pytest.mark.robsim_submission(slots="control", limits=LIMITS)
SCENARIO = robsim.Scenario(resolution=(200, 200), measure=True)


def drive(submission, **callbacks):
    return submission.run(SCENARIO, steps=6, seed=1, **callbacks)


def test_begins(submission):
    assert submission.run(SCENARIO, steps=3, seed=1).seen.all()


def test_ends(submission):
    assert drive(submission).seen.all()


def test_with_a_callback_of_the_teachers(submission):
    drive(submission, estimate_state=lambda step: 1 / 0)


@pytest.mark.robsim_submission(slots="measure")
def test_measures(submission):
    drive(submission)


@pytest.mark.robsim_submission(slot="control")
def test_wrong_option(submission):
    drive(submission)


@pytest.mark.robsim_submission(slots="contol")
def test_wrong_slot(submission):
    drive(submission)


def test_asks_too_much(submission):
    assert len(submission.run(SCENARIO, steps=2)) == 3  # it prints "begins"
"""
FAILS = """
    def control(step):
        if step.k == 0:
            print("begins")
        if step.k == 3:
            print("here \\x1b[31m \\x00")
            raise ValueError("\\x1b[31m \\ufffe")
        return 0.1, 0.2
    """
OUTCOMES = {
    "test_begins": "passed",
    "test_ends": "submission: control at step 3, control.py, line 7: ValueError: ",
    "test_with_a_callback_of_the_teachers": "assignment: a callback of the assignment has failed: "
    "estimate_state at step 0, grade.py, line 23: ZeroDivisionError",
    "test_measures": "submission: mine has no measure.py",
    "test_wrong_option": "assignment: robsim_submission has no option 'slot'",
    "test_wrong_slot": "assignment: robsim_submission: slots",
    "test_asks_too_much": "AssertionError: assert 2 == 3",
}


def graded(folder, *arguments):
    """Run pytest in a folder, in a process of its own."""
    command = [sys.executable, "-W", "error", "-m", "pytest", "-p", "no:cacheprovider"]
    command += ["-p", "pytest_robsim", *arguments]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True)


@pytest.fixture
def class_room(tmp_path):
    """A folder with the tests, and a submission."""
    room = tmp_path / "room"
    room.mkdir()
    folder_of(room / "mine", control=FAILS)
    (room / "grade.py").write_text(TESTS)
    return room


def outcomes(folder):
    """What is told of each test in JUnit's XML."""
    cases = ElementTree.parse(folder / "results.xml").iter("testcase")
    return {case.get("name"): next((c.get("message") for c in case), "passed") for case in cases}


def assert_as_told(run, folder):
    told = outcomes(folder)
    assert told.keys() == OUTCOMES.keys()
    for name, message in OUTCOMES.items():
        assert message in told[name], told[name]
    assert run.returncode == 1
    assert re.search("3 failed, 1 passed, 3 errors", run.stdout), run.stdout
    for name in ("test_ends", "test_measures"):
        assert f"FAILED grade.py::{name} - submission: " in run.stdout
    for name in ("test_with_a_callback_of_the_teachers", "test_wrong_slot", "test_wrong_option"):
        assert f"ERROR grade.py::{name} - assignment: " in run.stdout
    assert "\x1b" not in run.stdout
    assert "here \\x1b[31m \\x00" in run.stdout  # what it has printed
    assert run.stdout.count("printed by the submission") == 2  # test_ends, test_asks_too_much
    assert "1 / 0" in run.stdout  # the teacher's line
    for internal in ("_submission.py", "_graded_run.py", "_pytest/", "pluggy/"):
        assert internal not in run.stdout


@pytest.mark.long
@pytest.mark.parametrize("processes", [(), pytest.param(("-n", "2"), marks=pytest.mark.slow)])
def test_a_failure_says_whose_it_is(class_room, processes):
    options = ("--robsim-submission=mine", "--junitxml=results.xml", *processes)
    run = graded(class_room, *options, "grade.py")
    assert_as_told(run, class_room)
    if not processes:
        assert re.search(r"^submission: .*mine$", run.stdout, re.MULTILINE)
        assert re.search(r"^isolation: process", run.stdout, re.MULTILINE)


@pytest.mark.long
def test_it_is_off_unless_asked_for(class_room):
    (class_room / "test_others.py").write_text(
        "import sys, pytest\n@pytest.fixture\ndef submission(): return 'our own'\n"
        "def test_own_fixture(submission):\n    assert submission == 'our own'\n"
        "    assert 'robsim' not in sys.modules\n"
    )
    run = graded(class_room, "test_others.py")
    assert "1 passed" in run.stdout, run.stdout
    run = graded(class_room, "grade.py", "-k", "test_begins")
    assert "no submission; run python -m pytest --robsim-submission=PATH" in run.stdout
    assert "1 error" in run.stdout


@pytest.mark.long
def test_robsim_is_not_compiled_anew(tmp_path):
    """Pytest does so, for asserts, with all of a distribution that has a plugin."""
    (tmp_path / "test_it.py").write_text(
        "import robsim\ndef test_it():\n    assert '@pytest_ar' not in vars(robsim)\n"
        "    assert '@pytest_ar' in globals()\n"
    )
    (tmp_path / "marked.py").write_text("import pytest\npytest.register_assert_rewrite('robsim')\n")
    run = graded(tmp_path, "-p", "marked", "test_it.py")
    assert "1 passed" in run.stdout, run.stdout


HARMS = "open('harm', 'w')\ndef test_passes(): pass\n"


@pytest.mark.long
def test_nothing_of_a_submission_is_run_by_pytest(class_room):
    """Neither what pytest collects, nor what a pytest.ini names."""
    mine = folder_of(class_room / "of_mine", control="def control(step): return 0, 0")
    for name in ("conftest.py", "test_mine.py", "evil.py"):
        (mine / name).write_text(HARMS)
    (mine / "pytest.ini").write_text("[pytest]\naddopts = -p of_mine.evil\n")
    words = ("--robsim-submission=of_mine", "-k", "test_begins")
    run = graded(class_room, *words)
    assert run.returncode == 4, run.stdout
    assert "1 passed" in graded(class_room, *words, "grade.py").stdout
    # A pytest.ini whose folders are not those of the class room.
    (class_room.parent / "pytest.ini").write_text("[pytest]\ntestpaths = tests\n")
    assert graded(class_room, *words).returncode == 4
    assert not (class_room / "harm").exists()


def test_files_of_tests_and_a_submission_are_apart(class_room, monkeypatch):
    monkeypatch.chdir(class_room)
    for place in (".", "mine", "mine/control.py", "mine/control.py::test"):
        with pytest.raises(pytest.UsageError, match="overlap"):
            grading(class_room, tests=place)
    grading(class_room, tests="grade.py::test_begins")
    monkeypatch.chdir(class_room / "mine")
    with pytest.raises(pytest.UsageError, match="run pytest in another folder"):
        grading(class_room, tests="../grade.py")


def grading(folder, arguments=(), tests=None, **options):
    """The plugin for a command line."""
    values = dict.fromkeys(("slots", "key")) | {"isolation": "auto"}
    values |= {"submission": str(folder / "mine")} | options
    config = SimpleNamespace(
        known_args_namespace=SimpleNamespace(
            file_or_dir=[tests or str(folder / "grade.py")],
            **{f"robsim_{name}": value for name, value in values.items()},
        ),
        getini=lambda name: [],
        invocation_params=SimpleNamespace(args=arguments),
    )
    return _pytest_plugin.Grading(config)


def item(*markers):
    """A test with these options in its markers, the nearest first."""
    return SimpleNamespace(
        path=Path("tests/grade.py"),
        nodeid="tests/grade.py::test_it",
        iter_markers=lambda name: [SimpleNamespace(args=(), kwargs=given) for given in markers],
    )


def test_the_nearest_marker_says_what_a_submission_may_do(class_room):
    plugin = grading(class_room, slots="measure, control")
    assert plugin.submission_for(item()).slots == ("control",)
    with pytest.raises(SubmissionError, match=re.escape("measure.py")):
        plugin.submission_for(item({"slots": "measure"}, {"slots": "control"}))
    with pytest.raises(AssignmentError, match="slots"):
        grading(class_room).submission_for(item())
    options = {"imports": ["robsim"], "masked": ["robsim.locate"], "frames": True}
    task = plugin.submission_for(item(options, {"slots": "control", "frames": False}))._task
    assert (task.rules.slots, task.rules.imports) == (("control",), ("robsim",))
    assert (task.rules.masked, task.frames) == (("robsim.locate",), True)


def test_a_key_that_others_can_read_is_refused(class_room):
    Key(bytes(range(32))).save(class_room / "key")
    grading(class_room, key=str(class_room / "key"))
    (class_room / "key").chmod(0o644)
    with pytest.raises(pytest.UsageError, match="--robsim-key: other users can read"):
        grading(class_room, key=str(class_room / "key"))


def test_a_submission_that_is_not_named_as_it_must_be_is_refused(class_room):
    """Nor does one take the place of a module."""
    with pytest.raises(pytest.UsageError, match="is missing"):
        grading(class_room, submission=str(class_room / "yours"))
    # After a blank pytest would look for its pytest.ini there, before any plugin is asked.
    with pytest.raises(pytest.UsageError, match="with '='"):
        grading(class_room, arguments=("--robsim-submission", "mine", "grade.py"))
    (class_room / "handed_in").mkdir()
    for name in ("scipy.py", "numpy"):
        for folder in (class_room, class_room / "handed_in"):
            (folder / name).touch()
        with pytest.raises(pytest.UsageError, match=f"{name} has the name of a module"):
            grading(class_room, submission=str(class_room / name))
        grading(class_room, submission=str(class_room / "handed_in" / name))


def test_without_isolation_nothing_is_run(class_room, monkeypatch):
    for error, status in ((IsolationError, 3), (GraderError, 2)):

        def check_isolation(isolation, error=error):
            raise error(f"{isolation}: no")

        monkeypatch.setattr(_pytest_plugin, "check_isolation", check_isolation)
        plugin = grading(class_room, isolation="strict")
        with pytest.raises(pytest.exit.Exception, match="strict: no") as ended:
            plugin.pytest_sessionstart(SimpleNamespace(config=SimpleNamespace()))
        assert ended.value.returncode == status


FUNCTIONS = """
import pytest, robsim

LIMITS = robsim.teach.WorkerLimits(call=300.0, first_call=300.0, run=600.0)
pytestmark = pytest.mark.robsim_submission(slots="control", functions="double", limits=LIMITS)
SCENARIO = robsim.Scenario(resolution=(100, 100), start="random")

@pytest.mark.parametrize("number", [1, 2])
def test_double(submission, number):
    assert submission.call("double", [number]) == [2 * number]
    trace = submission.run(SCENARIO, steps=1)
    with open("starts", "a") as file:
        print(trace.pose_true[0].tolist(), file=file)

@pytest.mark.robsim_submission(slots=(), functions="double")
def test_function_alone(submission):
    assert submission.functions == ("double",)
"""


@pytest.mark.long
def test_functions_are_called_and_each_test_has_worlds_of_its_own(tmp_path):
    code = {"control": "def control(step): return 0, 0", "double": "def double(x): return 2 * x"}
    mine = folder_of(tmp_path / "mine", **code)
    (tmp_path / "grade.py").write_text(FUNCTIONS)
    key = Key(bytes(range(32)))
    key.save(tmp_path / "key")
    run = graded(tmp_path, "--robsim-submission=mine", "--robsim-key=key", "grade.py")
    assert run.returncode == 0, run.stdout
    started = (tmp_path / "starts").read_text().splitlines()
    assert len({*started}) == 2
    scenario = robsim.Scenario(resolution=(100, 100), start="random")
    for number in (1, 2):
        test = f"grade::test_double[{number}]"
        again = Submission(mine, slots="control", key=key, test=test, limits=PATIENT)
        assert str(again.run(scenario, steps=1).pose_true[0].tolist()) == started[number - 1]


def test_only_lines_of_tests_are_shown():
    assert all(folder.is_dir() for folder in _pytest_plugin._NOT_THEIRS)
    with pytest.raises(TypeError) as error:
        robsim.Trace.load(3)
    assert len(error.traceback) > 1
    assert [str(line.path) for line in _pytest_plugin._lines_of_tests(error)] == [__file__]
