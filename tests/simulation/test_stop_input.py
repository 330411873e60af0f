"""Whatever ends the run of an experiment, the last thing that is sent stops the robot."""

import _thread
import atexit
import contextlib
import gc
import math
import os
import queue
import re
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import robsim
from threads import in_thread
from waiting import wait_for

IMAGE = np.zeros((6, 8, 3), np.uint8)
MAP = robsim.vision.PlaneMap.scaled((8, 6), (1200, 1200))
STOP = (0.0, 0.0)
LONG = 300  # s, a limit that nothing meets


@pytest.fixture(autouse=True)
def _ctrl_c():
    # What a shell starts in the background ignores it.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.fixture(autouse=True)
def _no_thread_survives():
    before = set(threading.enumerate())
    yield
    for thread in set(threading.enumerate()) - before:
        thread.join(LONG)
        assert not thread.is_alive()


def frame(k):
    return robsim.Frame(IMAGE, index=k, plane_map=MAP)


def input_of(k):
    return (k + 1.0, 0.5)


class Robot:
    """Remembers what it was sent, the same twice as one; the calls numbered in `failing` raise."""

    def __init__(self, failing=(), error=None):
        self.sent = []
        self.calls = 0
        self.failing = failing
        self.error = error or OSError("the cable is loose")

    def __call__(self, u):
        call, self.calls = self.calls, self.calls + 1
        if call in self.failing:
            raise self.error
        if self.sent[-1:] != [tuple(u)]:
            self.sent.append(tuple(u))

    @property
    def drives(self):
        return bool(self.sent) and self.sent[-1] != STOP


def estimate(step):
    return robsim.Estimate((0, 0, 0), np.eye(3))


def control(step):
    return input_of(step.k)


RESULTS = {
    "estimate_parameters": lambda step: None,
    "measure": lambda step: None,
    "estimate_state": estimate,
    "control": control,
}


def experiment(robot, frames=6, **options):
    if isinstance(frames, int):
        frames = [frame(k) for k in range(frames)]
    given = {"measure": False, "identify_from": "truth", "control": control}
    return robsim.Experiment(frames, send=robot, **given | {"frame_timeout": LONG} | options)


def failing_once(act, then, k=3):
    """A callback that does something else the first time that a step comes."""
    steps = [k]

    def callback(step):
        if [step.k] == steps:
            steps.clear()
            act()
        return then(step)

    return callback


def fail():
    raise ZeroDivisionError("of the test")


def interrupt():
    signal.raise_signal(signal.SIGINT)


def dawdle():
    end = time.monotonic() + LONG
    while time.monotonic() < end:
        time.sleep(0.01)


@pytest.mark.parametrize("frame_timeout", [math.inf, LONG])
def test_an_input_is_sent_the_moment_that_it_is_decided(frame_timeout):
    events = []

    def frames():
        for k in range(4):
            events.append(("asked for", k))
            yield frame(k)

    def control(step):
        events.append(("decided", step.k))
        return input_of(step.k)

    def send(u):
        events.append(("sent", *u))

    trace = experiment(send, frames(), control=control, frame_timeout=frame_timeout).run()
    expected = []
    for k in range(4):
        expected += [("asked for", k), ("decided", k), ("sent", *input_of(k))]
    assert events == [*expected, ("sent", *STOP), ("sent", *STOP)]
    np.testing.assert_array_equal(trace.u, [input_of(k) for k in range(4)])
    assert not trace.interrupted.any()


