"""The buttons, what is told of the run and its errors, and the big Stop."""

import ctypes
import math
import subprocess
import sys
import textwrap
import threading

import numpy as np
import pytest

import robsim
from browsers import FakeBrowser, panel_of
from python_devices import Sender, SteppedCamera
from small_runs import IMAGE, SOON, done, experiment, frames, simulation
from waiting import wait_for

pytestmark = pytest.mark.threads


# State


def test_a_panel_by_its_messages():
    """From the setup to the end: run, a control, frames, stop."""
    with panel_of(simulation(measure=True), speed=2.0) as (view, browser):
        setup, _ = browser.take("setup")
        assert (setup["motors"], setup["live"]) == (False, False)
        state, _ = browser.take("state")
        known = {
            **{"state": "paused", "k": -1, "steps": 0, "t": None, "speed": 2.0, "animate": False},
            **{"stage": "world", "error": None, "camera": None, "stopped": False},
        }
        assert known.items() <= state.items()
        browser.press("step")
        browser.press("step")
        state, _ = browser.take("state", steps=2)
        assert (state["k"], state["t"]) == (1, pytest.approx(view.record.time_of(1)))
        browser.say("set", name="speed", value=0)
        browser.press("start")
        assert browser.take("state", state="running")[0]["speed"] == 0
        shown, (picture,) = browser.take("frame")
        assert picture[:2] == b"\xff\xd8"
        later, _ = browser.take("frame")
        assert later["k"] > shown["k"]
        browser.press("stop")  # of a simulation it is a pause
        steps = browser.take("state", state="paused", stopped=False)[0]["steps"]
        assert view.runner.n_steps == steps > 2
        browser.press("reset")
        browser.take("state", state="paused", steps=0)
        browser.press("turbo")
        assert "turbo" in browser.take("note", level="error")[0]["text"]
        assert view.close(SOON)
        browser.take("state", state="closed")


def test_stages_are_told_as_they_come(clock):
    with panel_of(simulation(measure=True)) as (view, browser):
        for stage in ("measure", "control", "world"):
            browser.press("step_stage")
            browser.take("stages", stage=stage)
        browser.say("animate", on=True)
        browser.take("state", animate=True)
        browser.press("start")
        browser.take("state", state="running")
        for stage in ("measure", "control", "world", "measure"):
            clock.advance(view.driver, 0.3)
            assert browser.take("stages")[0]["stage"] == stage
        browser.say("animate", on=False)
        browser.take("state", animate=False, state="running")


def test_reset_keeps_the_steps_before_it(monkeypatch, tmp_path):
    with panel_of(simulation()) as (view, browser):
        browser.press("reset")  # nothing to keep
        browser.press("step")
        browser.take("state", steps=1)
        trace = view.record.trace
        browser.press("reset")
        said = browser.take("note", level="info")[0]["text"]
        file = said.removeprefix("The previous run is in ")
        np.testing.assert_array_equal(robsim.Trace.load(file).pose_true, trace.pose_true)
        monkeypatch.setenv("ROBSIM_DATA", str(tmp_path))
        (tmp_path / "runs").touch()
        browser.press("step")
        browser.take("state", steps=1)
        browser.press("reset")
        assert "could not be saved" in browser.take("note", level="error")[0]["text"]


def test_the_end_of_the_frames_is_told_kindly():
    cases = [(frames(2), "start", "Reset"), (iter(frames(2)), "reset", "once")]
    for source, pressed, said in cases:
        with panel_of(experiment(source), speed=math.inf) as (_, browser):
            browser.press("start")
            browser.take("state", state="ended", steps=2)
            browser.press(pressed)
            assert said in browser.take("note")[0]["text"]
            if pressed == "start":
                browser.press("reset")
                browser.take("state", state="paused", steps=0)


# Errors

CONTROL = """\
def control(step):
    return wanted(step), 0


def wanted(step):
    return 1 / (2 - step.k)  # the line
"""


