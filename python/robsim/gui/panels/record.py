"""The panel's data: a run under way or a saved run, with its steps and frames."""

from __future__ import annotations

import math
import time
import warnings
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from robsim._core import (
    Blob,
    ColorClass,
    Estimate,
    Frame,
    MarkerLayout,
    Measurement,
    Step,
    find_blobs,
)
from robsim.base.checks import Floats
from robsim.gui._css_colors import css_color
from robsim.gui.panels.run.camera import Shot, particles_of, past_shot, row_of, shot_of
from robsim.simulation import Experiment, Scenario, Simulation
from robsim.simulation.options import colors_value
from robsim.trace import Trace
from robsim.trace.columns import GROUPS, fields_of
from robsim.trace.sessions.session import Session
from robsim.vision.robots.definition import RobotDefinition
from robsim.vision.robots.lookup import as_robot

_REOPEN = 1.0  # s between two looks for new data in a session


class Record(ABC):
    """The steps that the panel shows."""

    source: ClassVar[str]  # "simulation", "experiment" or "trace"
    reads_in_run: ClassVar[bool] = True  # whether only the run's thread may call `frame`
    remarks: tuple[str, ...] = ()  # for the user
    area: tuple[int, int]
    colors: tuple[ColorClass, ...]
    markers: MarkerLayout
    smoothing: int | None  # of the colour classes; None = by the markers
    robot_name: str
    outline: Floats  # in the axes of the robot

    @property
    @abstractmethod
    def title(self) -> str:
        """A short description."""

    @property
    @abstractmethod
    def trace(self) -> Trace:
        """The steps so far; any thread may read this."""

    @property
    @abstractmethod
    def n_steps(self) -> int:
        """The number of steps; any thread may read this."""

    @property
    def n_resets(self) -> int:
        """The number of resets; any thread may read this, before the steps."""
        return 0

    @abstractmethod
    def columns(self) -> Mapping[str, Floats]:
        """Return the current groups of columns of the trace; any thread may call this."""

    @property
    @abstractmethod
    def has_own_measure(self) -> bool:
        """Whether a callback of the user measures the pose."""

    @property
    def has_frames_once(self) -> bool:
        """Whether the frame of a past step may be unavailable."""
        return False

    @abstractmethod
    def frame(self, k: int) -> Frame | None:
        """Return the frame of a step; None without a frame, LookupError if it is lost.

        Call this in the thread of the run, unless `reads_in_run` is false.
        """

    @abstractmethod
    def find_blobs(self, frame: Frame) -> Mapping[str, list[Blob]]:
        """Return the blobs of a frame, found as in the run."""

    @property
    def trouble(self) -> Exception | None:
        """The first error while recording a session."""
        return None

    def shot(self, step: Step) -> Shot:
        """Return the picture data of the newest step; in the thread of the run."""
        return past_shot(self, step.k, step.frame)

    def time_of(self, k: int) -> float:
        """Return the time of a step (s)."""
        columns = self.columns()
        return float(columns["t"][k, 0]) if "t" in columns else k * self.trace.info.dt

    def step(self, k: int, frame: Frame | None) -> Step:
        """Return a past step with its data from the trace."""
        columns = self.columns()

        def row(name: str) -> list[float] | None:
            return row_of(columns, name, k)

        measured, parameters = row("pose_measured"), row("parameters")
        pose, covariance = row("pose_estimated"), row("covariance")
        estimate = None
        if pose is not None and covariance is not None:
            estimate = Estimate(pose, np.reshape(covariance, (3, 3)))
        return Step(
            k=k,
            t=self.time_of(k),
            dt=self.time_of(k) - self.time_of(k - 1) if k else self.trace.info.dt,
            last_u=row("last_u") or (k and row_of(columns, "u", k - 1)) or (0.0, 0.0),
            u=row("u"),
            frame=frame,
            measurement=measured and Measurement(measured),
            estimate=estimate,
            parameters=parameters and np.reshape(parameters, (3, 5)),
            colors=self.colors,
            markers=self.markers,
        )

    def described(self) -> dict[str, Any]:
        """Return its fields of the message ``setup``."""
        info, columns = self.trace.info, self.columns()
        theta = np.ravel(info.theta_true)
        return {
            "source": self.source,
            "title": self.title,
            "remarks": [*self.remarks],
            "dt": info.dt,
            "columns": [_described_group(name, columns.get(name)) for name in self._groups()],
            "has_truth": info.boundary != "recorded",
            "theta_true": theta.tolist() if np.isfinite(theta).all() else None,
            "colors": [{"name": c.name, "css": css_color(c)} for c in self.colors],
        }

    def _groups(self) -> list[str]:
        """Return the groups of columns that the trace has or may get."""
        of_colors = (f"blobs_{color.name}" for color in self.colors)
        return [*dict.fromkeys((*GROUPS, *of_colors, *self.columns()))]


def _described_group(name: str, rows: Floats | None) -> dict[str, Any]:
    fields = fields_of(name, 0 if rows is None else rows.shape[1])
    return {"name": name, "fields": [*fields], "units": [*fields.values()]}