@pytest.mark.long
@pytest.mark.parametrize(
    ("slot", "act", "error"),
    [
        *((slot, fail, ZeroDivisionError) for slot in RESULTS),
        ("estimate_state", interrupt, KeyboardInterrupt),
        ("control", interrupt, KeyboardInterrupt),
        ("measure", sys.exit, SystemExit),
    ],
)
def test_what_a_stage_raises_stops_the_robot(slot, act, error):
    robot = Robot()
    sim = experiment(robot, **{slot: failing_once(act, RESULTS[slot])})
    with pytest.raises(error) as raised:
        sim.run()
    assert f"in the callback {slot} at step 3" in raised.value.__notes__
    assert robot.sent == [*map(input_of, range(3)), STOP]
    assert len(sim.trace) == 3
    # The next run goes on with the stage that was interrupted.
    trace = sim.run()
    assert robot.sent[4:] == [*map(input_of, range(3, 6)), STOP]
    np.testing.assert_array_equal(trace.u, [input_of(k) for k in range(6)])
    # The frame of step 3 came before the stop, that of step 4 after it.
    np.testing.assert_array_equal(np.flatnonzero(trace.interrupted), [4])


def test_an_exceeded_time_limit_stops_the_robot():
    robot = Robot()
    sim = experiment(robot, control=failing_once(dawdle, control, k=1), time_limit=0.2)
    with pytest.raises(TimeoutError, match="time_limit"):
        sim.run()
    assert robot.sent == [input_of(0), STOP]


def test_nothing_is_sent_before_the_start_and_nothing_is_stopped_that_was_sent_nothing():
    robot = Robot()
    for slot in ("define_model", "init_parameter_estimator"):
        with (
            experiment(robot, **{slot: lambda *_: fail()}) as sim,
            pytest.raises(ZeroDivisionError),
        ):
            sim.run()
    with experiment(robot, control=None) as sim, pytest.warns(UserWarning, match="no controller"):
        sim.run()
    with experiment(robot):
        pass
    assert robot.calls == 0


class Frames:
    """Six frames, before one of which an error is raised, after which it can go on."""

    def __init__(self, failing, error):
        self.numbers = iter([*range(failing), None, *range(failing, 6)])
        self.error = error

    def __iter__(self):
        return self

    def __next__(self):
        k = next(self.numbers)
        if k is None:
            raise self.error
        return frame(k)


@pytest.mark.parametrize(
    ("frame_timeout", "error"), [(math.inf, SystemExit()), (LONG, TimeoutError("no light"))]
)
def test_what_the_source_raises_stops_the_robot(frame_timeout, error):
    robot = Robot()
    sim = experiment(robot, Frames(3, error), frame_timeout=frame_timeout)
    with pytest.raises(type(error)) as raised:
        sim.run()
    assert raised.value is error
    assert "in frames at step 3" in error.__notes__
    assert robot.sent == [*map(input_of, range(3)), STOP]
    trace = sim.run()
    assert robot.sent[4:] == [*map(input_of, range(3, 6)), STOP]
    np.testing.assert_array_equal(np.flatnonzero(trace.interrupted), [3])
    # A generator cannot go on.
    sim = experiment(robot, iter(list(Frames(0, error)) for _ in "x"), frame_timeout=frame_timeout)
    with pytest.raises(type(error)):
        sim.run()
    with pytest.raises(EOFError, match="exception at step 0"):
        sim.run()


def test_an_input_that_cannot_be_sent_stops_the_robot():
    robot = Robot(failing=[3])
    sim = experiment(robot)
    with pytest.raises(OSError, match="the cable") as raised:
        sim.run()
    assert raised.value.__notes__ == ["in send at step 3"]
    assert robot.sent == [*map(input_of, range(3)), STOP]
    # It is sent again, and what was sent last is the last input of the next step.
    assert len(sim.trace) == 3
    assert sim.step().k == 3
    np.testing.assert_array_equal(sim.step().last_u, input_of(3))
    np.testing.assert_array_equal(sim.trace.interrupted, [0, 0, 0, 0, 1])


