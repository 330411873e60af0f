"""A live run, until an event ends it, and its status line on the terminal."""

from __future__ import annotations

import math
import os
import sys
import threading
import time
import warnings
from collections import deque
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Self

from robsim._core import Limits, MotorLink, RobotModel, detect
from robsim.base.report import Quantity, Report
from robsim.base.text import one_line
from robsim.cli import errors
from robsim.cli.sources import SIMULATED
from robsim.lab.cameras.camera import Camera, CameraCounts
from robsim.simulation import Experiment
from robsim.simulation.callback_folder import CallbackFolder
from robsim.trace import Trace

_PERIOD = 0.125  # s
_RATE_OVER = 16  # periods
_TO_START, _CLEAR = "\r", "\x1b[K"


class StatusLine:
    """Renews a line on a terminal, and ends the run when its time is over.

    Time counts `seconds` after the first frame. Without a terminal, no line is shown.
    """

    def __init__(self, experiment: Experiment, camera: Camera, seconds: float | None) -> None:
        self._experiment, self._camera = experiment, camera
        self._seconds = math.inf if seconds is None else seconds
        self._is_shown = sys.stderr.isatty()
        self._grabbed: deque[tuple[float, int]] = deque(maxlen=_RATE_OVER)
        self._is_over = threading.Event()
        self._thread = threading.Thread(target=self._watch, name="robsim status", daemon=True)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._is_over.set()
        self._thread.join()
        if self._is_shown:
            sys.stderr.write(_TO_START + _CLEAR)
            sys.stderr.flush()

    def _watch(self) -> None:
        start = None
        while not self._is_over.wait(_PERIOD):
            if not (trace := self._experiment.trace):
                continue
            start = time.monotonic() if start is None else start
            if time.monotonic() - start >= self._seconds:
                self._experiment.stop()
            if self._is_shown:
                width = os.get_terminal_size(sys.stderr.fileno()).columns - 1
                line = one_line(self.text(trace))[: max(width, 20)]
                sys.stderr.write(_TO_START + line + _CLEAR)
                sys.stderr.flush()

    def text(self, trace: Trace) -> str:
        """Return the line."""
        now, counts = time.monotonic(), self._camera.counts
        self._grabbed.append((now, counts.grabbed))
        (before, grabbed), frame = self._grabbed[0], self._camera.newest
        rate = (counts.grabbed - grabbed) / (now - before) if now > before else math.nan
        age = math.nan
        if frame is not None and frame.epoch is not None and frame.t is not None:
            age = now - (frame.epoch + frame.t)
        left, right = trace.u[-1]
        return (
            f"{trace.t[-1]:5.1f} s {rate:5.1f}/s  age {1e3 * age:3.0f} ms  "
            f"dropped {counts.dropped + counts.torn}  {self._not_recorded()}{self._seen(trace)}  "
            f"{left:+.2f} {right:+.2f} V"
        )

    def _not_recorded(self) -> str:
        recording = self._experiment._recording
        return "" if recording is None or recording.error is None else "NOT RECORDED  "

    def _seen(self, trace: Trace) -> str:
        """Return the measured pose, or the reason for a missing one."""
        x, y, heading = trace.pose_measured[-1]
        if not math.isnan(x):
            return f"x {x:4.0f} y {y:4.0f} {math.degrees(heading):+4.0f} deg"
        experiment, frame = self._experiment, self._camera.newest
        if frame is None:
            return "not seen"
        blobs = experiment.find_blobs(frame)
        found = detect(blobs, experiment.markers, plane_map=frame.plane_map, image=frame)
        return f"not seen{f': {found.reason}' if found.reason else ''}"


_PATIENCE = 10.0  # s without a frame, if nothing is driven


def step_of_model(folder: Path | None) -> float | None:
    """Return the dt of the model of a folder's define_model.py (s), if it exists."""
    if folder is None or not (folder / "define_model.py").is_file():
        return None
    define_model = CallbackFolder(folder, ("define_model",)).load().get("define_model")
    model = define_model() if callable(define_model) else None
    return model.dt if isinstance(model, RobotModel) else None