class RunRecord(Record):
    """The steps of a run under way."""

    def __init__(self, runner: Simulation | Experiment) -> None:
        self._runner = runner
        self.look_again()

    def look_again(self) -> None:
        """Take over a changed robot, changed colours or a changed area of the run."""
        runner = self._runner
        self.area = runner.area
        self.colors, self.markers = runner.colors, runner.markers
        self.smoothing = runner._smoothing
        self.robot_name = runner.robot.name
        self.outline = runner.robot.to_robot_frame(runner.robot.outline)

    @property
    def title(self) -> str:
        return f"{self.source.capitalize()}, robot {self.robot_name}"

    @property
    def trace(self) -> Trace:
        return self._runner.trace

    @property
    def n_steps(self) -> int:
        return self._runner.n_steps

    @property
    def n_resets(self) -> int:
        return self._runner._n_resets

    def columns(self) -> Mapping[str, Floats]:
        return self._runner._core.columns()

    @property
    def has_own_measure(self) -> bool:
        return self._runner._callbacks["measure"] is not True

    def find_blobs(self, frame: Frame) -> Mapping[str, list[Blob]]:
        return self._runner.find_blobs(frame)

    def shot(self, step: Step) -> Shot:
        is_tracked = self._runner._is_on("measure")
        shot = shot_of(
            step,
            self.columns(),
            self.n_resets,
            is_tracked=is_tracked,
            is_own=self.has_own_measure,
        )
        found = step.estimate and particles_of(self._runner._callbacks["estimate_state"])
        return replace(shot, particles=found) if found else shot


class SimulationRecord(RunRecord):
    """The steps of a simulation, whose frames are rendered again."""

    source = "simulation"
    _runner: Simulation

    def frame(self, k: int) -> Frame | None:
        return self._runner.render_step(k)


class ExperimentRecord(RunRecord):
    """The steps of an experiment, whose frames are read again if possible."""

    source = "experiment"
    reads_in_run = False  # the run may wait for a frame of the camera
    _runner: Experiment
    _session: Session | None = None  # the recorded session, as far as it was read
    _opened = -math.inf

    @property
    def has_frames_once(self) -> bool:
        return not self._runner._source.can_read_again  # writing a session takes a moment

    @property
    def trouble(self) -> Exception | None:
        recording = self._runner._recording
        return None if recording is None else recording.error

    def frame(self, k: int) -> Frame | None:
        recording = self._runner._recording
        if recording is not None and recording.has_begun:
            return self._recorded(recording.path, k)
        return self._runner._source.again(k)

    def _recorded(self, path: Path, k: int) -> Frame | None:
        now = time.monotonic()
        if self._session is None or (k >= len(self._session) and now > self._opened + _REOPEN):
            self._session, self._opened = Session(path), now
        if k >= len(self._session):
            raise LookupError("the frame is not written yet")
        return self._session._at(k).frame


class SavedRecord(Record):
    """The steps of a trace or a session; ValueError unless it begins with step 0."""

    source = "trace"

    def __init__(self, saved: Trace | Session) -> None:
        trace = saved if isinstance(saved, Trace) else saved.full_trace()
        self._trace = trace.in_unit("px")
        if not len(self._trace):
            raise ValueError("the trace cannot be shown: it has no steps")
        if first := int(self._trace.k[0]):
            raise ValueError(f"the trace cannot be shown: it begins with step {first}, not 0")
        self._columns = self._trace._groups
        self._name = "Trace" if isinstance(saved, Trace) else f"Session {saved.path.stem}"
        self.area = self._trace.info.area
        self.smoothing = None
        self._read: Callable[[int], Frame | None] | None = None
        if isinstance(saved, Session):
            self._use_session(saved)
        elif self._trace.info.scenario is not None:
            self._use_scenario()
        else:
            self._use_robot(_robot_named(self._trace.info.robot))

    @property
    def title(self) -> str:
        robot = f", robot {self.robot_name}" if self.robot_name else ""
        return self._name + robot

    @property
    def trace(self) -> Trace:
        return self._trace

    @property
    def n_steps(self) -> int:
        return len(self._trace)

    def columns(self) -> Mapping[str, Floats]:
        return self._columns

    def _groups(self) -> list[str]:
        return [*self._columns]

    @property
    def has_own_measure(self) -> bool:
        return "measure" in self._trace.info.callbacks

    def frame(self, k: int) -> Frame | None:
        if self._read is None:
            raise LookupError("a trace of a real run has no frames; open the session instead")
        return self._read(k)

    def find_blobs(self, frame: Frame) -> Mapping[str, list[Blob]]:
        return find_blobs(frame, self.colors, markers=self.markers, smoothing=self.smoothing)

    def _use_robot(self, robot: RobotDefinition | None) -> None:
        known = as_robot("lab") if robot is None else robot
        self.robot_name = "" if robot is None else robot.name
        self.outline = np.empty((0, 2)) if robot is None else robot.to_robot_frame(robot.outline)
        self.markers = known.marker_layout()
        self.colors = colors_value(None)

    def _use_session(self, session: Session) -> None:
        self._use_robot(_robot_named(self._trace.info.robot))
        self.markers = session.markers or self.markers
        self.colors = tuple(session.colors or self.colors)
        self.remarks = session.problems
        self._read = lambda k: session._at(k).frame

    def _use_scenario(self) -> None:
        """Take robot and world from the scenario; the scenario only draws, and never runs."""
        info = self._trace.info
        scenario = info.scenario
        if isinstance(scenario, str):
            scenario = Scenario.from_toml(scenario)
        simulation = Simulation(scenario)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # such as for small markers: the run has shown them
            simulation._start()
        self._use_robot(simulation.robot)
        self.colors, self.markers = simulation.colors, simulation.markers
        self.smoothing = scenario.smoothing
        self._read = lambda k: simulation._drawn(k, self._columns)
        if drawn := {"adjust_background"} & {*info.callbacks}:
            text = "the pictures are drawn again, without what {} drew on the floor"
            self.remarks = (text.format(", ".join(drawn)),)
        if "robot" in info.changed:
            last = f"the robot changed in the run: all pictures show the last one, {info.robot}"
            self.remarks += (last,)


def _robot_named(name: str) -> RobotDefinition | None:
    try:
        return as_robot(name) if name else None
    except (OSError, ValueError):  # it was on another computer
        return None
