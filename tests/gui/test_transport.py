"""The buttons, what is told of the run and its errors, and the big Stop."""

import ctypes
import math
import os
import subprocess
import sys
import textwrap
import threading
import time

import numpy as np
import pytest

import robsim
from browsers import FakeBrowser, panel_of
from python_cameras import SteppedCamera
from python_motors import Sender
from robsim.gui import _driver
from robsim.gui._panel import view as _panel_view
from robsim.gui._panel.run import transport
from robsim.gui._panel.run.trouble import trouble_of
from robsim.gui._panel.view import PanelView
from robsim.motors import MotorReceiver, UdpMotors
from waiting import wait_for

pytestmark = pytest.mark.threads

SMALL = {"area": (300, 300), "resolution": (75, 75), "seed": 1}
IMAGE = np.zeros((64, 64, 3), np.uint8)
SOON = 20  # s


def simulation(**options):
    return robsim.Simulation(**{"control": robsim.DriveAround(), **SMALL, **options})


def frames(count=5):
    return [robsim.Frame(IMAGE)] * count


def experiment(source, **options):
    given = {"area": (64, 64), "measure": False, "identify_from": "truth"}
    return robsim.Experiment(source, **(given | options))


# State


def test_the_state_of_a_run():
    with panel_of(simulation(), speed=2.0) as (view, browser):
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
        view.driver.speed = math.inf
        browser.press("start")
        assert browser.take("state", state="running")[0]["speed"] == 0
        browser.press("reset")
        browser.take("state", state="paused", steps=0)
        browser.press("turbo")
        assert browser.take("note")[0]["text"] == "there is no button 'turbo'"


def test_stages_are_told_as_they_come(monkeypatch):
    monkeypatch.setattr(_driver, "_STAGE_PAUSE", 0.01)
    with panel_of(simulation(measure=True)) as (_, browser):
        for stage in ("measure", "control", "world"):
            browser.press("step_stage")
            browser.take("stages", stage=stage)
        browser.say("animate", on=True)
        browser.take("state", animate=True)
        browser.press("start")
        for stage in ("measure", "control", "world", "measure"):
            assert browser.take("stages")[0]["stage"] == stage
        browser.say("animate", on=False)
        browser.take("state", animate=False, state="running")


def test_the_end_of_the_frames_is_told_kindly():
    with panel_of(experiment(frames(2)), speed=math.inf) as (_, browser):
        browser.press("start")
        browser.take("state", state="ended", steps=2)
        browser.press("start")
        assert browser.take("note")[0]["text"].startswith("The frames are over. Reset begins")
        browser.press("reset")
        browser.take("state", state="paused", steps=0)
    with panel_of(experiment(iter(frames(2))), speed=math.inf) as (_, browser):
        browser.press("start")
        browser.take("state", state="ended")
        browser.press("reset")
        assert "can be read only once" in browser.take("note")[0]["text"]


def test_a_camera_tells_its_rate_age_and_drops(monkeypatch):
    monkeypatch.setattr(transport, "_GAP", 0.05)
    lab = robsim.live.SimulatedLab(robsim.Scenario(resolution=(75, 75)), fps=100)
    with lab, robsim.Camera(lab) as camera, panel_of(experiment(camera, area=None)) as (_, browser):
        assert browser.take("setup")[0]["live"]
        browser.press("start")
        told = {"rate": None}
        while not told["rate"]:
            told = browser.take("state", state="running")[0]["camera"]
        assert 0 < told["rate"] <= 200
        assert 0 <= told["age"] < SOON
        assert told["dropped"] >= 0
        browser.press("pause")
        browser.take("state", state="paused")


# Errors

CONTROL = """\
def control(step):
    return wanted(step), 0


def wanted(step):
    return 1 / (2 - step.k)  # the line
"""


def test_an_error_of_a_callback_is_told_with_its_line(tmp_path):
    (tmp_path / "control.py").write_text(CONTROL)
    sim = robsim.Simulation.from_folder(tmp_path, **SMALL)
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
    with panel_of(simulation(control=lambda step: "fast")) as (_, browser):
        browser.press("step")
        error = browser.take("state", state="failed")[0]["error"]
        assert (error["slot"], error["k"]) == ("control", 0)
        assert error["file"] == __file__
        # Slot, step, file and line stand beside it.
        assert error["text"].splitlines() == [
            "CallbackTypeError: the result must be (u1, u2), the two voltages in V, got 'fast'"
        ]
    options = {"estimate_parameters": True, "measure": False, "identify_from": "measurement"}
    with panel_of(simulation(**options)) as (_, browser):
        browser.press("step")
        error = browser.take("state", state="failed")[0]["error"]
        assert (error["slot"], error["k"], error["code"], error["traceback"]) == (
            *(None, None, None),
            error["traceback"],
        )
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