def test_an_error_of_a_callback_is_told_with_its_line(tmp_path):
    (tmp_path / "control.py").write_text(CONTROL)
    sim = robsim.Simulation.from_folder(tmp_path, area=(300, 300), resolution=(75, 75))
    with panel_of(sim, speed=math.inf) as (_, browser):
        browser.press("start")
        error = browser.take("state", state="failed")[0]["error"]
        file = str(tmp_path / "control.py")
        assert {**error, "traceback": ""} == {
            **{"slot": "control", "k": 2, "file": file, "line": 6, "traceback": ""},
            "text": "ZeroDivisionError: division by zero",
            "code": "return 1 / (2 - step.k)  # the line",
        }
        assert error["traceback"].splitlines()[0] == f'  File "{file}", line 2, in control'
        assert error["traceback"].splitlines()[-1] == "ZeroDivisionError: division by zero"
        assert "robsim/" not in error["traceback"].replace(str(tmp_path), "")
        # A file that cannot be read is the same kind of trouble; mended, it goes on.
        (tmp_path / "control.py").write_text("def control(step)\n    return 0, 0\n")
        browser.press("start")
        while "SyntaxError" not in error["text"]:
            error = browser.take("state", state="failed")[0]["error"]
        assert (error["file"], error["line"]) == (file, 1)
        assert error["code"] == "def control(step)"
        assert error["text"].startswith("SyntaxError: ")  # not the line once more
        (tmp_path / "control.py").write_text("def control(step):\n    return 0, 0\n")
        browser.press("start")
        browser.take("state", state="running", error=None)


def test_a_result_that_cannot_be_used_and_one_of_the_set_up():
    def error_of(**options):
        with panel_of(simulation(**options)) as (_, browser):
            browser.press("step")
            return browser.take("state", state="failed")[0]["error"]

    error = error_of(control=lambda step: "fast")
    assert (error["slot"], error["k"], error["file"]) == ("control", 0, __file__)
    (text,) = error["text"].splitlines()  # slot, step, file and line stand beside it
    assert text.startswith("CallbackTypeError: ")
    assert "'fast'" in text
    error = error_of(estimate_parameters=True, measure=False, identify_from="measurement")
    assert (error["slot"], error["k"], error["code"]) == (None, None, None)
    assert error["text"].startswith("ValueError: identify_from")


class Spiteful(Exception):
    def __str__(self):
        raise RuntimeError("no words")


class Noted(Exception):
    __notes__ = 5


class Nameless(type):
    @property
    def __name__(cls):
        raise RuntimeError("no name")


def broken_syntax():
    error = SyntaxError("x")
    error.filename, error.lineno, error.text = 5, "a", 7
    return error


HOSTILE = [
    *(Spiteful(), Noted("why"), broken_syntax(), Nameless("Kind", (Exception,), {})("why")),
    *(ValueError("x" * 10**6), ValueError("\x1b[31m\u202e\ud800</script>\0")),
    *(KeyboardInterrupt(), SystemExit(1), EOFError()),
]


def test_an_error_of_any_kind_stands_in_the_panel(capsys):
    newest = []

    def control(step):
        if newest[-1] is None:
            control(step)
        raise newest[-1]

    with panel_of(simulation(control=control)) as (_, browser):
        for error in [*HOSTILE, None]:
            newest.append(error)
            browser.press("reset")
            browser.take("state", state="paused")
            browser.press("step")
            told = browser.take("state", state="failed")[0]["error"]
            assert (told["slot"], told["k"]) == ("control", 0)
            assert 0 < len(told["text"]) < 20_000
            assert error is not None or len(told["traceback"]) < 5000  # not each call
            kind = "Kind" if isinstance(type(error), Nameless) else type(error).__name__
            kind = "RecursionError" if error is None else kind
            assert kind == "Kind" or told["text"].startswith(kind)  # without a module before it
            browser.say("hello", width=300)  # it is told everything again
            browser.take("setup")
            slots = browser.take("callbacks")[0]["slots"]
            short = next(one["error"] for one in slots if one["slot"] == "control")
            assert 0 < len(short["text"]) <= 200
            for text in (told["text"], told["traceback"], short["text"]):
                assert text.replace("\n", "").isprintable()
            assert not browser.all_of("note")
    assert "robsim view" not in capsys.readouterr().err


