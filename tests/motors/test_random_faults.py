"""A sender that ends at a random moment, in a random way: the robot stands within its time."""

import random
import sys
import time
from concurrent.futures import ThreadPoolExecutor

import pytest

from robsim._core import Watchdog
from robsim.motors import MotorReceiver, UdpMotors
from sizes import thorough
from waiting import wait_for

pytestmark = [
    pytest.mark.slow,
    pytest.mark.threads,
    pytest.mark.skipif(sys.platform == "win32", reason="made for Linux and macOS"),
]

TTL = 0.1  # s


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


def test_whatever_ends_a_sender_over_udp():
    with ThreadPoolExecutor(8) as pool:
        list(pool.map(lambda k: end_over_udp(random.Random(k)), range(thorough(200, 48))))