def raised(error):
    try:
        raise error
    except BaseException as caught:
        return caught


def deep(n):
    return deep(n + 1)


def test_the_kind_of_an_error_has_no_module_before_it():
    class OutOfReach(Exception):
        __module__ = "robsim_callbacks.control"

    assert trouble_of(raised(OutOfReach("too far")))["text"] == "OutOfReach: too far"
    assert trouble_of(raised(OutOfReach()))["text"] == "OutOfReach"
    qualified = robsim.simulation.CallbackValueError("a.b: c")
    assert trouble_of(raised(qualified))["text"] == "CallbackValueError: a.b: c"
    assert trouble_of(raised(ValueError("builtins.x")))["text"] == "ValueError: builtins.x"


@pytest.mark.parametrize("error", [Spiteful(), ValueError("x" * 10**6), KeyboardInterrupt()])
def test_any_error_can_be_told(error):
    told = trouble_of(raised(error))
    assert type(error).__name__ in told["text"]
    assert len(told["text"]) + len(told["traceback"]) < 20_000


HOSTILE = [
    *(Spiteful(), Noted("why"), broken_syntax(), Nameless("Kind", (Exception,), {})("why")),
    *(ValueError("x" * 10**6), ValueError("\x1b[31m\u202e\ud800</script>\0"), SystemExit(1)),
]


@pytest.mark.parametrize("error", HOSTILE, ids=range(len(HOSTILE)))
def test_an_error_of_any_kind_stands_in_the_panel(error, capsys):
    def control(step):
        raise error

    with panel_of(simulation(control=control)) as (_, browser):
        browser.press("step")
        told = browser.take("state", state="failed")[0]["error"]
        assert (told["slot"], told["k"]) == ("control", 0)
        assert 0 < len(told["text"]) < 20_000
        browser.say("hello", width=300)  # it is told everything again
        browser.take("setup")
        slots = browser.take("callbacks")[0]["slots"]
        error = next(one["error"] for one in slots if one["slot"] == "control")
        assert 0 < len(error["text"]) <= 200
        for text in (told["text"], told["traceback"], error["text"]):
            assert text.replace("\n", "").isprintable()
        assert not browser.all_of("note")
    assert "robsim view" not in capsys.readouterr().err


def test_the_traceback_of_an_endless_recursion_is_short():
    with pytest.raises(RecursionError) as raised:
        deep(0)
    assert len(trouble_of(raised.value)["traceback"]) < 5000


# Stop


class Robot:
    """Motors that need no interpreter, and the robot at the other end."""

    def __init__(self):
        self.receiver = MotorReceiver()
        self.motors = UdpMotors("127.0.0.1", self.receiver.port)

    @property
    def sent(self):
        return [event.u for event in self.receiver.events if event.kind == "input"]

    @property
    def stands(self):
        return bool(self.sent) and not self.receiver.input.any()

    def close(self):
        self.motors.close()
        self.receiver.close()


@pytest.fixture(params=[Sender, Robot])
def robot(request):
    robot = request.param()
    robot.send = getattr(robot, "motors", robot)
    yield robot
    if isinstance(robot, Robot):
        robot.close()


usleep = ctypes.PyDLL(None).usleep  # with the interpreter's lock


class Hanging:
    """A controller that hangs at step 2, in one way or another, until it may go on."""

    def __init__(self, hang):
        self.hang = hang
        self.is_there = threading.Event()
        self.may_go_on = threading.Event()

    def __call__(self, step):
        if step.k == 2 and not self.may_go_on.is_set():
            self.is_there.set()
            self.hang(self.may_go_on)
        return 1.0, 2.0


@pytest.fixture
def hanging():
    """Return a function that makes such controllers, which end with the test."""
    made = []

    def make(hang):
        made.append(Hanging(hang))
        return made[-1]

    yield make
    for control in made:
        control.may_go_on.set()


