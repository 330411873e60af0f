"""Rounds in a process of their own, which ends in the middle of a run; and that process."""

import faulthandler
import json
import multiprocessing
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
import traceback
from contextlib import nullcontext
from pathlib import Path

import numpy as np

import gige_cameras
import robsim
from interpreter import keep_interpreter
from robsim.sessions import Session
from waiting import wait_for

from . import cameras, robots, wired
from .rounds import input_of

LOST_AT_MOST = 1.0  # s, of a session that is killed
HARD_LIMIT = 300  # s
STOPPED = 0.8  # s
EVERY = 4  # each so many rounds one is in a process of its own

#: name -> (by when the robot must stand, exit code, what the last line of stderr begins with)
ENDS = {
    "SIGKILL": ("time to live", -signal.SIGKILL, ""),
    "SIGTERM": ("time to live", -signal.SIGTERM, ""),
    "abort()": ("time to live", -signal.SIGABRT, ""),
    "_exit()": ("time to live", 7, ""),
    "SIGKILL, a fork lives on": ("time to live", -signal.SIGKILL, ""),
    "SIGKILL, interpreter held": ("time to live", -signal.SIGKILL, ""),
    "SIGKILL after step()": ("time to live", -signal.SIGKILL, ""),
    "stopped, child's SIGINT": ("at once", -signal.SIGINT, "KeyboardInterrupt"),
    "child's SIGINT": ("at once", -signal.SIGINT, "KeyboardInterrupt"),
    "child's SIGINT after step()": ("at once", -signal.SIGINT, "KeyboardInterrupt"),
    "sys.exit()": ("at once", 5, ""),
    "end after step()": ("at once", 0, ""),
    "end beside a run": ("at once", 0, ""),
    "error in callback": ("at once", 1, "ZeroDivisionError"),
}


def is_turn(number):
    return number % EVERY == EVERY - 1