def test_a_robot_that_cannot_be_stopped_is_told():
    robot = Robot(failing=range(3, 100))
    sim = experiment(robot)
    with pytest.raises(OSError, match="the cable") as raised:
        sim.run()
    place, failure = raised.value.__notes__
    assert place == "in send at step 3"
    assert "OSError: the cable is loose" in failure
    assert robot.calls == 8
    robot.error = OSError("still loose")
    with pytest.raises(OSError, match="still loose"), sim:
        pass
    robot.failing = []
    with sim:  # tries again
        pass
    assert robot.sent[-1] == STOP


def test_the_stop_input_is_sent_twice_and_again_where_it_fails():
    heard = []
    experiment(lambda u: heard.append(tuple(u)), 2).run()
    assert heard == [input_of(0), input_of(1), STOP, STOP]
    robot = Robot(failing=[6, 8])
    experiment(robot).run()
    assert robot.calls == 10
    assert robot.sent[-1] == STOP


@pytest.mark.parametrize(
    ("failing", "act", "error"),
    [(6, lambda: None, KeyboardInterrupt), (4, fail, ZeroDivisionError)],
)
def test_the_stop_input_is_sent_in_spite_of_ctrl_c(failing, act, error):
    robot = Robot(failing=[failing], error=KeyboardInterrupt())
    with pytest.raises(error):
        experiment(robot, control=failing_once(act, control)).run()
    assert robot.sent[-1] == STOP


def test_a_step_leaves_the_robot_driving_until_its_block_is_left():
    robot = Robot()
    with experiment(robot) as sim:
        sim.step()
        sim.step()
        assert robot.sent == [input_of(0), input_of(1)]
    assert robot.sent == [input_of(0), input_of(1), STOP]
    sim.step()
    with pytest.raises(ZeroDivisionError) as raised, sim:
        fail()
    assert robot.sent[3:] == [input_of(2), STOP]
    assert not hasattr(raised.value, "__notes__")
    with sim:
        for stage in ("world", "control"):
            assert sim.step_stage() == stage
        assert robot.drives
    assert robot.sent[5:] == [input_of(3), STOP]
    np.testing.assert_array_equal(np.flatnonzero(sim.trace.interrupted), [2, 3])


def test_whatever_else_ends_a_series_of_steps_stops_the_robot(tmp_path):
    robot = Robot()
    sim = experiment(robot, 1)
    sim.step()
    with pytest.raises(EOFError):
        sim.step()
    assert robot.sent == [input_of(0), STOP]

    (tmp_path / "control.py").write_text("def control(step):\n    return 1, 1\n")
    robot = Robot()
    frames = [frame(k) for k in range(6)]
    options = {"send": robot, "measure": False, "frame_timeout": LONG}
    sim = robsim.Experiment.from_folder(tmp_path, frames=frames, **options)
    sim.step()
    assert robot.drives
    (tmp_path / "control.py").write_text("def control(step)\n    return 100, 100\n")
    with pytest.raises(SyntaxError):
        sim.step()
    assert not robot.drives

    robot = Robot()
    sim = experiment(robot)
    sim.step()
    sim.reset()
    assert robot.sent == [input_of(0), STOP]
    np.testing.assert_array_equal(sim.step().last_u, STOP)
    assert not sim.trace.interrupted.any()


def test_after_a_stop_the_last_input_is_the_stop_input():
    robot, seen = Robot(), []
    sim = experiment(robot, control=lambda step: seen.append(tuple(step.last_u)) or control(step))
    sim.run(2)
    trace = sim.run()
    assert seen == [STOP, input_of(0), STOP, input_of(2), input_of(3), input_of(4)]
    np.testing.assert_array_equal(trace.interrupted, [0, 0, 1, 0, 0, 0])
    # What was sent is recorded, the stop is not an input of a step.
    np.testing.assert_array_equal(trace.u, [input_of(k) for k in range(6)])


