"""One round in this process, and what must hold after it."""

import gc
import os
import random
import resource
import shutil
import tempfile
import threading
import time
import traceback
import warnings
from contextlib import ExitStack, suppress
from pathlib import Path

import numpy as np

import robsim
from robsim.sessions import Session

from . import cameras, faults, robots

STAGES = ("estimate_parameters", "measure", "estimate_state", "control")
STEPS = 25  # of a run that nothing ends before
LAST_FAULT = 14  # step
SOON = 300  # s, for what needs no time but may be held up


def input_of(k):
    """Another one for each step, so that what is heard says of which step it is."""
    return 0.5 + 0.001 * k, 0.25


class Round:
    """A live run, with one or two faults."""

    def __init__(self, number, seed, slack, kinds):
        self.rng = random.Random(f"{seed} {number}")
        self.slack = slack
        self.failures = []
        self.marks = {}  # when each fault happened
        self.newest = None  # arrival of the newest frame that was taken
        self.decided = 0
        self.error = None
        self._choose(number, kinds)

    def _choose(self, number, kinds):
        rng = self.rng
        those = faults.with_cameras(kinds)
        first = those[number % len(those)]
        self.faults = [first]
        self.camera_kind = rng.choice([kind for kind in first.cameras if kind in kinds])
        self.motors_kind = rng.choice(first.motors)
        self.is_recorded = rng.random() < 0.5 if first.is_recorded is None else first.is_recorded
        if first.drive is None and rng.random() < 0.25:
            fits = [
                fault
                for fault in faults.FAULTS
                if self.camera_kind in fault.cameras
                and self.motors_kind in fault.motors
                and not (fault.is_recorded and not self.is_recorded)
                and not (fault.is_cut and first.is_cut)
                and fault.drive is None
                and fault.act is not faults.nothing
            ]
            self.faults.append(rng.choice(fits))
        self.frame_timeout = rng.choice([0.4, 0.7])
        self.k = rng.randrange(1, LAST_FAULT)
        stages = [stage for stage in STAGES if stage != "estimate_parameters"]
        if self.camera_kind == "lab" and rng.random() < 0.5:
            stages = [stage for stage in STAGES if stage != "measure"]
        self.stages = [rng.choice(stages) for _ in self.faults]
        self.is_later = [
            faults.may_come_any_time(fault) and rng.random() < 0.5 for fault in self.faults
        ]
        self.ks = [self.k, max(1, self.k + rng.choice([0, 0, 1, -1]))]
        self.delay = rng.uniform(0, 0.3)
        self.later = []

    @property
    def title(self):
        return " + ".join(sorted(fault.name for fault in self.faults))

    @property
    def kind(self):
        return f"{self.camera_kind}, {self.motors_kind}{', recorded' * self.is_recorded}"

    # What the callbacks do.

    def happen(self, fault):
        if fault.name not in self.marks:
            self.marks[fault.name] = time.monotonic()
            fault.act(self)

    def reach(self, stage, step):
        frame = step.frame
        if frame is not None:
            self.newest = frame.epoch + frame.t_arrival
        for fault, at, k, is_later in zip(
            self.faults, self.stages, self.ks, self.is_later, strict=False
        ):
            if is_later and step.k == 1 and stage == "control" and not self.later:
                self.later.append(faults.LaterFault(self.delay, lambda f=fault: self.happen(f)))
            elif not is_later and at == stage and step.k >= k:
                self.happen(fault)

    def callbacks(self):
        def measure(step):
            self.reach("measure", step)

        def estimate_parameters(step):
            self.reach("estimate_parameters", step)

        def estimate_state(step):
            self.reach("estimate_state", step)
            return robsim.Estimate((0, 0, 0), np.eye(3))

        def control(step):
            self.reach("control", step)
            self.decided += 1
            return input_of(step.k)

        given = {"measure": True, "estimate_state": estimate_state, "control": control}
        if "measure" in self.stages or self.camera_kind != "lab":  # the others are not punctual
            return given | {"measure": measure}
        return given | {"estimate_parameters": estimate_parameters}

    # The run.

    def drive(self):
        """Run until something ends it; a Ctrl-C comes in here, or never."""
        try:
            try:
                drive = next((f.drive for f in self.faults if f.drive), None)
                if drive is not None:
                    drive(self)
                else:
                    self.experiment.run(None if self.runs_to_end else STEPS)
            finally:
                self.marks["end"] = time.monotonic()
                for later in self.later:
                    later.end()
        except BaseException as error:
            self.error = error

    @property
    def runs_to_end(self):
        return self.faults[0].name in ("file ends", "camera: ends")

    def drop(self):
        """Give up all that drives, as a program that forgets it does."""
        self.experiment = None
        if self.motors_kind in robots.NATIVE:
            self.motors = None

    def run(self, folder):
        """Drive, and check what comes of it."""
        limits = resource.getrlimit(resource.RLIMIT_FSIZE)
        self.folder = Path(folder, "session")
        is_cut = any(fault.is_cut for fault in self.faults)
        with ExitStack() as stack:
            self.camera = stack.enter_context(cameras.MADE[self.camera_kind](self.rng))
            self.robot = robots.robot_of(self.motors_kind, is_cut)
            stack.callback(self.robot.close)
            self.motors = self.robot.motors()
            stack.callback(lambda: self.motors and robots.closed(self.motors))
            self.experiment = self.new_experiment()
            self.drive()
            self.wait_until_it_stands()
            if self.rng.random() < 0.5:  # the disk has room again
                resource.setrlimit(resource.RLIMIT_FSIZE, limits)
            self.close_experiment()
            resource.setrlimit(resource.RLIMIT_FSIZE, limits)
        self.check_error()
        self.check_stop()
        if self.experiment is not None:
            self.check_trace(self.experiment.trace)
        if self.error is not None:
            self.error.__traceback__ = None
        self.camera = self.experiment = self.error = self.robot = self.motors = None

    def new_experiment(self):
        time_limits = [fault.time_limit for fault in self.faults if fault.time_limit]
        return robsim.Experiment(
            self.camera.frames,
            send=self.motors,
            frame_timeout=self.frame_timeout,
            area=None if self.camera_kind != "generator" else (300, 300),
            robot="lab",
            limits=robsim.motors.Limits(voltage=5),
            record=self.folder if self.is_recorded else None,
            time_limit=min(time_limits, default=None),
            **self.callbacks(),
        )

    def close_experiment(self):
        if self.experiment is None:
            return
        try:
            with self.experiment:
                pass
        except BaseException as error:
            if not isinstance(error, self.expected_errors()):
                self.fail(f"closing the experiment: {type(error).__name__}: {error}")

    # What must hold.

    def fail(self, text):
        self.failures.append(text)

    def expected_errors(self):
        return (TimeoutError, *(error for fault in self.faults for error in fault.errors))

    def wait_until_it_stands(self):
        end = time.monotonic() + SOON
        while self.still_drives():
            if time.monotonic() > end:
                self.fail("the robot drives on")
                return
            time.sleep(0.005)

    def still_drives(self):
        heard = self.robot.heard()
        return bool(heard) and any(heard[-1][1:])

    def check_error(self):
        error = self.error
        if error is not None and not isinstance(error, self.expected_errors()):
            text = "".join(traceback.format_exception(error))
            self.fail(f"unexpected {text}")
        first = self.faults[0]
        is_alone = len(self.faults) == 1 and not first.is_cut
        must_raise = (
            is_alone
            and first.errors
            and (
                first in faults.IN_CALLBACK or (first.act is faults.ctrl_c and self.decided < STEPS)
            )
        )
        if must_raise and first.name in self.marks and error is None:
            self.fail(f"{first.name} raised nothing")
        self.is_overtaken = isinstance(error, TimeoutError) and TimeoutError not in first.errors

    def due(self):
        """When the robot must stand at the latest, but for the slack (s)."""
        watchdog = (self.newest or 0) + self.frame_timeout
        latest = self.marks["end"]
        for fault in self.faults:
            happened = self.marks.get(fault.name)
            if happened is None:
                continue
            promise = fault.promise(self.motors_kind)
            by = {
                "at once": happened,
                "watchdog": watchdog,
                "time to live": happened + robots.TTL,
                "after": max(self.marks.get("returned", happened), watchdog),
                "goes on": self.marks["end"],
            }[promise]
            if len(self.faults) > 1:  # the second one may have kept the first one from being seen
                by = max(by, watchdog, self.marks.get("returned", 0.0))
            is_alone = len(self.faults) == 1 and not fault.is_cut
            latest = min(latest, by) if is_alone else max(latest, by)
        return latest if self.faults[0].drive is None else max(latest, self.due_of_drive(watchdog))

    def due_of_drive(self, watchdog):
        happened = self.marks.get(self.faults[0].name, self.marks["end"])
        return {"watchdog": watchdog, "at once": happened}[self.faults[0].stands]

    def check_stop(self):
        heard = self.robot.heard()
        driving = [i for i, (_, *u) in enumerate(heard) if any(u)]
        self.late = None
        if not driving:
            return
        last = driving[-1]
        if last + 1 == len(heard):
            self.fail("the robot was never stopped")
            return
        self.late = heard[last + 1][0] - self.due()
        if self.late > self.slack:
            heard = [(round(t - self.due(), 3), *u) for t, *u in heard[-8:]]
            marks = {name: round(t - self.due(), 3) for name, t in self.marks.items()}
            self.fail(f"it stood {self.late:.3f} s too late: {heard}, {marks}, {self.error!r}")
        inputs = {round(u1, 4) for _, u1, u2 in heard if u1 or u2}
        wanted = {round(input_of(k)[0], 4) for k in range(self.decided)}
        if not inputs <= wanted:
            self.fail(f"it heard {inputs - wanted}, which nobody decided")

    def check_trace(self, trace):
        n = len(trace)
        if not self.decided - 1 <= n <= self.decided:
            self.fail(f"{self.decided} inputs were decided, the trace has {n} steps")
        for name in ("t", "u"):
            if not np.isfinite(getattr(trace, name)).all():
                self.fail(f"{name} of the trace is not finite")
        if (np.diff(trace.t) <= 0).any():
            self.fail("the times of the trace do not increase")
        wanted = np.array([input_of(k) for k in range(n)]).reshape(-1, 2)
        if not np.array_equal(trace.u, wanted):
            self.fail("the inputs of the trace are not those that were decided")
        if not any(fault.is_cut for fault in self.faults):
            heard = {round(u1, 4) for _, u1, _ in self.robot.heard()}
            if missing := {round(u1, 4) for u1, _ in wanted} - heard:
                self.fail(f"the trace has inputs that the robot never heard: {missing}")
        if self.is_recorded and n:
            self.check_session(trace)

    def check_session(self, trace):
        session = Session(self.folder)
        n = session.count
        is_full = "disk full" in self.marks
        if n != len(trace) and not (is_full and n < len(trace)):
            self.fail(f"the session has {n} steps, the trace {len(trace)}")
            return
        problems = [text for text in session.problems if "left out" not in text]
        if problems and not is_full:
            self.fail(f"the session says: {problems}")
        for name in ("t", "u", "t_arrival", "t_sent"):
            if not np.array_equal(getattr(session.trace, name), getattr(trace, name)[:n]):
                self.fail(f"{name} of the session is not that of the trace")
        seen = sum(observation.frame is not None for observation in session)
        left_out = sum(bool(row.left_out) for row in session._rows)
        if seen + left_out != n and not is_full:
            self.fail(f"{seen} frames, {left_out} left out, of {n} steps")


