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
from robsim.lab import LineError
from robsim.trace import Session
from waiting import wait_for

from . import cameras, faults, robots

STAGES = ("measure", "estimate_state", "control")
STEPS = 25  # of a run that nothing ends before
LAST_FAULT = 14  # step


def input_of(k):
    """Another one for each step, so that what is heard says of which step it is."""
    return 0.5 + 0.001 * k, 0.25


def inputs_of(n):
    return np.array([input_of(k) for k in range(n)]).reshape(-1, 2)


class Checked:
    """A round, what failed in it, and by how much the robot stood too late (s)."""

    def __init__(self, seed, slack):
        self.rng, self.slack = random.Random(seed), slack
        self.failures, self.late = [], None

    def check(self, is_right, text):
        if not is_right:
            self.failures.append(text)

    def check_frames(self, session):
        """Each step has a frame, or says that it was left out."""
        seen = sum(observation.frame is not None for observation in session)
        left_out = sum(bool(row.left_out) for row in session._rows)
        self.check(seen + left_out == session.count, f"{seen} frames, {left_out} left out")


class Round(Checked):
    """A live run, with one or two faults."""

    def __init__(self, number, seed, slack, kinds):
        super().__init__(f"{seed} {number}", slack)
        rng = self.rng
        self.marks = {}  # when each fault happened
        self.newest = 0.0  # arrival of the newest frame that was taken
        self.decided, self.error, self.later = 0, None, []
        those = [fault for fault in faults.FAULTS if set(fault.cameras) & set(kinds)]
        first = those[number % len(those)]
        self.faults = [first]
        self.camera_kind = rng.choice([kind for kind in first.cameras if kind in kinds])
        self.motors_kind = rng.choice(first.motors)
        self.is_recorded = first.is_recorded or rng.random() < 0.5
        if first.drive is None and rng.random() < 0.25:
            self.faults.append(rng.choice([*filter(self.goes_with_first, faults.FAULTS)]))
        self.is_alone = len(self.faults) == 1 and not first.is_cut
        self.frame_timeout = rng.choice([0.4, 0.7])
        self.k = rng.randrange(1, LAST_FAULT)
        self.plans = [
            (
                fault,
                "later" if fault.any_time and rng.random() < 0.5 else rng.choice(STAGES),
                max(1, self.k + rng.choice([0, 0, 1, -1])),
            )
            for fault in self.faults
        ]
        self.title = " + ".join(sorted(fault.name for fault in self.faults))
        self.kind = f"{self.camera_kind}, {self.motors_kind}{', recorded' * self.is_recorded}"

    def goes_with_first(self, fault):
        return (
            self.camera_kind in fault.cameras
            and self.motors_kind in fault.motors
            and self.is_recorded >= fault.is_recorded
            and not (fault.is_cut and self.faults[0].is_cut)
            and fault.act is not faults.nothing
        )

    # What the callbacks do.

    def happen(self, fault):
        if fault.name not in self.marks:
            self.marks[fault.name] = time.monotonic()
            fault.act(self)

    def reach(self, stage, step):
        if step.frame is not None:
            self.newest = step.frame.epoch + step.frame.t_arrival
        for fault, at, k in self.plans:
            if at == stage and step.k >= k:
                self.happen(fault)
            elif at == "later" and (stage, step.k) == ("control", 1):
                timer = threading.Timer(self.rng.uniform(0, 0.3), self.happen, [fault])
                timer.daemon = True
                self.later.append(timer)
                timer.start()

    def measure(self, step):
        self.reach("measure", step)

    def estimate_state(self, step):
        self.reach("estimate_state", step)
        return robsim.Estimate((0, 0, 0), np.eye(3))

    def control(self, step):
        self.reach("control", step)
        self.decided += 1
        return input_of(step.k)

    # The run.

    def run(self, folder):
        """Drive, and check what comes of it."""
        limits = resource.RLIMIT_FSIZE, resource.getrlimit(resource.RLIMIT_FSIZE)
        folder = Path(folder, "session") if self.is_recorded else None
        with ExitStack() as stack:
            stack.callback(resource.setrlimit, *limits)
            self.camera = stack.enter_context(cameras.camera_of(self.camera_kind, self.rng))
            is_cut = any(fault.is_cut for fault in self.faults)
            self.robot = robots.Robot(self.motors_kind, is_cut)
            stack.callback(self.robot.close)
            self.motors = robots.motors_at(self.motors_kind, self.robot.address)
            stack.callback(self.close_motors)
            self.experiment = robsim.Experiment(
                self.camera.frames, send=self.motors, frame_timeout=self.frame_timeout,
                area=(300, 300) if self.camera_kind == "generator" else None,
                robot="lab", limits=robsim.lab.Limits(voltage=5), record=folder,
                time_limit=min((f.time_limit for f in self.faults if f.time_limit), default=None),
                measure=self.measure, estimate_state=self.estimate_state, control=self.control,
            )  # fmt: skip
            self.drive()
            wait_for(lambda: not self.robot.drives())
            if self.rng.random() < 0.5:  # the disk has room again
                resource.setrlimit(*limits)
            with suppress(*self.expected_errors()), self.experiment or ExitStack():
                pass
        self.check_error()
        self.check_stop()
        if self.experiment is not None:
            self.check_trace(self.experiment.trace)
            if self.is_recorded and len(self.experiment.trace):
                self.check_session(Session(folder), self.experiment.trace)
        if self.error is not None:
            self.error.__traceback__ = None
        self.camera = self.experiment = self.error = self.robot = self.motors = None

    def drive(self):
        """Run until something ends it; a Ctrl-C comes in here, or never."""
        first = self.faults[0]
        try:
            try:
                if first.drive is not None:
                    first.drive(self)
                else:
                    ends_by_itself = first.name in ("file ends", "camera: ends")
                    self.experiment.run(None if ends_by_itself else STEPS)
            finally:
                self.marks["end"] = time.monotonic()
                for timer in self.later:
                    timer.cancel()
                    timer.join()
        except BaseException as error:
            self.error = error

    def close_motors(self):
        with suppress(LineError):  # it may be cut
            if self.motors is not None:
                self.motors.close()

    # What must hold.

    def expected_errors(self):
        return (TimeoutError, *(error for fault in self.faults for error in fault.errors))

    def check_error(self):
        error, first = self.error, self.faults[0]
        if error is None:
            has_ended = self.decided == STEPS and first.any_time
            must_raise = self.is_alone and first.must_raise and first.name in self.marks
            self.check(has_ended or not must_raise, f"{first.name} raised nothing")
        elif not isinstance(error, self.expected_errors()):
            self.check(False, "".join(traceback.format_exception(error)))

    def due(self):
        """When the robot must stand at the latest, but for the slack (s)."""
        end, watchdog = self.marks["end"], self.newest + self.frame_timeout
        returned, is_native = self.marks.get("returned", 0.0), self.motors_kind in robots.NATIVE
        by = []
        for fault in self.faults:
            happened = self.marks.get(fault.name)
            times = {
                "at once": happened,
                # motors in Python wait for a callback that holds the interpreter
                "watchdog": watchdog if is_native else max(returned, watchdog),
                "time to live": happened and happened + robots.TTL,
                "goes on": end,
            }
            if happened is not None:
                by.append(times[fault.stands])
        if self.faults[0].drive is not None:
            return max([*by, 0.0]) if by else end
        if self.is_alone:
            return min([end, *by])
        # the second one may have kept the first one from being seen
        return max([end, *by, *([watchdog, returned] if len(self.faults) > 1 else [])])

    def check_stop(self):
        stood, heard = self.robot.stood(), self.robot.heard()
        if stood is None:
            return
        due = self.due()
        self.late = stood - due
        last = [(round(t - due, 3), *u) for t, *u in heard[-8:]]
        marks = {name: round(t - due, 3) for name, t in self.marks.items()}
        is_in_time = self.late <= self.slack
        self.check(is_in_time, f"{self.late:.3f} s too late: {last}, {marks}, {self.error!r}")
        inputs = {round(u1, 4) for _, u1, u2 in heard if u1 or u2}
        wanted = {round(u1, 4) for u1, _ in inputs_of(self.decided)}
        self.check(inputs <= wanted, f"it heard {inputs - wanted}, which nobody decided")

    def check_trace(self, trace):
        n, wanted = len(trace), inputs_of(len(trace))
        self.check(self.decided - 1 <= n <= self.decided, f"{n} steps of {self.decided}")
        self.check(
            np.isfinite(trace.t).all() and (np.diff(trace.t) > 0).all(), "times of the trace"
        )
        self.check(np.array_equal(trace.u, wanted), "inputs of the trace")
        if not any(fault.is_cut for fault in self.faults):
            heard = {round(u1, 4) for _, u1, _ in self.robot.heard()}
            missing = {round(u1, 4) for u1, _ in wanted} - heard
            self.check(not missing, f"the robot never heard {missing} of the trace")

    def check_session(self, session, trace):
        n, is_full = session.count, "disk full" in self.marks
        self.check(n == len(trace) or (is_full and n < len(trace)), f"{n} of {len(trace)} recorded")
        for name in ("t", "u", "t_arrival", "t_sent"):
            recorded, kept = getattr(session.trace, name), getattr(trace, name)[:n]
            self.check(np.array_equal(recorded, kept), f"{name} of the session is not the trace's")
        if not is_full:
            self.check_frames(session)
            problems = [text for text in session.problems if "left out" not in text]
            self.check(not problems, f"the session says: {problems}")


def held():
    """Native threads and descriptors of this process."""
    return len(os.listdir("/proc/self/task")), len(os.listdir("/proc/self/fd"))


def play(number, seed, slack, kinds, patience=cameras.LONG):
    """Run a round with a camera of these kinds; return what a line of the table needs."""
    from .children import ChildRound, is_turn

    before = held()
    made = (ChildRound if is_turn(number) else Round)(number, seed, slack, kinds)
    folder = tempfile.mkdtemp()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            made.run(folder)
        except BaseException:
            made.failures.append(traceback.format_exc())
    shutil.rmtree(folder)
    end = time.monotonic() + patience
    while any(now > was for now, was in zip(held(), before, strict=True)):
        gc.collect()
        if time.monotonic() > end:
            made.failures.append(f"left behind: {held()} after {before}, {threading.enumerate()}")
            break
        time.sleep(0.01)
    return {
        "round": number, "fault": made.title, "kind": made.kind, "late": made.late,
        "failures": made.failures,
    }  # fmt: skip