def sleeps(may_go_on):
    may_go_on.wait(SOON)


def loops(may_go_on):
    while not may_go_on.is_set():
        pass


@pytest.mark.long
@pytest.mark.parametrize("hang", [sleeps, loops])
def test_stop_stops_the_robot_whatever_a_callback_does(robot, hanging, hang):
    control = hanging(hang)
    sim = experiment(frames(20), send=robot.send, control=control, frame_timeout=1000)
    with panel_of(sim, speed=math.inf) as (view, browser):
        assert browser.take("setup")[0]["motors"]
        browser.press("start")
        assert control.is_there.wait(SOON)
        for _ in range(3):
            view.driver.call(lambda: None)  # what waits does not hold it up
        browser.press("stop")
        wait_for(lambda: robot.stands)
        assert not control.may_go_on.is_set()
        inputs = len(robot.sent)
        control.may_go_on.set()
        browser.take("state", state="paused", stopped=True, error=None)
        assert robot.stands
        assert [tuple(u) for u in robot.sent[inputs:] if any(u)] == []  # its input is not sent
        browser.press("start")
        browser.take("state", state="running", stopped=False)
        browser.take("state", state="ended")
        assert view.runner.n_steps == 20


@pytest.mark.slow
@pytest.mark.long
def test_stop_after_a_callback_that_keeps_the_interpreter(robot, hanging):
    control = hanging(lambda may_go_on: usleep(900_000))
    sim = experiment(frames(10**6), send=robot.send, control=control, frame_timeout=1000)
    with panel_of(sim, speed=math.inf) as (_, browser):
        browser.press("start")
        assert control.is_there.wait(SOON)
        browser.press("stop")
        browser.take("state", state="paused", stopped=True, error=None)
        wait_for(lambda: robot.stands)  # what was sent may be under way


def test_what_was_asked_for_before_stop_does_not_move_the_robot_after(hanging):
    robot, control = Sender(), hanging(sleeps)
    sim = experiment(frames(20), send=robot, control=control, frame_timeout=1000)
    with panel_of(sim, speed=math.inf) as (view, browser):
        browser.press("start")
        assert control.is_there.wait(SOON)
        for button in ("step", "start", "step_stage", "start"):
            browser.press(button)
        browser.press("stop")
        wait_for(lambda: robot.stands)
        control.may_go_on.set()
        browser.take("state", state="paused", stopped=True)
        view.driver.call(lambda: None).result(SOON)
        time.sleep(0.02)
        assert (view.driver.state, view.runner.n_steps) == ("paused", 2)
        assert robot.stands


@pytest.mark.long
def test_stop_between_two_steps(robot):
    sim = experiment(frames(20), send=robot.send, control=lambda step: (1, 2), frame_timeout=1000)
    with panel_of(sim, speed=1e-3) as (_, browser):
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


def test_a_stop_from_elsewhere_pauses_the_run_too():
    robot = Sender()
    sim = experiment(frames(10**6), send=robot, control=lambda step: (1, 2), frame_timeout=1000)
    with panel_of(sim, speed=math.inf) as (view, browser):
        browser.press("start")
        wait_for(lambda: view.runner.n_steps > 3)
        sim.stop_robot()
        browser.take("state", state="paused", stopped=True)
        assert robot.stands


@pytest.mark.long
def test_stop_in_the_midst_of_many_steps_is_never_lost():
    """Wherever it comes between the looks of the run: it moves no more."""
    robot = Sender()
    sim = experiment(frames(10**6), send=robot, control=lambda step: (1, 2), frame_timeout=1000)
    with panel_of(sim, speed=math.inf) as (view, browser):
        for _ in range(30):
            before = view.runner.n_steps
            browser.press("start")
            wait_for(lambda before=before: view.runner.n_steps > before)
            view.driver.stop_robot().result(SOON)
            assert view.driver.state == "paused"
            assert robot.stands


def test_a_robot_that_cannot_be_stopped_is_told(monkeypatch):
    monkeypatch.setattr(transport, "_PATIENCE", SOON)
    robot = Sender()
    sim = experiment(frames(20), send=robot, control=lambda step: (1, 2), frame_timeout=1000)
    with panel_of(sim) as (_, browser):
        browser.press("step")
        browser.take("state", steps=1)
        wait_for(lambda: not sim.is_running)
        robot.error = OSError("the cable is loose")
        browser.press("stop")
        text = browser.take("note")[0]["text"]
        assert text == "The robot could not be stopped: OSError: the cable is loose"
        browser.say("hello", width=300)  # the state may have come before the note
        error = browser.take("state", state="failed")[0]["error"]
        assert "the cable is loose" in error["text"]
        robot.error = None
        browser.press("stop")
        wait_for(lambda: robot.stands)


