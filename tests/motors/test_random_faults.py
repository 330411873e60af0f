"""A sender that ends at a random moment, in a random way: the robot stands within its time."""

import os
import random
import signal
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor

import pytest

import sanitizers
from robsim._core import Watchdog
from robsim.motors import LineError, MotorReceiver, SerialMotors, UdpMotors
from sizes import thorough
from waiting import wait_for

pytestmark = [
    pytest.mark.slow,
    pytest.mark.threads,
    pytest.mark.skipif(not hasattr(os, "openpty"), reason="needs pseudo-terminals"),
]

ROUNDS = thorough(200, 48)
TTL = 0.1  # s

SENDER = """
import sys, time
from robsim.motors import UdpMotors
motors = UdpMotors("127.0.0.1", int(sys.argv[1]), ttl=0.1, hold=1000)
print("drives", flush=True)
while True:
    motors((1, 2))
    time.sleep(0.003)
"""


def kinds(thing):
    return [event.kind for event in thing.events]


def stands(robot):
    """It stands: by its own clock within the time to live of what it heard last."""
    events = wait_for(lambda: (events := robot.events)[-1].kind != "input" and events)
    last = max((event.t for event in events if event.kind == "input"), default=events[0].t)
    assert robot.mean(last + TTL, last + TTL + 100).tolist() == [0, 0]
    assert robot.input.tolist() == [0, 0]


def drive_for(motors, seconds):
    motors((1, 2))
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        motors((1, 2))


def stopped(motors, rng):
    motors.stop()


def closed(motors, rng):
    motors.close()


def failed(motors, rng):
    with pytest.raises(KeyError), motors:
        raise KeyError


def starved(motors, rng):
    watchdog = Watchdog(motors)
    watchdog.arm(rng.uniform(0.001, 0.05))
    wait_for(lambda: motors.is_halted)


def dropped(motors, rng):
    """The only reference to it goes with the call."""


def silent(motors, rng):
    wait_for(lambda: "stop" in kinds(motors))


def in_parallel(one_round, rounds):
    with ThreadPoolExecutor(8) as pool:
        list(pool.map(lambda k: one_round(random.Random(k)), range(rounds)))


def end_over_udp(rng):
    with MotorReceiver() as robot:
        motors = UdpMotors("127.0.0.1", robot.port, ttl=TTL, hold=0.05)
        drive_for(motors, rng.uniform(0, 0.03))
        end = rng.choice([stopped, closed, failed, starved, dropped, silent])
        end(motors, rng)
        del motors
        try:
            wait_for(lambda: robot.counts.valid)
            stands(robot)
        except AssertionError as error:
            error.add_note(f"{end.__name__}: {robot.events[-5:]}")
            raise


def cut_cable(rng):
    master, slave = os.openpty()
    with MotorReceiver(descriptor=master) as robot:
        motors = SerialMotors(os.ttyname(slave), ttl=TTL, hold=1000)
        drive_for(motors, rng.uniform(0.005, 0.03))
        wait_for(lambda: robot.counts.valid > 0)
        robot.close()  # it hears no more, and the line has no other end
        os.close(master)
        wait_for(lambda: "failure" in kinds(motors))
        with pytest.raises(LineError):
            motors((1, 2))
        with pytest.raises(LineError):
            motors.close()
        os.close(slave)
        last = robot.events[-1].t
        assert robot.mean(last + TTL, last + TTL + 100).tolist() == [0, 0]


def kill_a_process(rng):
    with MotorReceiver() as robot:
        process = subprocess.Popen(
            [sys.executable, "-c", SENDER, str(robot.port)], stdout=subprocess.PIPE, text=True
        )
        with process:
            process.stdout.readline()
            n = rng.randrange(1, 20)
            wait_for(lambda: robot.counts.valid > n)
            process.send_signal(rng.choice([signal.SIGKILL, signal.SIGTERM, signal.SIGABRT]))
            process.wait()
        *_, last, end = wait_for(lambda: (e := robot.events)[-1].kind == "timeout" and e)
        assert end.t == pytest.approx(last.t + TTL, abs=1e-9)
        stands(robot)


def test_whatever_ends_a_sender_over_udp():
    in_parallel(end_over_udp, ROUNDS)


def test_a_cable_that_is_cut():
    pytest.importorskip("serial")
    in_parallel(cut_cable, ROUNDS // 4)


@pytest.mark.skipif(sanitizers.THREAD, reason="its processes start slowly")
def test_a_process_that_is_killed():
    in_parallel(kill_a_process, thorough(5, 3))
