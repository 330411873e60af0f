"""The motors of an experiment: native links and stops."""

import ctypes
import queue
import sys
import threading
import time

import numpy as np
import pytest

import robsim
from python_devices import Sender
from robsim.lab import HaltedError, Limits, LineError, MotorReceiver, RecordedMotors, UdpMotors
from threads import in_thread
from waiting import wait_for

pytestmark = pytest.mark.threads


# --- stops


IMAGE = np.zeros((64, 64, 3), np.uint8)
STOP = (0.0, 0.0)
LONG = 300  # s, a limit that nothing meets


class Gate:
    """A controller that waits at step 2 until it may go on."""

    def __init__(self):
        self.is_there = threading.Event()
        self.may_go_on = threading.Event()

    def __call__(self, step):
        if step.k == 2:
            self.is_there.set()
            assert self.may_go_on.wait(LONG)
        return step.k + 1.0, 0.5


def experiment(send, frames=5, **options):
    if isinstance(frames, int):
        frames = [robsim.Frame(IMAGE, index=k) for k in range(frames)]
    given = {"control": lambda step: (step.k + 1.0, 0.5), "measure": False, "area": (64, 64)}
    return robsim.Experiment(frames, send=send, **(given | {"frame_timeout": LONG} | options))


def halted(run):
    with pytest.raises(HaltedError) as raised:
        run()
    return raised.value


def test_a_callback_under_way_does_not_keep_the_robot_driving():
    send, gate = Sender(), Gate()
    sim = experiment(send, control=gate)
    with in_thread(lambda: halted(sim.run)):
        gate.is_there.wait(LONG)
        sim.stop_robot()
        assert send.sent == [(1.0, 0.5), (2.0, 0.5), STOP, STOP]  # while the callback is at work
        gate.may_go_on.set()
    assert set(send.sent[2:]) == {STOP}  # and its input is not sent
    assert len(sim.trace) == 2
    gate.is_there.clear()
    sim.run(1)
    assert send.sent[-3:] == [(3.0, 0.5), STOP, STOP]


def test_the_error_says_why_no_input_is_taken():
    send = Sender()
    sim = experiment(send, control=lambda step: sim.stop_robot() or (1, 1))
    error = halted(sim.step)
    assert error.__notes__ == ["in send at step 0"]
    assert send.sent == []  # nothing had moved


def test_a_wait_for_a_frame_ends():
    send, frames = Sender(), queue.Queue()
    frames.put(robsim.Frame(IMAGE))
    sim = experiment(send, iter(frames.get, None))
    with in_thread(sim.run):
        wait_for(lambda: send.sent)
        sim.stop_robot()
    frames.put(None)
    assert send.sent[0] == (1.0, 0.5)
    assert set(send.sent[1:]) == {STOP}


def test_motors_that_need_no_interpreter():
    gate = Gate()
    with MotorReceiver() as robot, UdpMotors("127.0.0.1", robot.port) as motors:
        sim = experiment(motors, control=gate)
        with in_thread(lambda: halted(sim.run)):
            gate.is_there.wait(LONG)
            sim.stop_robot()
            wait_for(lambda: "stop" in {event.kind for event in robot.events})
            assert motors.is_halted
            gate.may_go_on.set()
        gate.is_there.clear()
        sim.run(1)
        wait_for(lambda: [event.u for event in robot.events if event.kind == "input"][-1][0] == 3)


def test_between_two_runs():
    send = Sender()
    sim = experiment(send)
    sim.step()
    with in_thread(sim.stop_robot):
        pass
    assert send.sent == [(1.0, 0.5), STOP, STOP]
    sim.stop_robot()
    assert len(send.sent) == 3  # it stands
    sim.step()
    np.testing.assert_array_equal(sim.trace.interrupted, [False, True])


def test_what_send_raises_is_raised_here_between_two_runs_and_by_the_run_otherwise():
    send, gate = Sender(), Gate()
    sim = experiment(send, control=gate)
    sim.step()
    send.error = OSError("the cable is loose")
    with pytest.raises(OSError, match="the cable"):
        sim.stop_robot()
    send.error = None
    sim.step()

    def run():
        error = halted(sim.run)
        assert any("OSError: the cable is loose" in note for note in error.__notes__)

    with in_thread(run):
        gate.is_there.wait(LONG)
        send.error = OSError("the cable is loose")
        sim.stop_robot()
        gate.may_go_on.set()
    send.error = None
    sim.stop_robot()
    assert send.sent[-1] == STOP


@pytest.mark.long
def test_a_stop_in_the_midst_of_many_short_runs_disturbs_none_of_them():
    """Between two runs it has the loop for a moment, for which the next one waits."""
    send, said = Sender(), []
    sim = experiment(send, 101)

    def steps():
        for _ in range(100):
            try:
                sim.step()
            except RuntimeError as error:
                said.append(error)

    with in_thread(steps) as thread:
        while thread.is_alive():
            sim.stop_robot()
    for error in said:
        assert isinstance(error, HaltedError) or "stop() was called" in str(error)
    n_steps = sim.n_steps
    sim.step()
    assert sim.n_steps == n_steps + 1