# Stop


@pytest.fixture
def robot():
    return Sender()


def driven(source, send, **options):
    """An experiment whose robot is told to move."""
    given = {"send": send, "control": lambda step: (1, 2)}
    return experiment(source, **(given | options))


usleep = ctypes.PyDLL(None).usleep  # with the interpreter's lock


class Hanging:
    """A controller that hangs at step 2, in one way or another, until it may go on."""

    def __init__(self):
        self.is_there, self.may_go_on = threading.Event(), threading.Event()

    def __call__(self, step):
        if step.k == 2 and not self.may_go_on.is_set():
            self.is_there.set()
            self.hang(self.may_go_on)
        return 1.0, 2.0


@pytest.fixture
def hanging():
    control = Hanging()
    yield control
    control.may_go_on.set()


def sleeps(may_go_on):
    may_go_on.wait(SOON)


def loops(may_go_on):
    while not may_go_on.is_set():
        pass


@pytest.mark.long
@pytest.mark.parametrize("hang", [sleeps, loops])
def test_stop_stops_the_robot_whatever_a_callback_does(robot, hanging, hang):
    control, hanging.hang = hanging, hang
    sim = driven(frames(20), robot, control=control)
    with panel_of(sim, speed=math.inf) as (view, browser):
        assert browser.take("setup")[0]["motors"]
        browser.press("start")
        assert control.is_there.wait(SOON)
        for _ in range(3):
            view.driver.call(lambda: None)  # what waits does not hold it up
        for button in ("step", "start", "step_stage", "start"):
            browser.press(button)
        browser.press("stop")
        wait_for(lambda: robot.stands)
        assert not control.may_go_on.is_set()
        inputs = len(robot.sent)
        control.may_go_on.set()
        browser.take("state", state="paused", stopped=True, error=None)
        for _ in range(3):  # what was asked for before Stop moves nothing after
            done(view.driver.call(lambda: None))
        assert (view.driver.state, view.runner.n_steps) == ("paused", 2)
        assert robot.stands
        assert not any(map(any, robot.sent[inputs:]))  # its input is not sent
        browser.press("start")
        browser.take("state", state="ended", stopped=False)
        assert view.runner.n_steps == 20


@pytest.mark.long
def test_stop_after_a_callback_that_keeps_the_interpreter(robot, hanging):
    hanging.hang = lambda may_go_on: usleep(300_000)
    sim = driven(frames(10**6), robot, control=hanging)
    with panel_of(sim, speed=math.inf) as (_, browser):
        browser.press("start")
        assert hanging.is_there.wait(SOON)
        browser.press("stop")
        browser.take("state", state="paused", stopped=True, error=None)
        wait_for(lambda: robot.stands)  # what was sent may be under way


@pytest.mark.long
def test_stop_between_two_steps(robot):
    sim = driven(frames(20), robot)
    with panel_of(sim, speed=1e-5) as (_, browser):
        browser.press("start")
        wait_for(lambda: len(robot.sent) == 1 and not robot.stands)
        browser.press("stop")
        browser.take("state", state="paused", stopped=True)
        wait_for(lambda: robot.stands)
        browser.press("step")
        browser.take("state", steps=2, stopped=False)
        wait_for(lambda: not robot.stands)
        sim.stop_robot()  # as in a cell of a notebook
        wait_for(lambda: robot.stands)


def test_stop_in_the_midst_of_many_steps_is_never_lost(robot):
    """Wherever it comes between the looks of the run: it moves no more."""
    sim = driven(frames(10**6), robot)
    with panel_of(sim, speed=math.inf) as (view, browser):
        for _ in range(10):
            before = view.runner.n_steps
            browser.press("start")
            wait_for(lambda before=before: view.runner.n_steps > before)
            done(view.driver.stop_robot())
            assert view.driver.state == "paused"
            assert robot.stands
        browser.press("start")
        wait_for(lambda: view.driver.state == "running" and not robot.stands)
        sim.stop_robot()  # from elsewhere
        wait_for(lambda: view.driver.state == "paused")
        assert robot.stands