@dataclass(frozen=True, kw_only=True)
class CountsReport(Report):
    """The counts of a camera's frames."""

    counts: CameraCounts
    title: str = "Frames of the camera"

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """The counts."""
        counts = self.counts
        return (
            Quantity("grabbed", "came", counts.grabbed),
            Quantity("delivered", "used", counts.delivered),
            Quantity("dropped", "replaced by a newer one", counts.dropped),
            Quantity("torn", "torn", counts.torn),
            Quantity("timeouts", "waits without a frame", counts.timeouts),
        )


@dataclass
class LiveRun:
    """A live run."""

    steps: int | None
    seconds: float | None  # how long it is (s)
    limits: Limits  # of the voltages
    frame_timeout: float | None  # as in `Experiment`
    #: The run, when there is something to report of it.
    experiment: Experiment | None = None
    #: What ended it.
    failure: Exception | None = None
    counts: CameraCounts = field(default_factory=CameraCounts)

    @property
    def reports(self) -> dict[str, Report]:
        """The reports specific to a live run."""
        assert self.experiment is not None
        reports: dict[str, Report] = {"camera": CountsReport(counts=self.counts)}
        if trace := self.experiment.trace:
            reports["timing"] = trace.timing()
        return reports

    def drive(
        self,
        line: AbstractContextManager[tuple[Camera, MotorLink | None]],
        folder: Path | None,
        options: dict[str, Any],
    ) -> None:
        """Open camera and line, and run. Errors before the first step are raised."""
        try:
            with line as (camera, motors):
                experiment = self._new_experiment(camera, motors, folder, options)
                self._tell(experiment, camera, motors)
                self._run(experiment, camera)
                self.counts = camera.counts
        except Exception as error:  # the line cannot be closed
            if self.experiment is None:
                raise
            self.failure = self.failure or error

    def _new_experiment(
        self, camera: Camera, motors: MotorLink | None, folder: Path | None, options: dict[str, Any]
    ) -> Experiment:
        if motors is not None:
            options |= {"send": motors, "limits": self.limits}
        if self.frame_timeout is not None:
            options["frame_timeout"] = self.frame_timeout
        elif motors is None:
            options["frame_timeout"] = _PATIENCE
        if folder is None:
            return Experiment(camera, **options)
        return Experiment.from_folder(folder, frames=camera, **options)

    def _tell(self, experiment: Experiment, camera: Camera, motors: MotorLink | None) -> None:
        """Print the settings before the robot drives."""
        rate = "" if camera.dt is None else f", {1 / camera.dt:.3g} frames/s"
        source = camera.source if isinstance(camera.source, (int, str)) else SIMULATED
        errors.print_note(f"camera {source}: {camera.size[0]} x {camera.size[1]} px{rate}")
        if camera.dt is None:
            errors.print_note(
                f"the camera does not report its rate: the model assumes steps of "
                f"{experiment.model.dt:g} s; --fps sets the rate"
            )
        if motors is None:
            errors.print_note("nothing is sent: --motors none")
        elif experiment.control.callback is None:
            errors.print_note(
                "no controller, so no input is sent: use a folder with control.py, or --control"
            )
        else:
            errors.print_note(
                f"motors {motors.name}: at most {self.limits.voltage:g} V, and "
                f"{self.limits.slew_rate:g} V/s (--max-voltage, --slew-rate); Ctrl-C stops the "
                "robot"
            )

    def _run(self, experiment: Experiment, camera: Camera) -> None:
        try:
            with (
                warnings.catch_warnings(),
                experiment,
                StatusLine(experiment, camera, self.seconds),
            ):
                warnings.filterwarnings("ignore", message="send was given, but there is no")
                experiment.run(self.steps)
        except KeyboardInterrupt:
            errors.print_note(f"stopped after {len(experiment.trace)} steps")
        except Exception as error:
            if not experiment.trace:
                raise
            self.failure = error
            errors.print_note(f"the {len(experiment.trace)} steps until the error are kept")
        self.experiment = experiment
