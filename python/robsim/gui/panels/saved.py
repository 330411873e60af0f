"""A record that was saved: a trace, whose frames are rendered again, or a session."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping

import numpy as np

from robsim._core import Blob, Frame, find_blobs
from robsim.base.checks import Floats
from robsim.base.text import listed
from robsim.gui.panels.record import Record
from robsim.simulation import Scenario, Simulation
from robsim.trace import Trace
from robsim.trace.sessions.session import Session
from robsim.trace.sessions.writer import TRACE
from robsim.vision.markers.color_files import load_colors
from robsim.vision.robots.definition import RobotDefinition
from robsim.vision.robots.lookup import load_robot


class SavedRecord(Record):
    """The steps of a trace or a session.

    Parameters
    ----------
    saved : Trace or Session
        It must have a step, and begin with step 0.

    Raises
    ------
    ValueError
        If it does not.
    """

    source = "trace"

    def __init__(self, saved: Trace | Session) -> None:
        self._trace = _trace_of(saved).in_unit("px")
        if not len(self._trace):
            raise ValueError("the trace cannot be shown: it has no steps")
        if first := int(self._trace.k[0]):
            raise ValueError(f"the trace cannot be shown: it begins with step {first}, not 0")
        self._columns = self._trace._groups
        self._name = "Trace" if isinstance(saved, Trace) else f"Session {saved.folder.name}"
        self.area = self._trace.info.area
        self._smoothing: int | None = None
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
            raise LookupError("a trace of a real run has no frames: open the session's folder")
        return self._read(k)

    def find_blobs(self, frame: Frame) -> Mapping[str, list[Blob]]:
        return find_blobs(frame, self.colors, markers=self.markers, smoothing=self._smoothing)

    def _use_robot(self, robot: RobotDefinition | None) -> None:
        known = load_robot("lab") if robot is None else robot
        self.robot_name = "" if robot is None else robot.name
        self.outline = np.empty((0, 2)) if robot is None else robot.to_robot_frame(robot.outline)
        self.markers = known.marker_layout()
        self.colors = tuple(load_colors())

    def _use_session(self, session: Session) -> None:
        self._use_robot(_robot_named(self._trace.info.robot))
        self.markers = session.markers or self.markers
        self.colors = tuple(session.colors or self.colors)
        self.remarks = session.problems
        self._read = lambda k: session._at(k).frame

    def _use_scenario(self) -> None:
        """Take robot and world from the scenario; it is never run, only drawn."""
        info = self._trace.info
        scenario = info.scenario
        if isinstance(scenario, str):
            scenario = Scenario.from_toml(scenario)
        simulation = Simulation(scenario)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of markers too small and the like, said in the run
            simulation._start()
        self._use_robot(simulation.robot)
        self.colors, self.markers = simulation.colors, simulation.markers
        self._smoothing = scenario.smoothing
        self._read = lambda k: simulation._drawn(k, self._columns)
        if drawn := {"adjust_background"} & {*info.callbacks}:
            text = "the pictures are drawn again, without what {} drew on the floor"
            self.remarks = (text.format(listed(drawn)),)
        if "robot" in info.changed:
            last = f"the robot changed in the run: all pictures show the last one, {info.robot}"
            self.remarks += (last,)


def _trace_of(saved: Trace | Session) -> Trace:
    if isinstance(saved, Trace):
        return saved
    whole = saved.folder / TRACE  # of a run that ended well
    return Trace.load(whole) if whole.is_file() else saved.trace


def _robot_named(name: str) -> RobotDefinition | None:
    try:
        return load_robot(name) if name else None
    except (OSError, ValueError):  # it was on another computer
        return None