def test_another_stop_input_and_none():
    robot = Robot()
    experiment(robot, stop_input=(-0.1, 0.2)).run(2)
    assert robot.sent == [input_of(0), input_of(1), (-0.1, 0.2)]
    for stop_input in ((math.nan, 0), (0, math.inf), (1,)):
        with pytest.raises(ValueError, match="stop_input"):
            robsim.Experiment([], send=print, stop_input=stop_input)
    robot = Robot()
    with experiment(robot, stop_input=None, control=failing_once(fail, control)) as sim:
        with pytest.raises(ZeroDivisionError):
            sim.run()
        trace = sim.run()
    assert robot.sent == [input_of(k) for k in range(6)]
    assert not trace.interrupted.any()


def test_samples_do_not_span_a_stop():
    poses = np.cumsum(np.full((9, 3), (3.0, 2.0, 0.1)), axis=0)
    samples = []

    def estimate_parameters(step):
        if step.sample:
            samples.append(step.sample.k)

    observations = [robsim.Observation(measurement=pose) for pose in poses]
    options = {"identify_from": "measurement", "measure": True}
    sim = experiment(Robot(), observations, estimate_parameters=estimate_parameters, **options)
    sim.run(4)
    trace = sim.run()
    assert samples == [2, 3, 6, 7]
    np.testing.assert_array_equal(robsim.estimation.regression_of(trace).k, [2, 3, 6, 7, 8])


def test_a_pause_after_a_stop_may_have_any_length():
    """The robot stood still: that the pause is no multiple of dt matters to nobody."""
    times = (0, 0.2, 0.4, 3.69, 3.89)
    frames = [robsim.Observation(measurement=(10.0 * t, 5, 0), t=t) for t in times]
    steps = []
    options = {"identify_from": "measurement", "measure": True, "estimate_parameters": True}
    sim = experiment(
        Robot(),
        frames,
        control=lambda step: steps.append(step.dt) or (0.1, 0.1),
        estimate_state=robsim.estimation.reference.ExtendedKalmanFilter(),
        **options,
    )
    sim.run(3)
    np.testing.assert_array_equal(sim.run().t, times)
    np.testing.assert_allclose(steps, [0.2, 0.2, 0.2, 3.2, 0.2])


class Arrivals(queue.SimpleQueue):
    """Frames that come when they are put; None ends them."""

    dt = None

    def __iter__(self):
        return iter(self.get, None)


class Stalled:
    """An experiment whose frames stop coming after three."""

    def __init__(self, frame_timeout=LONG, dt=None):
        self.robot = Robot()
        self.arrivals = Arrivals()
        self.arrivals.dt = dt
        for k in range(3):
            self.arrivals.put(frame(k))
        self.sim = experiment(self.robot, self.arrivals, frame_timeout=frame_timeout)

    def is_waiting(self):
        return self.sim.is_running and self.sim.n_steps == 3

    def check_stopped(self):
        assert self.robot.sent == [*map(input_of, range(3)), STOP]

    def check_that_nothing_is_lost(self):
        seen = []
        self.sim.estimate_state = lambda step: seen.append(step.frame.index) or estimate(step)
        for arrival in (*map(frame, range(3, 6)), None):
            self.arrivals.put(arrival)
        trace = self.sim.run()
        assert seen == [3, 4, 5]
        np.testing.assert_array_equal(trace.u, [input_of(k) for k in range(6)])
        np.testing.assert_array_equal(np.flatnonzero(trace.interrupted), [3])
        assert self.robot.sent[4:] == [*map(input_of, range(3, 6)), STOP]


@pytest.mark.long
def test_a_frame_that_does_not_come_stops_the_robot_and_then_says_so():
    stalled = Stalled(frame_timeout=1)
    for _ in range(2):
        with pytest.raises(TimeoutError, match=r"no frame came for step 3 .* frame_timeout = 1 s"):
            stalled.sim.run()
        stalled.check_stopped()
    stalled.check_that_nothing_is_lost()


