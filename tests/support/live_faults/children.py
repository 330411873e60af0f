"""Rounds in a process of their own, which ends in the middle of a run; and that process."""

import faulthandler
import json
import multiprocessing
import os
import random
import signal
import subprocess
import sys
import tempfile
import threading
import time
from contextlib import nullcontext
from pathlib import Path

import numpy as np

import gige_cameras
import robsim
from robsim.trace import Session
from waiting import keep_interpreter, wait_for

from . import cameras, robots, wired
from .rounds import Checked, input_of, inputs_of

LOST_AT_MOST = 1.0  # s, of a session that is killed
HARD_LIMIT = 300  # s
STOPPED = 0.8  # s
EVERY = 4  # each so many rounds one is in a process of its own


def fail():
    raise ZeroDivisionError("of the fault")


def fork():
    multiprocessing.get_context("fork").Process(target=time.sleep, args=(2,)).start()


KILLED = ("time to live", -signal.SIGKILL, "")
INTERRUPTED = ("at once", -signal.SIGINT, "KeyboardInterrupt")
#: name -> (by when the robot must stand, exit code, what the last line of stderr begins with, what
#: a callback does)
ENDS = {
    "SIGKILL": KILLED,
    "SIGTERM": ("time to live", -signal.SIGTERM, ""),
    "abort()": ("time to live", -signal.SIGABRT, "", os.abort),
    "_exit()": ("time to live", 7, "", lambda: os._exit(7)),
    "SIGKILL, a fork lives on": (*KILLED, fork),
    "SIGKILL, interpreter held": (
        "time to live",
        -signal.SIGKILL,
        "",
        lambda: keep_interpreter(300),
    ),
    "SIGKILL after step()": KILLED,
    "stopped, child's SIGINT": INTERRUPTED,
    "child's SIGINT": INTERRUPTED,
    "child's SIGINT after step()": INTERRUPTED,
    "sys.exit()": ("at once", 5, "", lambda: sys.exit(5)),
    "end after step()": ("at once", 0, ""),
    "end beside a run": ("at once", 0, ""),
    "error in callback": ("at once", 1, "ZeroDivisionError", fail),
}


def is_turn(number):
    return number % EVERY == EVERY - 1


