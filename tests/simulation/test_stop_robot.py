"""`Experiment.stop_robot`: from any thread, at once, in a run and between two."""

import queue
import threading

import numpy as np
import pytest

import robsim
from python_motors import Sender
from robsim.lab import HaltedError, MotorReceiver, UdpMotors
from threads import in_thread
from waiting import wait_for

pytestmark = pytest.mark.threads

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