@pytest.mark.long
@pytest.mark.parametrize(("dt", "timeout"), [(None, 1), (0.2, 0.6), (0.02, r"0\.[123]\d*")])
def test_how_long_a_frame_is_waited_for_by_default(dt, timeout):
    stalled = Stalled(frame_timeout=None, dt=dt)
    with pytest.raises(TimeoutError, match=f"frame_timeout = {timeout} s"):
        stalled.sim.run()
    stalled.arrivals.put(None)


def time_out_after(gap):
    """The default time-out of frames that came so far apart."""
    arrivals = Arrivals()
    arrivals.dt = 0.05
    epoch = time.monotonic() + 1  # so that the second frame is not late on a busy machine
    for t in (0, gap):
        arrivals.put(robsim.Frame(IMAGE, t=t, t_arrival=t, epoch=epoch, plane_map=MAP))
    with pytest.raises(TimeoutError) as raised:
        experiment(Robot(), arrivals, frame_timeout=None).run()
    arrivals.put(None)
    return float(re.search(r"frame_timeout = ([\d.]+) s", str(raised.value))[1])


@pytest.mark.long
@pytest.mark.parametrize(("gap", "timeout"), [(0.05, 0.15), (0.0998, 0.2), (5, 0.3)])
def test_the_default_time_out_follows_the_jitter_within_bounds(gap, timeout):
    # The next whole ms, so no gap that is rounded up or not as the clock stands. The machine may
    # stop for longer than a second now and then.
    assert any(time_out_after(gap) == pytest.approx(timeout) for _ in range(20))


@pytest.mark.parametrize(
    ("wait", "end", "comes_to"),
    [
        ("run", lambda sim: sim.stop(), contextlib.nullcontext()),
        ("step_stage", lambda sim: sim.stop(), pytest.raises(RuntimeError, match="stop")),
        ("run", lambda sim: _thread.interrupt_main(), pytest.raises(KeyboardInterrupt)),
    ],
)
def test_the_wait_for_a_frame_can_be_ended(wait, end, comes_to):
    stalled = Stalled()
    if wait == "step_stage":
        for _ in range(3):
            stalled.sim.step()
    answers = []

    def end_it():
        wait_for(stalled.is_waiting)
        answers.append(end(stalled.sim))

    with in_thread(end_it), comes_to:
        getattr(stalled.sim, wait)()
    assert answers[0] in (True, None)
    assert not stalled.sim.stop()
    stalled.check_stopped()
    stalled.check_that_nothing_is_lost()


@pytest.mark.parametrize("frame_timeout", [LONG, math.inf])
def test_the_end_of_a_block_stops_a_run_in_another_thread(frame_timeout):
    stalled = Stalled(frame_timeout)
    with in_thread(stalled.sim.run), stalled.sim:
        wait_for(stalled.is_waiting)
    assert not stalled.sim.is_running
    stalled.check_stopped()
    stalled.check_that_nothing_is_lost()


def test_a_callback_that_stops_ends_the_run_after_the_step_and_the_robot_after_a_stage():
    robot = Robot()
    sim = experiment(robot)
    sim.estimate_state = failing_once(lambda: sim.stop(), estimate)
    assert len(sim.run()) == 4
    assert robot.sent == [*map(input_of, range(4)), STOP]
    robot.sent.clear()
    sim.control = lambda step: sim.stop() and input_of(step.k)
    assert [sim.step_stage() for _ in range(3)] == ["world", "estimate_state", "control"]
    assert robot.sent == [input_of(4), STOP]


def test_a_second_run_is_refused_and_the_first_one_goes_on():
    robot = Robot()

    def control(step):
        for again in (sim.run, sim.step, sim.step_stage, sim.reset):
            with pytest.raises(RuntimeError, match="already running"):
                again()
        return input_of(step.k)

    sim = experiment(robot, map(frame, range(6)), control=control)
    assert len(sim.run(4)) == 4
    assert robot.sent == [*map(input_of, range(4)), STOP]
    sim.step()
    assert robot.drives
    with pytest.raises(RuntimeError, match="only once"):
        sim.reset()
    assert not robot.drives