def test_without_motors_it_ends_the_run():
    gate = Gate()
    sim = experiment(None, control=gate)
    with in_thread(lambda: sim.run(5)):
        gate.is_there.wait(LONG)
        sim.stop_robot()
        gate.may_go_on.set()
    assert sim.n_steps == 3


def test_what_is_live():
    assert not experiment(None).is_live
    with robsim.lab.SimulatedLab(fps=100) as lab, robsim.Camera(lab) as camera:
        assert robsim.Experiment(camera).is_live


# --- native links


DT = 0.02  # s


@pytest.fixture
def robot():
    with MotorReceiver() as receiver:
        yield receiver


@pytest.fixture
def motors(robot):
    with UdpMotors("127.0.0.1", robot.port) as link:
        yield link


def camera():
    epoch = time.monotonic()
    for k in range(1000):
        time.sleep(DT)
        yield robsim.Frame(IMAGE, t=time.monotonic() - epoch, epoch=epoch, index=k)


def native_experiment(send, frames=None, **options):
    given = {"control": lambda step: (0.5, 0.1), "measure": False, "area": (64, 64)}
    given |= {"frame_timeout": LONG} | options
    frames = camera() if frames is None else frames
    return robsim.Experiment(frames, send=send, identify_from="truth", **given)


@pytest.fixture
def greedy():
    """A thread that has the interpreter keeps it until it waits for something."""
    before = sys.getswitchinterval()
    sys.setswitchinterval(LONG)
    yield
    sys.setswitchinterval(before)


def heard(robot, *kinds):
    return [event for event in robot.events if event.kind in kinds]


@pytest.mark.long
def test_what_is_sent_arrives_and_the_end_stops_the_robot(robot, motors):
    trace = native_experiment(motors).run(5)
    wait_for(lambda: heard(robot, "stop"))
    assert len(heard(robot, "input")) >= 5  # those that wait long for the next are sent again
    np.testing.assert_array_equal(robot.input, (0, 0))
    # When it went out is when it was written to the line.
    sent = [event.t for event in motors.events if event.kind == "input"]
    assert len(sent) == 5
    np.testing.assert_allclose(np.diff(trace.t_sent), np.diff(sent), atol=1e-9)


@pytest.mark.long
@pytest.mark.usefixtures("greedy")
def test_a_callback_that_holds_the_interpreter_does_not_keep_the_robot_driving(robot, motors):
    usleep = ctypes.PyDLL(None).usleep  # with the interpreter's lock

    def control(step):
        if step.k == 1:
            held.append(time.monotonic())
            while not heard(robot, "stop") and len(held) < LONG:
                usleep(100_000)
                held.append(time.monotonic())
        return 0.5, 0.1

    held = []
    # On a machine that stands still for half a second the robot would be stopped sooner.
    sim = native_experiment(motors, control=control, frame_timeout=0.5)
    with pytest.raises(TimeoutError, match=r"frame_timeout = 0\.5 s"):
        sim.run()
    assert len(sim.trace) == 1
    (stop, *_) = heard(robot, "stop")
    assert held[0] < stop.t < held[-1]  # while nobody had the interpreter but the callback
    wait_for(lambda: not robot.input.any())
    # The next run is told anew that the motors may drive.
    sim.control = lambda step: (0.2, 0.1)
    sim.run(1)
    wait_for(lambda: heard(robot, "input")[-1].u[0] == pytest.approx(0.2))


@pytest.mark.long
def test_a_cut_line_ends_the_run_and_says_so(robot):
    def control(step):
        if step.k == 3:
            robot.close()
        return 0.5, 0.1

    with (
        pytest.raises(LineError, match=r"127\.0\.0\.1:\d+"),
        UdpMotors("127.0.0.1", robot.port) as motors,
    ):
        native_experiment(motors, control=control).run(200)


def test_a_link_has_a_stop_of_its_own(motors):
    for stop_input in (None, (0.1, 0)):
        with pytest.raises(ValueError, match="stop_input"):
            native_experiment(motors, stop_input=stop_input)


def test_limits_hold_the_inputs_and_the_trace_has_what_was_sent():
    frames = [robsim.Frame(IMAGE, t=0.2 * k) for k in range(6)]
    wanted = [(3, 1), (3, 1), (-3, -1), (0, 0), (0.2, 0.1), (0.2, 0.1)]
    seen = []

    def control(step):
        seen.append(tuple(step.last_u))
        return wanted[step.k]

    motors = RecordedMotors()
    limits = Limits(voltage=1.5, slew_rate=5)
    trace = native_experiment(motors, frames, control=control, limits=limits).run()
    np.testing.assert_array_equal(trace.u, motors.inputs[:6])
    before = (0, 0)
    for u, got in zip(wanted, trace.u, strict=True):
        np.testing.assert_allclose(got, limits.applied(u, before, 0.2))
        before = got
    assert abs(trace.u).max() <= 1.5
    np.testing.assert_array_equal(trace.u[3], (0, 0))  # a stop is never slowed down
    np.testing.assert_allclose(seen[1:], trace.u[:-1])
    with pytest.raises(TypeError, match="limits"):
        native_experiment(motors, limits=3)