def test_a_robot_that_cannot_be_stopped_is_told(robot, monkeypatch):
    monkeypatch.setattr("robsim.gui.panels.run.transport._PATIENCE", SOON)
    sim = driven(frames(20), robot)
    with panel_of(sim) as (_, browser):
        browser.press("step")
        browser.take("state", steps=1)
        wait_for(lambda: not sim.is_running)
        robot.error = OSError("the cable is loose")
        browser.press("stop")
        assert "the cable is loose" in browser.take("note")[0]["text"]
        browser.say("hello", width=300)  # the state may have come before the note
        error = browser.take("state", state="failed")[0]["error"]
        assert "the cable is loose" in error["text"]
        robot.error = None
        browser.press("stop")
        wait_for(lambda: robot.stands)


@pytest.mark.long
def test_the_panel_answers_while_what_stops_the_robot_hangs(monkeypatch):
    monkeypatch.setattr("robsim.gui.panels.run.transport._PATIENCE", 0.01)
    is_free = threading.Event()

    def send(u):
        if not np.any(u):
            is_free.wait(SOON)

    sim = driven(frames(20), send)
    with panel_of(sim) as (_, browser):
        browser.press("step")
        browser.take("state", steps=1)
        wait_for(lambda: not sim.is_running)
        for _ in range(20):
            browser.press("stop")
        assert "have not answered" in browser.take("note")[0]["text"]
        browser.say("inspect", k=None, path=[])
        browser.take("tree")
        names = [thread.name for thread in threading.enumerate()]
        assert 0 < names.count("robsim stop") <= 10
        is_free.set()
        browser.take("state", state="paused", stopped=True)


def test_a_robot_that_nobody_looks_at_is_stopped_at_once(robot, patience):
    patience(1000.0)
    source = SteppedCamera([IMAGE] * 20)
    source.permits.release()
    with (
        robsim.Camera(source, open_timeout=SOON) as camera,
        panel_of(driven(camera, robot)) as (view, browser),
    ):
        browser.press("start")
        wait_for(lambda: robot.sent)
        browser.say("bye")
        wait_for(lambda: view.driver.state == "paused")
        assert robot.stands
        browser.say("hello", width=300)
        browser.take("state", state="paused", stopped=True)


# The run and the panel


@pytest.mark.long
@pytest.mark.parametrize("room", [0, 10**9])
def test_the_loop_does_not_wait_for_who_looks(room):
    """A browser that takes nothing holds the view up, and no step."""
    is_free = threading.Event()

    class Blocked(FakeBrowser):
        def transmit(self, head, buffers):
            is_free.wait(SOON)

    with panel_of(simulation(measure=True), speed=math.inf) as (view, _):
        Blocked(view, name="blocked", room=room).say("columns", names=["pose_true"])
        view.driver.start()
        wait_for(lambda: view.runner.n_steps > 500)
        assert view.driver.state == "running"
        is_free.set()


# The end of Python

END = """
import threading, time
import robsim
inside = threading.Event()
def hang(step):
    inside.set()
    {hang}
    return 0, 0
panel = robsim.panel(robsim.Simulation(area=(300, 300), control={control}), speed=float("inf"))
panel.url  # is served from here on
panel.start()
while not (panel.trace or inside.is_set()):
    time.sleep(0.001)
"""


@pytest.mark.slow
@pytest.mark.parametrize(("control", "hang"), [("None", "pass"), ("hang", "while 1: pass")])
def test_the_end_of_python_while_a_panel_runs(control, hang):
    code = textwrap.dedent(END).format(control=control, hang=hang)
    command = [sys.executable, "-X", "faulthandler", "-c", code]
    run = subprocess.run(command, capture_output=True, text=True, timeout=SOON, check=False)
    assert (run.returncode, run.stdout, run.stderr) == (0, "", "")
