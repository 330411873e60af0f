"""The robot's controller: a signal, a drive to a point or along a path, or the user's."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from robsim._core import locate
from robsim.base.checks import Floats
from robsim.control import FollowPath, GoToPoint
from robsim.gui._link import Refused
from robsim.gui.panels.settings.owners import Owners
from robsim.gui.panels.settings.setting import Choice, Remarks
from robsim.gui.panels.settings.signals import OFF, SIGNAL_KINDS, SIGNALS, signal_of
from robsim.gui.panels.settings.stages import Stages
from robsim.simulation import Experiment, Simulation

_SPACING = 15.0  # px between waypoints: less than the radius of a reached waypoint

_TO_POINTS = {"go-to-point": GoToPoint, "follow-path": FollowPath}
_KINDS = {kind: name for name, kind in _TO_POINTS.items()} | SIGNAL_KINDS

Point = Sequence[float]


def as_told(goals: Floats | None) -> tuple[list[float] | None, list[list[float]] | None]:
    """Return goals in the form of the browser's message: a position or pose, or waypoints."""
    if goals is None:
        return None, None
    return (goals.tolist(), None) if goals.ndim == 1 else (None, goals.tolist())


class Driving(Choice):
    """The controller and its goal."""

    name, card = "control", "drive"

    def __init__(
        self,
        runner: Simulation | Experiment,
        stages: Stages,
        owners: Owners,
        goals: Floats | None = None,
    ) -> None:
        self._runner = runner
        self._stages = stages
        self._owners = owners
        #: The requested goal, drawn for every controller: a position or a pose, or waypoints.
        self._asked, self._asked_path = as_told(goals)
        self._goal: Point | None = None if self._asked is None else self._asked[:2]
        self._path: Sequence[Point] | None = self._asked_path

    @property
    def value(self) -> str:
        control = self._runner._callbacks["control"]
        if control is None:  # in an experiment
            return OFF
        if self._owners.of("control") == "mine":
            return "mine"
        return signal_of(control) or _KINDS[type(control)]

    @property
    def goal(self) -> list[float] | None:
        """The current or requested goal, with a heading if it has one; any thread may read this."""
        control = self._runner._callbacks["control"]
        if not isinstance(control, GoToPoint):
            return self._asked
        goal = [control.x, control.y]
        return self._asked if self._asked is not None and self._asked[:2] == goal else goal

    @property
    def path(self) -> list[list[float]] | None:
        """The current or requested waypoints; any thread may read this."""
        control = self._runner._callbacks["control"]
        if isinstance(control, FollowPath):
            return np.asarray(control.waypoints).tolist()  # type: ignore[no-any-return]
        return self._asked_path

    def choices(self) -> Mapping[str, str | None]:
        ours = dict.fromkeys((*SIGNALS, *_TO_POINTS), self._why_not)
        return {**ours, OFF: None, "mine": self._owners.why_not_mine("control")}

    def choose(self, name: str) -> Remarks:
        if name == "mine":
            return self._stages.choose("control", name)
        if self._why_not:
            return self._stages.fill("control", None)
        if name == "go-to-point":
            return self._go_on_to(self._goal)
        if name == "follow-path":
            return self._go_on_along(self._path)
        return self._stages.fill("control", SIGNALS[name](self._runner.model.dt))

    def go_to(self, x: float, y: float) -> Remarks:
        """Drive to a point, or as near as the walls allow; in the thread of the run."""
        self._check()
        width, height = self._runner.area
        if not self._is_endless and not (0 <= x <= width and 0 <= y <= height):
            raise Refused("the point is outside the work area")
        self._goal = self._within([(x, y)])[0].tolist()
        return self._go_on_to(self._goal)

    def follow(self, points: Sequence[Point]) -> Remarks:
        """Drive along a path, or as near as the walls allow; in the thread of the run."""
        self._check()
        path = _spaced(self._within(points)) if points else np.empty((0, 2))
        if len(path) < 2:
            raise Refused(f"the path is too short: draw at least {_SPACING:g} px")
        self._path = path.tolist()
        return self._go_on_along(self._path)

    def _go_on_to(self, goal: Point | None) -> Remarks:
        x, y = goal or self._here()
        remarks = self._stages.fill("control", GoToPoint(x, y))
        return remarks if goal else ["Click in the picture to set the goal", *remarks]

    def _go_on_along(self, path: Sequence[Point] | None) -> Remarks:
        remarks = self._stages.fill("control", FollowPath(path or [self._here()]))
        return remarks if path else ["Draw a path in the picture", *remarks]

    def _here(self) -> Point:
        """Return the robot's known position, so that the robot stays there."""
        step = self._runner.last_step
        seen = step.estimate or step.measurement
        if seen is None and step.frame is not None:
            blobs = self._runner.find_blobs(step.frame)
            if blobs.keys() >= {*self._runner.markers.colors.values()}:
                seen = locate(blobs, self._runner.markers, step.frame.plane_map)
        if seen is not None:
            return [float(number) for number in seen.pose[:2]]
        return [side / 2 for side in self._runner.area]

    def _check(self) -> None:
        if self._why_not:
            raise Refused(self._why_not)

    @property
    def _why_not(self) -> str | None:
        """Return why the panel cannot drive the robot; None = it can."""
        if isinstance(self._runner, Experiment) and self._runner._motors is None:
            return "the panel cannot drive this robot: the experiment was made without send=..."
        return None

    @property
    def _is_endless(self) -> bool:
        return self._runner.boundary == "unlimited"

    def _within(self, points: Sequence[Point]) -> Floats:
        """Return points that the robot can reach: its centre stays one radius off the walls."""
        found = np.array(points, float)
        if self._is_endless:
            return found
        margin = self._runner.robot.radius if isinstance(self._runner, Simulation) else 0.0
        area = np.array(self._runner.area, float)
        margins = np.minimum(margin, area / 2)
        return np.asarray(np.clip(found, margins, area - margins))


def _spaced(points: Floats) -> Floats:
    """Return a path without crowded points: hand-drawn lines are not straight."""
    kept = [points[0]]
    for point in points[1:]:
        if np.hypot(*(point - kept[-1])) >= _SPACING:
            kept.append(point)
    if len(kept) > 1:
        kept[-1] = points[-1]  # the path keeps its end
    return np.array(kept)
