"""Code for campaigns in other processes, which has to lie in a module."""

import multiprocessing
import os
import signal
import time
from concurrent.futures import Executor, Future
from pathlib import Path

from waiting import wait_for


def final(trace):
    """Where the robot is at the end."""
    return {"x": trace.pose_true[-1, 0], "y": trace.pose_true[-1, 1]}


def run_of(trace):
    return trace.info.seed["spawn_key"][-1]


class Faster:
    """A controller with a memory: it drives faster from step to step."""

    def __init__(self):
        self.steps = 0

    def __call__(self, step):
        self.steps += 1
        return 0.01 * self.steps, 0.3


def steady(step):
    return 0.4, 0.3


def failing_in_some(trace):
    """Fail in every seventh run."""
    if run_of(trace) % 7 == 3:
        raise ZeroDivisionError("it is one of these")
    return run_of(trace)


def kill_itself():
    if multiprocessing.parent_process() is not None:  # not the tests
        os.kill(os.getpid(), signal.SIGKILL)


def killed_once(trace):
    """Kill the process in run 17, once."""
    once = Path(os.environ["ROBSIM_TEST_FOLDER"], "killed")
    if run_of(trace) == 17 and not once.exists():
        once.touch()
        kill_itself()
    return run_of(trace)


def deadly(trace):
    """Kill the process: in run 17 once, in run 33 always."""
    killed_once(trace)
    if run_of(trace) == 33:
        kill_itself()
    return run_of(trace)


def slow_with_pid(trace):
    """Leave a file with the number of the process, and take a while; run 70 waits for "go"."""
    folder = Path(os.environ["ROBSIM_TEST_FOLDER"])
    (folder / f"{os.getpid()}.pid").touch()
    time.sleep(0.02)
    if run_of(trace) == 70:
        wait_for((folder / "go").exists)
    return run_of(trace)


class Inline(Executor):
    """An executor of somebody else: it does all at once, when it is asked to."""

    def submit(self, function, /, *args, **options):
        future = Future()
        try:
            future.set_result(function(*args, **options))
        except BaseException as error:
            future.set_exception(error)
        return future