def held():
    """Native threads and descriptors of this process."""
    return len(os.listdir("/proc/self/task")), len(os.listdir("/proc/self/fd"))


def whose():
    """Threads of Python, and what descriptors lead to."""
    files = []
    for number in os.listdir("/proc/self/fd"):
        with suppress(OSError):
            files.append(os.readlink(f"/proc/self/fd/{number}"))
    return sorted(thread.name for thread in threading.enumerate()), sorted(files)


def play(number, seed, slack, kinds=cameras.SOFTWARE, patience=SOON):
    """Run a round with a camera of these kinds; return what a line of the table needs."""
    before, those = held(), whose()
    made = Round(number, seed, slack, kinds)
    start = time.monotonic()
    folder = tempfile.mkdtemp()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            made.run(folder)
        except BaseException:
            made.fail(traceback.format_exc())
    shutil.rmtree(folder)
    end = time.monotonic() + patience
    while any(now > was for now, was in zip(held(), before, strict=True)):
        gc.collect()
        if time.monotonic() > end:
            made.fail(f"left behind: {whose()} after {those}")
            break
        time.sleep(0.01)
    return {
        "round": number,
        "fault": made.title,
        "kind": made.kind,
        "late": getattr(made, "late", None),
        "overtaken": getattr(made, "is_overtaken", False),
        "reached": all(f.name in made.marks or f.act is faults.nothing for f in made.faults),
        "steps": made.decided,
        "failures": made.failures,
        "seconds": time.monotonic() - start,
    }