class ChildRound(Checked):
    """What the parent does: the robot's end of the line, and the camera if it is served."""

    def __init__(self, number, seed, slack, kinds):
        super().__init__(f"child {seed} {number}", slack)
        rng = self.rng
        self.end = list(ENDS)[number // EVERY % len(ENDS)]
        self.promise, self.code, self.last_line, *_ = ENDS[self.end]
        self.camera_kind = rng.choice([kind for kind in kinds if kind != "file"])
        is_native = self.promise == "time to live"
        self.motors_kind = rng.choice(robots.NATIVE if is_native else robots.KINDS)
        self.is_recorded, self.has_with = rng.random() < 0.6, rng.random() < 0.5
        self.delay = rng.uniform(0, 0.8)
        self.title = f"process: {self.end}"
        self.kind = f"{self.camera_kind}, {self.motors_kind}{', recorded' * self.is_recorded}"

    def run(self, folder):
        session = Path(folder, "session") if self.is_recorded else None
        robot = robots.Robot(self.motors_kind)
        try:
            with self.served() as camera:
                self.run_child(session, robot, camera or wired.Shown())
            wait_for(lambda: not robot.drives())
            due = self.happened + robots.TTL * (self.promise == "time to live")
            self.late = robot.stood() - due  # it drove
            self.check(self.late <= self.slack, f"it stood {self.late:.3f} s too late")
            if self.is_recorded:
                self.check_session(Session(session), robot)
        finally:
            robot.close()

    def served(self):
        """The camera that this process shows to the child, if it does."""
        if self.camera_kind in wired.CAN:
            return wired.served(self.camera_kind, self.rng)
        return cameras.http_server(self.rng) if self.camera_kind == "http" else nullcontext()

    def run_child(self, session, robot, camera):
        told = {
            "end": self.end, "k": self.rng.randrange(2, 20), "camera": self.camera_kind,
            "url": camera.url, "area": camera.area, "motors": self.motors_kind,
            "address": robot.address, "record": session and str(session),
            "has_with": self.has_with, "seed": self.rng.randrange(1000),
        }  # fmt: skip
        command = [sys.executable, "-W", "ignore", "-m", "live_faults.children", json.dumps(told)]
        with tempfile.TemporaryFile("w+") as errors:
            pipes = {"stdout": subprocess.PIPE, "stderr": errors, "text": True}
            with subprocess.Popen(command, env=camera.environment, **pipes) as process:
                watch = threading.Timer(HARD_LIMIT, process.kill)
                watch.start()
                drives = process.stdout.readline()
                names = [word.strip(",") for word in self.end.split() if word.startswith("SIG")]
                if drives and names:
                    self.send(process, getattr(signal, names[0]))
                elif drives:
                    self.happened = float(process.stdout.readline() or "nan")
                process.wait()
                self.check(watch.is_alive(), "the child hung")
                watch.cancel()
                watch.join()
            errors.seek(0)
            self.check_end(process.returncode, errors.read())

    def send(self, process, number):
        time.sleep(self.delay)
        if "stopped" in self.end:  # nobody takes frames meanwhile: those that wait are overrun
            process.send_signal(signal.SIGSTOP)
            time.sleep(STOPPED)
            process.send_signal(signal.SIGCONT)
            time.sleep(self.delay)
        self.happened = time.monotonic()
        process.send_signal(number)

    def check_end(self, code, said):
        lines = said.strip().splitlines()
        text = f"exit code {code}, not {self.code}, or it said too much: {said[-3000:]}"
        is_right = code == self.code and said.count("Traceback") <= 1
        if self.end == "end beside a run":  # a run that is cut off may tell of it
            is_right &= "terminate" not in said
        else:
            is_right &= bool(lines) == bool(self.last_line) and "Exception ignored" not in said
            is_right &= any(line.startswith(self.last_line) for line in ["", *lines][-2:])
        self.check(is_right, text)

    def check_session(self, session, robot):
        sent = {round(u1, 4): t for t, u1, u2 in robot.heard() if u1 or u2}
        times = [sent.get(round(u1, 4)) for u1, _ in inputs_of(4000)]
        last = max((k for k, t in enumerate(times) if t is not None), default=-1)
        before = self.happened - LOST_AT_MOST - self.slack
        must = sum(t is not None and t < before for t in times)
        n = session.count
        self.check(must <= n <= last + 2, f"the session has {n} steps of {last + 1}, not {must}")
        self.check(np.array_equal(session.trace.u, inputs_of(n)), "inputs of the session")
        self.check_frames(session)
        if self.promise == "at once" and self.has_with:
            wrong = [text for text in session.problems if "left out" not in text]
            self.check(not wrong, f"the session says: {wrong}")


# The child.


def say():
    print(time.monotonic(), flush=True)


def main(told):
    faulthandler.dump_traceback_later(HARD_LIMIT - 5)
    signal.signal(signal.SIGINT, signal.default_int_handler)

    def control(step):
        if step.k == told["k"] and len(ENDS[told["end"]]) > 3:
            if "SIG" not in told["end"]:
                say()
            ENDS[told["end"]][3]()
        if step.k == 1:
            print("drives", flush=True)
        return input_of(step.k)

    if told["url"]:
        frames = gige_cameras.opened(told["url"], area=told["area"])
    else:
        opened = cameras.camera_of(told["camera"], random.Random(told["seed"]))
        frames = opened.__enter__().frames
    experiment = robsim.Experiment(
        frames,
        send=robots.motors_at(told["motors"], told["address"]),
        frame_timeout=300,
        area=(300, 300) if told["camera"] == "generator" else None,
        control=control,
        record=told["record"],
    )
    with experiment if told["has_with"] else nullcontext():
        drive(told, experiment)


def drive(told, experiment):
    if "step()" in told["end"]:
        while experiment.n_steps < max(told["k"], 3):
            experiment.step()
        while told["end"] != "end after step()":  # a signal just before a sleep does not end it
            time.sleep(0.1)
        say()
    elif told["end"] == "end beside a run":
        threading.Thread(target=experiment.run, args=(3000,), daemon=True).start()
        while experiment.n_steps < told["k"]:
            time.sleep(0.001)
        say()
    else:
        experiment.run(3000)


if __name__ == "__main__":
    main(json.loads(sys.argv[1]))
