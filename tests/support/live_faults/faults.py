"""What goes wrong in a round, when, and by when the robot must stand."""

import atexit
import gc
import os
import resource
import signal
import time
import warnings
from collections.abc import Callable
from dataclasses import dataclass

from robsim.lab import CaptureError, LineError
from waiting import keep_interpreter, wait_for

from . import cameras, robots, wired


class OddError(BaseException):
    """An exception that `except Exception` does not see."""


@dataclass(frozen=True)
class Fault:
    """`act(round)` is called in a callback, or, if it may come at `any_time`, in another thread.

    `stands`: "at once", by the "watchdog" (frame_timeout after the newest frame that was taken), by
    its own "time to live" (of the link) since the fault, or it "goes on" to the last step.
    """

    name: str
    act: Callable
    errors: tuple = ()
    stands: str = "at once"
    cameras: tuple = tuple(cameras.CAN)
    motors: tuple = robots.KINDS
    any_time: bool = False
    must_raise: bool = False
    is_cut: bool = False
    is_recorded: bool = False
    time_limit: float | None = None
    drive: Callable | None = None


def raising(name, error):
    def act(made):
        raise error

    return Fault(name, act, (type(error),), must_raise=True)


def hold(made):
    keep_interpreter(made.frame_timeout + 0.3)
    made.marks["returned"] = time.monotonic()


def fall_asleep(made):
    time.sleep(made.frame_timeout + 0.3)


def ctrl_c(made):
    os.kill(os.getpid(), signal.SIGINT)


def close_motors(made):
    made.motors.close()


def close_camera(made):
    made.camera.frames.close()


def never_end(made):
    end = time.monotonic() + cameras.LONG
    while time.monotonic() < end:
        pass
    raise AssertionError("time_limit did not end a callback")


def fail_to_send(count):
    def act(made):
        motors = made.motors
        motors.error = made.rng.choice(SEND_ERRORS)
        motors.failing = range(motors.calls + 1, motors.calls + 1 + count)

    return act


def fork(made):
    """A child that ends as an interpreter does, or at once, must not touch the robot."""
    is_polite = made.rng.random() < 0.5
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        child = os.fork()
    if child == 0:
        try:
            if is_polite:
                atexit._run_exitfuncs()
        finally:
            os._exit(0)
    wait_for(lambda: os.waitpid(child, os.WNOHANG) != (0, 0))


def fill_disk(made):
    _, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (made.rng.choice([0, 1000, 100_000]), hard))


def step_and_leave(made):
    """After some steps nobody comes back."""
    for _ in range(made.k + 1):
        made.experiment.step()
    made.marks[made.faults[0].name] = time.monotonic()


def step_and_drop(made):
    """A program forgets all that drives."""
    step_and_leave(made)
    made.experiment = None
    if made.motors_kind in robots.NATIVE:
        made.motors = None
    gc.collect()


def nothing(made):
    pass


def at_any_time(name, act, errors=(), stands="at once", **more):
    return Fault(name, act, errors, stands, any_time=True, **more)


def of_camera(how, errors, stands="watchdog"):
    kinds = tuple(kind for kind, can in cameras.CAN.items() if how in can)
    act = lambda made: made.camera.go_wrong(how)  # noqa: E731
    return at_any_time(f"camera: {how}", act, errors, stands, cameras=kinds)


def cut_line(name, is_silent):
    act = lambda made: made.robot.cut(is_silent)  # noqa: E731
    more = {"is_cut": True, "motors": robots.NATIVE}
    return at_any_time(name, act, (LineError,), "time to live", **more)


SEND_ERRORS = (OSError, SystemExit, KeyboardInterrupt, OddError)
CLOSED_BY_HAND = ("lab", "http", "file", *wired.CAN)
OF_PYTHON = {"motors": ("python",)}

#: A round has that of its number: who adds one in between moves the others.
FAULTS = (
    raising("exception", ZeroDivisionError("of the fault")),
    raising("odd exception", OddError("of the fault")),
    raising("SystemExit", SystemExit(3)),
    raising("KeyboardInterrupt", KeyboardInterrupt()),
    Fault("holds interpreter", hold, (TimeoutError,), "watchdog", must_raise=True),
    Fault("sleeps", fall_asleep, (TimeoutError,), "watchdog", must_raise=True),
    Fault("endless", never_end, (TimeoutError,), "watchdog", time_limit=1.2, must_raise=True),
    Fault("fork", fork, (), "goes on"),
    at_any_time("SIGINT", ctrl_c, (KeyboardInterrupt,), must_raise=True),
    at_any_time("stop()", lambda made: made.experiment.stop()),
    at_any_time("motors closed", close_motors, (LineError,), motors=robots.NATIVE),
    at_any_time("camera closed", close_camera, (ValueError,), cameras=CLOSED_BY_HAND),
    cut_line("line cut", is_silent=False),
    cut_line("line silent", is_silent=True),
    at_any_time("send fails once", fail_to_send(1), SEND_ERRORS, **OF_PYTHON),
    at_any_time("send fails thrice", fail_to_send(3), SEND_ERRORS, **OF_PYTHON),
    at_any_time("disk full", fill_disk, (), "goes on", is_recorded=True),
    of_camera("stall", (TimeoutError,)),
    of_camera("unplug", (CaptureError,)),
    of_camera("torn", (TimeoutError, CaptureError)),
    of_camera("size", (CaptureError, ValueError)),
    of_camera("dead server", (CaptureError,)),
    of_camera("raises", (ZeroDivisionError,)),
    of_camera("ends", ()),
    of_camera("order", (ValueError,)),
    of_camera("plugged in again", (CaptureError,)),
    of_camera("server starts anew", (CaptureError,)),
    of_camera("bus reset", (), "goes on"),
    of_camera("bus loses power", ()),
    of_camera("no channel", (CaptureError,)),
    of_camera("no bandwidth", (CaptureError,)),
    Fault("file ends", nothing, (), "watchdog", cameras=("file",)),
    Fault("last step", nothing, (), "goes on"),
    Fault("left after step()", nothing, (), "watchdog", drive=step_and_leave),
    Fault("dropped after step()", nothing, (), drive=step_and_drop),
)
