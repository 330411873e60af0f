"""What goes wrong in a round, when, and by when the robot must stand."""

import atexit
import gc
import os
import resource
import signal
import threading
import time
import warnings
from collections.abc import Callable
from dataclasses import dataclass

from interpreter import keep_interpreter
from robsim.capture import CaptureError
from robsim.motors import LineError

from . import cameras, robots, wired


class OddError(BaseException):
    """An exception that `except Exception` does not see."""


@dataclass(frozen=True)
class Fault:
    """`act(round)` is called in a callback, or in a thread of its own: see `may_come_any_time`.

    `stands`: "at once", by the "watchdog" (frame_timeout after the newest frame that was taken), by
    its own "time to live" (of the link) since the fault, "after" a callback that holds the
    interpreter, or it "goes on" to the last step. `stands_in_python`: if `send` needs Python.
    """

    name: str
    act: Callable
    errors: tuple = ()
    stands: str = "at once"
    stands_in_python: str | None = None
    cameras: tuple = cameras.KINDS
    motors: tuple = robots.KINDS
    is_cut: bool = False
    is_recorded: bool | None = None
    time_limit: float | None = None
    drive: Callable | None = None

    def promise(self, motors):
        return (motors not in robots.NATIVE and self.stands_in_python) or self.stands


def raising(error):
    def act(made):
        raise error

    return act


def hold(made):
    keep_interpreter(made.frame_timeout + 0.3)
    made.marks["returned"] = time.monotonic()


def fall_asleep(made):
    time.sleep(made.frame_timeout + 0.3)


def never_end(made):
    end = time.monotonic() + cameras.LONG
    while time.monotonic() < end:
        pass
    raise AssertionError("time_limit did not end a callback")


def ctrl_c(made):
    os.kill(os.getpid(), signal.SIGINT)


def stop(made):
    made.experiment.stop()


def close_motors(made):
    made.motors.close()


def close_camera(made):
    made.camera.frames.close()


def cut_silently(made):
    made.robot.cut(is_silent=True)


def cut(made):
    made.robot.cut(is_silent=False)


def fail_to_send(count):
    def act(made):
        motors = made.motors
        motors.error = made.rng.choice([OSError, SystemExit, KeyboardInterrupt, OddError])
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
    end = time.monotonic() + cameras.LONG
    while os.waitpid(child, os.WNOHANG) == (0, 0):
        if time.monotonic() > end:
            os.kill(child, signal.SIGKILL)
            os.waitpid(child, 0)
            made.failures.append("a forked child hung")
            return
        time.sleep(0.001)


def fill_disk(made):
    _, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (made.rng.choice([0, 1000, 100_000]), hard))


def step_and_leave(made):
    """After some steps nobody comes back."""
    for _ in range(made.k + 1):
        made.experiment.step()
    made.marks[made.faults[0].name] = time.monotonic()


def step_and_drop(made):
    step_and_leave(made)
    made.drop()
    gc.collect()


def nothing(made):
    pass


IN_CALLBACK = (
    Fault("exception", raising(ZeroDivisionError("of the fault")), (ZeroDivisionError,)),
    Fault("odd exception", raising(OddError("of the fault")), (OddError,)),
    Fault("SystemExit", raising(SystemExit(3)), (SystemExit,)),
    Fault("KeyboardInterrupt", raising(KeyboardInterrupt()), (KeyboardInterrupt,)),
    Fault("holds interpreter", hold, (TimeoutError,), "watchdog", "after"),
    Fault("sleeps", fall_asleep, (TimeoutError,), "watchdog"),
    Fault("endless", never_end, (TimeoutError,), "watchdog", time_limit=1.2),
    Fault("fork", fork, (), "goes on"),
)

ANY_TIME = (
    Fault("SIGINT", ctrl_c, (KeyboardInterrupt,)),
    Fault("stop()", stop),
    Fault("motors closed", close_motors, (LineError,), motors=(*robots.NATIVE, "recorded")),
    Fault(
        "camera closed", close_camera, (ValueError,), cameras=("lab", "http", "file", *wired.KINDS)
    ),
    Fault("line cut", cut, (LineError,), "time to live", motors=robots.NATIVE, is_cut=True),
    Fault(
        "line silent", cut_silently, (LineError,), "time to live", motors=robots.NATIVE, is_cut=True
    ),
    Fault(
        "send fails once",
        fail_to_send(1),
        (OSError, SystemExit, KeyboardInterrupt, OddError),
        motors=("python",),
    ),
    Fault(
        "send fails thrice",
        fail_to_send(3),
        (OSError, SystemExit, KeyboardInterrupt, OddError),
        motors=("python",),
    ),
    Fault("disk full", fill_disk, (), "goes on", is_recorded=True),
)


def of_camera(how, errors, stands="watchdog"):
    return Fault(
        f"camera: {how}",
        lambda made: made.camera.go_wrong(how),
        errors,
        stands,
        cameras=tuple(kind for kind, can in cameras.CAN.items() if how in can),
    )


OF_CAMERAS = (
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
    of_camera("bus loses power", (), "watchdog"),
    of_camera("no channel", (CaptureError,)),
    of_camera("no bandwidth", (CaptureError,)),
)

ENDS = (
    Fault("file ends", nothing, (), "watchdog", cameras=("file",)),
    Fault("last step", nothing, (), "goes on"),
    Fault("left after step()", nothing, (), "watchdog", drive=step_and_leave),
    Fault("dropped after step()", nothing, (), drive=step_and_drop),
)


def may_come_any_time(fault):
    return fault in ANY_TIME or fault in OF_CAMERAS


FAULTS = (*IN_CALLBACK, *ANY_TIME, *OF_CAMERAS, *ENDS)


def with_cameras(kinds):
    """Return the faults that can be had with these kinds of cameras."""
    return [fault for fault in FAULTS if set(fault.cameras) & set(kinds)]


class LaterFault(threading.Thread):
    """Lets something happen after a while, unless the round is over."""

    def __init__(self, seconds, act):
        super().__init__(name="fault", daemon=True)
        self._seconds, self._act = seconds, act
        self._is_over = threading.Event()
        self.start()

    def run(self):
        if not self._is_over.wait(self._seconds):
            self._act()

    def end(self):
        self._is_over.set()
        self.join()
