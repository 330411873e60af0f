"""An experiment with motors that need no interpreter: dead man, limits, errors of the line."""

import ctypes
import sys
import time

import numpy as np
import pytest

import robsim
from robsim.lab import Limits, LineError, MotorReceiver, RecordedMotors, UdpMotors
from waiting import wait_for

pytestmark = pytest.mark.threads

IMAGE = np.zeros((64, 64, 3), np.uint8)
DT = 0.02  # s
LONG = 300  # s, a limit that nothing meets


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


def experiment(send, frames=None, **options):
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
    trace = experiment(motors).run(5)
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
    sim = experiment(motors, control=control, frame_timeout=0.5)
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
        experiment(motors, control=control).run(200)


def test_a_link_has_a_stop_of_its_own(motors):
    for stop_input in (None, (0.1, 0)):
        with pytest.raises(ValueError, match="stop_input"):
            experiment(motors, stop_input=stop_input)


def test_limits_hold_the_inputs_and_the_trace_has_what_was_sent():
    frames = [robsim.Frame(IMAGE, t=0.2 * k) for k in range(6)]
    wanted = [(3, 1), (3, 1), (-3, -1), (0, 0), (0.2, 0.1), (0.2, 0.1)]
    seen = []

    def control(step):
        seen.append(tuple(step.last_u))
        return wanted[step.k]

    motors = RecordedMotors()
    limits = Limits(voltage=1.5, slew_rate=5)
    trace = experiment(motors, frames, control=control, limits=limits).run()
    np.testing.assert_array_equal(trace.u, motors.inputs[:6])
    before = (0, 0)
    for u, got in zip(wanted, trace.u, strict=True):
        np.testing.assert_allclose(got, limits.applied(u, before, 0.2))
        before = got
    assert abs(trace.u).max() <= 1.5
    np.testing.assert_array_equal(trace.u[3], (0, 0))  # a stop is never slowed down
    np.testing.assert_allclose(seen[1:], trace.u[:-1])
    with pytest.raises(TypeError, match="limits"):
        experiment(motors, limits=3)