class ChildRound:
    """What the parent does: the robot's end of the line, and the camera if it is served."""

    def __init__(self, number, seed, slack, kinds):
        self.rng = rng = random.Random(f"child {seed} {number}")
        self.slack, self.failures = slack, []
        self.end = list(ENDS)[number // EVERY % len(ENDS)]
        self.promise, self.code, self.last_line = ENDS[self.end]
        self.camera_kind = rng.choice([kind for kind in kinds if kind != "file"])
        fits = robots.NATIVE if self.promise == "time to live" else ("udp", "serial", "python")
        self.motors_kind = rng.choice(fits)
        self.is_recorded = rng.random() < 0.6
        self.has_with = rng.random() < 0.5
        self.delay = rng.uniform(0, 0.8)
        self.late = None

    def run(self, folder):
        robot = robots.LineRobot(self.motors_kind)
        try:
            with self.served() as camera:
                self.run_child(folder, robot, camera)
            self.check_stop(robot)
            if self.is_recorded:
                self.check_session(Path(folder, "session"), robot)
        finally:
            robot.close()

    def served(self):
        """The camera that this process shows to the child, if it does."""
        if self.camera_kind in wired.KINDS:
            return wired.served(self.camera_kind, self.rng)
        is_http = self.camera_kind == "http"
        return cameras.http_server(self.rng) if is_http else nullcontext()

    def run_child(self, folder, robot, camera):
        told = {
            "end": self.end,
            "k": self.rng.randrange(2, 20),
            "camera": self.camera_kind,
            "url": camera and camera.url,
            "area": camera and camera.area,
            "motors": self.motors_kind,
            "address": robot.address,
            "record": str(Path(folder, "session")) if self.is_recorded else None,
            "has_with": self.has_with,
            "seed": self.rng.randrange(1000),
        }
        command = [sys.executable, "-W", "ignore", "-m", "live_faults.children", json.dumps(told)]
        with tempfile.TemporaryFile("w+") as errors:
            process = subprocess.Popen(
                command,
                stdout=subprocess.PIPE,
                stderr=errors,
                text=True,
                env=camera and camera.environment,
            )
            watch = threading.Timer(HARD_LIMIT, process.kill)
            watch.start()
            said = process.stdout.readline()
            if said and (number := self.signal()):
                time.sleep(self.delay)
                if "stopped" in self.end:
                    self.hold_for_a_while(process)
                self.happened = time.monotonic()
                process.send_signal(number)
            elif said:
                said = process.stdout.readline()
                self.happened = float(said or "nan")
            process.wait()
            if not watch.is_alive():
                self.failures.append("the child hung")
            watch.cancel()
            watch.join()
            process.stdout.close()
            errors.seek(0)
            self.check_end(process.returncode, errors.read())

    def hold_for_a_while(self, process):
        """Nobody takes frames meanwhile: those that wait are overrun."""
        process.send_signal(signal.SIGSTOP)
        time.sleep(STOPPED)
        process.send_signal(signal.SIGCONT)
        time.sleep(self.delay)

    def signal(self):
        """The signal that the parent sends, if it does."""
        names = [word.strip(",") for word in self.end.split() if word.startswith("SIG")]
        return getattr(signal, names[0]) if names else None

    def check_end(self, code, said):
        lines = said.strip().splitlines()
        if code != self.code:
            self.failures.append(f"exit code {code}, not {self.code}: {said[-3000:]}")
        elif self.end == "end beside a run":  # a run that is cut off may tell of it
            if "terminate" in said or said.count("Traceback") > 1:
                self.failures.append(f"it said {said[-3000:]}")
        elif bool(lines) != bool(self.last_line) or not any(
            line.startswith(self.last_line) for line in ["", *lines][-2:]
        ):
            self.failures.append(f"it said {said[-3000:]}")
        elif said.count("Traceback") > 1 or "Exception ignored" in said:
            self.failures.append(f"it said more than the error: {said[-3000:]}")

    def check_stop(self, robot):
        wait_for(lambda: not robot.heard() or not any(robot.heard()[-1][1:]))
        heard = robot.heard()
        driving = [i for i, (_, *u) in enumerate(heard) if any(u)]
        if not driving:
            self.failures.append("it never drove")
            return
        due = self.happened + (robots.TTL if self.promise == "time to live" else 0)
        self.late = heard[driving[-1] + 1][0] - due
        if not self.late <= self.slack:
            self.failures.append(f"it stood {self.late:.3f} s too late")

    def check_session(self, folder, robot):
        session = Session(folder)
        sent = {round(u1, 4): t for t, u1, u2 in robot.heard() if u1 or u2}
        n = session.count
        last = max((k for k in range(4000) if round(input_of(k)[0], 4) in sent), default=-1)
        must = sum(
            round(input_of(k)[0], 4) in sent
            and sent[round(input_of(k)[0], 4)] < self.happened - LOST_AT_MOST - self.slack
            for k in range(last + 1)
        )
        if not must <= n <= last + 2:
            self.failures.append(f"the session has {n} steps of {last + 1}, at least {must}")
        wanted = np.array([input_of(k) for k in range(n)]).reshape(-1, 2)
        if not np.array_equal(session.trace.u, wanted):
            self.failures.append("the inputs of the session are not those that were sent")
        seen = sum(observation.frame is not None for observation in session)
        left_out = sum(bool(row.left_out) for row in session._rows)
        if seen + left_out != n:
            self.failures.append(f"{seen} frames, {left_out} left out, of {n} steps")
        if self.promise == "at once":
            wrong = [text for text in session.problems if "left out" not in text]
            if wrong and self.has_with:
                self.failures.append(f"the session says: {wrong}")


def play(number, seed, slack, kinds=cameras.SOFTWARE):
    """Run a round with a child and a camera of these kinds; return what a line needs."""
    made = ChildRound(number, seed, slack, kinds)
    start, folder = time.monotonic(), tempfile.mkdtemp()
    try:
        made.run(folder)
    except BaseException:
        made.failures.append(traceback.format_exc())
    shutil.rmtree(folder)
    kind = f"{made.camera_kind}, {made.motors_kind}{', recorded' * made.is_recorded}"
    return {
        "round": number,
        "fault": f"process: {made.end}",
        "kind": kind,
        "late": made.late,
        "failures": made.failures,
        "seconds": time.monotonic() - start,
    }


# The child.


def say():
    print(time.monotonic(), flush=True)


def end_by_itself(end):
    """End the process from within a callback, if it ends so."""
    if end == "SIGKILL, interpreter held":
        keep_interpreter(cameras.LONG)
    if end == "SIGKILL, a fork lives on":
        multiprocessing.get_context("fork").Process(target=time.sleep, args=(2,)).start()
    if end in ("abort()", "_exit()", "sys.exit()", "error in callback"):
        say()
    if end == "abort()":
        os.abort()
    if end == "_exit()":
        os._exit(7)
    if end == "sys.exit()":
        sys.exit(5)
    if end == "error in callback":
        raise ZeroDivisionError("of the fault")


def main(told):
    faulthandler.dump_traceback_later(HARD_LIMIT - 5)
    signal.signal(signal.SIGINT, signal.default_int_handler)
    rng = random.Random(told["seed"])

    def control(step):
        if step.k == told["k"]:
            end_by_itself(told["end"])
        if step.k == 1:
            print("drives", flush=True)
        return input_of(step.k)

    if told["url"]:
        frames = gige_cameras.opened(told["url"], area=told["area"])
    else:
        made = cameras.MADE[told["camera"]](rng)
        frames = made.__enter__().frames
    robot = robots.LineRobot.__new__(robots.LineRobot)
    robot.kind, robot.address = told["motors"], told["address"]
    motors = robot.motors()
    experiment = robsim.Experiment(
        frames,
        send=motors,
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
        if told["end"] == "end after step()":
            say()
        else:
            while True:  # a signal that comes just before a sleep does not end it
                time.sleep(0.1)
    elif told["end"] == "end beside a run":
        threading.Thread(target=experiment.run, args=(3000,), daemon=True).start()
        while experiment.n_steps < told["k"]:
            time.sleep(0.001)
        say()
    else:
        experiment.run(3000)


if __name__ == "__main__":
    main(json.loads(sys.argv[1]))