@pytest.mark.long
def test_the_panel_answers_while_what_stops_the_robot_hangs():
    is_free = threading.Event()

    def send(u):
        if not np.any(u):
            is_free.wait(SOON)

    sim = experiment(frames(20), send=send, control=lambda step: (1, 2), frame_timeout=1000)
    with panel_of(sim) as (_, browser):
        browser.press("step")
        browser.take("state", steps=1)
        wait_for(lambda: not sim.is_running)
        for _ in range(2 * transport._MOST_STOPS):
            browser.press("stop")
        assert "have not answered" in browser.take("note")[0]["text"]
        browser.say("inspect", k=None, path=[])
        browser.take("tree")
        names = [thread.name for thread in threading.enumerate()]
        assert names.count("robsim stop") <= transport._MOST_STOPS
        is_free.set()
        browser.take("state", state="paused", stopped=True)


def test_stop_of_a_simulation_is_pause():
    with panel_of(simulation(), speed=math.inf) as (_, browser):
        browser.press("start")
        browser.take("state", state="running")
        browser.press("stop")
        browser.take("state", state="paused", stopped=False)


def test_a_robot_that_nobody_looks_at_is_stopped_at_once(monkeypatch):
    monkeypatch.setattr(_panel_view, "_PATIENCE", 1000.0)
    robot, source = Sender(), SteppedCamera([IMAGE] * 20)
    source.permits.release()
    with robsim.Camera(source, open_timeout=SOON) as camera:
        sim = experiment(camera, send=robot, control=lambda step: (1, 2), frame_timeout=1000)
        with panel_of(sim) as (view, browser):
            browser.press("start")
            wait_for(lambda: robot.sent)
            browser.say("bye")
            wait_for(lambda: view.driver.state == "paused")
            assert robot.stands
            browser.say("hello", width=300)
            browser.take("state", state="paused", stopped=True)


# The run and the panel

LOOP_TIME = 0.2  # s


def steps_done(watch):
    """Steps in some time as fast as it goes; `watch` connects browsers."""
    view = PanelView(simulation(measure=True), speed=math.inf)
    try:
        watch(view)
        view.driver.start().result(SOON)
        before, start = view.runner.n_steps, time.monotonic()
        time.sleep(LOOP_TIME)
        return (view.runner.n_steps - before) / (time.monotonic() - start)
    finally:
        view.close()


@pytest.mark.long
@pytest.mark.parametrize("room", [0, 10**9])
def test_the_loop_is_not_slowed_by_who_looks(room):
    def watch(view):
        FakeBrowser(view, width=300, room=room).say("columns", names=["pose_true", "pose_measured"])

    ratios = (steps_done(watch) / steps_done(lambda view: None) for _ in range(5))
    assert any(ratio > 0.3 for ratio in ratios)


# The end of Python

END = """
import math, threading, time
import robsim
from robsim.gui._hosts.page import Page
from robsim.gui._panel.view import PanelView
inside = threading.Event()
def hang(step):
    inside.set()
    {hang}
    return 0, 0
view = PanelView(robsim.Simulation(measure=True, area=(300, 300), resolution=(75, 75),
                                   control={control}), speed=math.inf)
page = Page(view)
view.driver.start()
while not (view.runner.n_steps or inside.is_set()):
    time.sleep(0.001)
"""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("control", "hang"),
    [("None", "pass"), ("hang", "pass"), ("hang", "time.sleep(1000)"), ("hang", "while 1: pass")],
)
def test_the_end_of_python_while_a_panel_runs(control, hang):
    code = textwrap.dedent(END).format(control=control, hang=hang)
    environment = {**os.environ, "PYTHONFAULTHANDLER": "1"}
    run = subprocess.run(
        [sys.executable, "-c", code],
        **{"capture_output": True, "text": True, "timeout": 60, "check": False},
        env=environment,
    )
    assert (run.returncode, run.stdout, run.stderr) == (0, "", "")