class Live:
    """Frames that say when they came, and a robot that says when it is stopped."""

    def __init__(self, frame_timeout):
        self.robot = Robot()
        self.stopped = threading.Event()
        self.epoch = time.monotonic()
        self.sim = experiment(self.heard, self.frames(), frame_timeout=frame_timeout)

    def frames(self):
        for k in range(20):
            t = time.monotonic() - self.epoch
            yield robsim.Frame(IMAGE, t=t, epoch=self.epoch, index=k, plane_map=MAP)

    def heard(self, u):
        self.robot(u)
        if not self.robot.drives:
            self.stopped.set()


@pytest.mark.long
@pytest.mark.threads
def test_a_watchdog_stops_the_robot_while_a_callback_takes_too_long():
    # On a machine that stands still for a second the robot would be stopped sooner.
    live = Live(frame_timeout=1)
    live.sim.control = failing_once(lambda: live.stopped.wait(LONG), control, k=1)
    with pytest.raises(TimeoutError, match=r"frame_timeout = 1 s of the arrival"):
        live.sim.run()
    assert live.stopped.is_set()
    # The input of a callback that was late is not sent.
    assert live.robot.sent == [input_of(0), STOP]
    # The next run takes a new frame: that of the step that was broken off is out of date.
    trace = live.sim.run(2)
    assert live.robot.sent[2:] == [input_of(2), input_of(3), STOP]
    assert np.isnan(trace.u[1]).all()
    np.testing.assert_array_equal(np.flatnonzero(trace.interrupted), [2])


@pytest.mark.long
@pytest.mark.threads
def test_a_watchdog_stops_the_robot_after_a_step():
    live = Live(frame_timeout=0.2)
    live.sim.step()
    assert live.robot.sent[0] == input_of(0)
    assert live.stopped.wait(LONG)
    live.sim.step()
    assert live.robot.sent[:3] == [input_of(0), STOP, input_of(1)]
    np.testing.assert_array_equal(live.sim.trace.interrupted, [False, True])


def test_the_trace_says_when_a_frame_arrived_and_when_its_input_went_out():
    live = Live(frame_timeout=LONG)
    trace = live.sim.run(5)
    assert (trace.t <= trace.t_arrival).all()
    assert (trace.t_arrival <= trace.t_sent).all()
    assert (trace.t_sent[:-1] <= trace.t[1:]).all()
    assert trace.t_sent[-1] <= time.monotonic() - live.epoch


@pytest.mark.threads
def test_an_experiment_that_is_dropped_stops_its_robot():
    live = Live(frame_timeout=LONG)
    live.sim.step()
    assert live.robot.drives
    live.sim = None
    gc.collect()
    assert not live.robot.drives


END = """
import numpy as np, robsim
frames = [robsim.Frame(np.zeros((64, 64, 3), np.uint8)) for k in range(3)]
send = lambda u: print(*u, flush=True)
experiment = robsim.Experiment(frames, send=send, control=lambda step: (1, 2), area=(64, 64),
                               measure=None, frame_timeout=300)
experiment.step()
"""


@pytest.mark.long
def test_the_end_of_python_stops_the_robot():
    run = subprocess.run([sys.executable, "-c", END], capture_output=True, text=True, check=True)
    assert run.stdout.splitlines() == ["1.0 2.0", "0.0 0.0", "0.0 0.0"]
    assert run.stderr == ""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
def test_the_end_of_a_forked_process_sends_nothing():
    def control(step):
        if step.k == 1:
            child = os.fork()
            if child == 0:
                try:
                    atexit._run_exitfuncs()
                finally:
                    os._exit(0)
            os.waitpid(child, 0)
        return input_of(step.k)

    heard, sends = os.pipe()
    experiment(lambda u: os.write(sends, b"u" if u.any() else b"s"), 3, control=control).run()
    assert os.read(heard, 100) == b"uuuss"
    os.close(heard)
    os.close(sends)
