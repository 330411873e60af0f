"""Ready controllers that use the measurement."""

from __future__ import annotations

import math
from dataclasses import KW_ONLY, dataclass, field, fields

import numpy as np
from numpy.typing import ArrayLike

from robsim._base.checks import Floats, check_float
from robsim._core import Step, wrap_angle
from robsim.control._waypoints import as_waypoints, nearest_on_segment


class _Motion:
    """Pose and speed of the robot as a controller sees them, from step to step."""

    smoothing = 0.5  # s: over about this time the noise of the speed is averaged
    memory = 2.0  # s: a pose from longer ago says nothing of the speed now

    def __init__(self) -> None:
        self.forget()

    def forget(self) -> None:
        """Start anew, as at the start of a run."""
        self.k = -1
        self.is_new = True  # the newest pose is the first one
        self.pose = np.zeros(3)  # x, y (px), heading (rad)
        self.speed = np.zeros(3)  # of x, y (px/s) and heading (rad/s)

    def see(self, step: Step) -> bool:
        """Take in the best pose that is known at a step; return whether there is one."""
        if step.k == 0 or step.k < self.k:
            self.forget()
        seen = step.estimate or step.measurement
        if seen is None:
            return False
        gap = (step.k - self.k) * step.dt
        self.is_new = self.k < 0
        if self.is_new or gap > self.memory:
            self.speed = np.zeros(3)
        elif gap > 0:
            moved = seen.pose - self.pose
            moved[2] = wrap_angle(moved[2])
            # speed(k) = speed(k-1) + gap/(gap + smoothing) (moved/gap - speed(k-1))
            self.speed = self.speed + (moved - gap * self.speed) / (gap + self.smoothing)
        self.k, self.pose = step.k, seen.pose
        return True


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class _Drive:
    """The law by which both controllers drive towards a goal, and its options."""

    max_voltage: float = 1.0  # V
    max_speed: float = 40.0  # px/s
    distance_gain: float = 0.5  # px/s per px
    speed_gain: float = 0.1  # V per px/s
    heading_gain: float = 0.7  # V per rad
    turn_gain: float = 0.4  # V per rad/s
    min_voltage: float = 0.3  # V
    _motion: _Motion = field(default_factory=_Motion, init=False)

    def __post_init__(self) -> None:
        for name, unit in {
            "max_voltage": "V",
            "max_speed": "px/s",
            "distance_gain": "px/s per px",
            "speed_gain": "V per px/s",
            "heading_gain": "V per rad",
            "turn_gain": "V per rad/s",
            "min_voltage": "V",
        }.items():
            check_float(name, getattr(self, name), unit, minimum=0)

    def __repr__(self) -> str:
        # what comes first in a call comes first here
        shown = sorted((f for f in fields(self) if f.init), key=lambda f: bool(f.kw_only))
        options = ", ".join(f"{f.name}={getattr(self, f.name)!r}" for f in shown)
        return f"{type(self).__name__}({options})"

    def _towards(self, goal: Floats) -> tuple[float, float]:
        """Return the voltages (u1, u2) that drive the robot to a place and stop it there."""
        place, heading = self._motion.pose[:2], self._motion.pose[2]
        velocity, turn_rate = self._motion.speed[:2], self._motion.speed[2]
        # wanted velocity = distance_gain (goal - place), at most max_speed
        wanted = self.distance_gain * (goal - place)
        wanted *= min(1.0, self.max_speed / max(math.hypot(*wanted), 1e-9))
        # force = speed_gain (wanted velocity - velocity): it brakes a sideways slide, too
        force = self.speed_gain * (wanted - velocity)
        if math.hypot(*force) < self.min_voltage:
            return 0.0, 0.0
        # the force's parts along the heading and to the right of it
        ahead = force[0] * math.cos(heading) + force[1] * math.sin(heading)
        right = force[1] * math.cos(heading) - force[0] * math.sin(heading)
        # error = angle from the robot's axis to the force, whichever end of the axis is nearer
        error = math.atan2(math.copysign(1, ahead) * right, abs(ahead))
        # turn = heading_gain error - turn_gain turn rate; what it leaves of the voltage drives
        turn = _limited(self.heading_gain * error - self.turn_gain * turn_rate, self.max_voltage)
        drive = _limited(ahead, self.max_voltage - abs(turn))
        # u1 = drive + turn, u2 = drive - turn: a faster left wheel turns the robot to the right
        return _limited(drive + turn, self.max_voltage), _limited(drive - turn, self.max_voltage)


def _limited(value: float, limit: float) -> float:
    return float(min(max(value, -limit), limit))


@dataclass(frozen=True, eq=False, repr=False)
class GoToPoint(_Drive):
    """Drives the robot to a point and stops it there; it may do so backwards.

    It goes by the estimated pose if a state estimator runs, else by the measured one. Where the
    robot is not seen, it lets it coast: (0, 0). It remembers the last pose: make one for each
    simulation.

    Parameters
    ----------
    x, y : float
        The point (work-area px).
    max_voltage : float
        Largest voltage of each motor, forwards and backwards (V). Turning comes before driving.
    max_speed : float
        Largest speed that is wanted (px/s). The default robot does 33 px/s at 1 V.
    distance_gain : float
        Wanted speed per distance from the goal (px/s per px): large = brakes late.
    speed_gain : float
        Voltage per speed that is missing (V per px/s).
    heading_gain : float
        Voltage per heading error (V per rad): turns the robot to where the force is wanted.
    turn_gain : float
        Voltage per turn rate (V per rad/s): damps the turning.
    min_voltage : float
        With less to do than this, the motors rest (V). At rest the robot may be
        ``min_voltage / (speed_gain * distance_gain)`` from the goal, 6 px by default.

    Raises
    ------
    TypeError, ValueError
        If a value is not a finite number, or an option is below 0.

    Notes
    -----
    The default robot slides sideways, as a hovercraft does: turning it does not turn its path. So
    the law is one of forces. The distance gives the velocity that is wanted, what is missing of it
    gives a force, and the robot turns its axis towards that force:

        wanted velocity = distance_gain (goal - place), at most max_speed
        force = speed_gain (wanted velocity - velocity)
        turn = heading_gain (direction of the force - heading) - turn_gain turn rate
        drive = part of the force along the heading, at most max_voltage - |turn|
        u1 = drive + turn,  u2 = drive - turn

    The velocity and the turn rate are those of the poses seen, through a low-pass.

    Examples
    --------
    >>> sim = robsim.Simulation(measure=True, control=robsim.GoToPoint(900, 300), seed=1)
    >>> trace = sim.run(200)
    """

    x: float
    y: float

    def __post_init__(self) -> None:
        super().__post_init__()
        check_float("x", self.x, "px")
        check_float("y", self.y, "px")

    def __call__(self, step: Step) -> tuple[float, float]:
        """Return the voltages (u1, u2) of a step."""
        if not self._motion.see(step):
            return 0.0, 0.0
        return self._towards(np.array([self.x, self.y]))


@dataclass
class _Progress:
    """Where on its path a controller is."""

    heading_for: int = 0
    last: Floats = field(default_factory=lambda: np.zeros(2))


@dataclass(frozen=True, eq=False, repr=False)
class FollowPath(_Drive):
    """Drives the robot along straight lines from waypoint to waypoint and stops it at the last.

    The first line begins where it first sees the robot in a run. It drives as `GoToPoint` does, to
    a goal on the path that moves on ahead of the robot; before a corner sharper than 45 degrees
    the goal waits, and the robot slows down.

    Parameters
    ----------
    waypoints : array (N, 2)
        Places (x, y) in work-area px, in the order in which they are to be reached.
    reach : float
        So near to a waypoint (px), it heads for the next one.
    lookahead : float
        How far the goal is ahead, from the point of the line nearest to the robot (px): small =
        slow and close to the line.
    max_voltage, max_speed, distance_gain, speed_gain, heading_gain, turn_gain, min_voltage : float
        As of `GoToPoint`.

    Raises
    ------
    TypeError, ValueError
        If the waypoints are not finite numbers of this shape, or as of `GoToPoint`.

    Examples
    --------
    >>> corners = [(400, 400), (800, 400), (800, 800), (400, 800), (400, 400)]
    >>> sim = robsim.Simulation(measure=True, control=robsim.FollowPath(corners), seed=1)
    >>> trace = sim.run(500)
    >>> print(robsim.score_path(trace, corners))
    """

    waypoints: ArrayLike
    _: KW_ONLY
    reach: float = 20.0
    lookahead: float = 60.0
    _progress: _Progress = field(default_factory=_Progress, init=False)

    def __post_init__(self) -> None:
        super().__post_init__()
        check_float("reach", self.reach, "px", minimum=0)
        check_float("lookahead", self.lookahead, "px", minimum=0)
        object.__setattr__(self, "waypoints", as_waypoints(self.waypoints))

    @property
    def heading_for(self) -> int:
        """Index of the waypoint that it heads for; that of the last one from there on."""
        return self._progress.heading_for

    def __call__(self, step: Step) -> tuple[float, float]:
        """Return the voltages (u1, u2) of a step."""
        if not self._motion.see(step):
            return 0.0, 0.0
        return self._towards(self._goal(self._motion.pose[:2]))

    def _goal(self, place: Floats) -> Floats:
        """Return the place to drive to now: `lookahead` on along the path."""
        path = self._path_left(place)
        here, left = nearest_on_segment(place, path[0], path[1]), self.lookahead
        is_on_line = math.dist(place, here) <= self.reach
        for i, waypoint in enumerate(path[1:]):
            length = math.dist(here, waypoint)
            if length > left:
                return np.asarray(here + left / length * (waypoint - here))
            here, left = waypoint, left - length
            # a robot off the line has to come near the waypoint first
            if not is_on_line or not _goes_on(path[1] - path[0], path[i + 1 : i + 3]):
                break
        return here

    def _path_left(self, place: Floats) -> Floats:
        """Return the last waypoint and those to come; where one is reached, move on to the next."""
        points, progress = np.asarray(self.waypoints), self._progress
        if self._motion.is_new:
            progress.heading_for, progress.last = 0, place
        while (
            progress.heading_for < len(points) - 1
            and math.dist(place, points[progress.heading_for]) <= self.reach
        ):
            progress.last = points[progress.heading_for]
            progress.heading_for += 1
        return np.vstack((progress.last, points[progress.heading_for :]))


def _goes_on(line: Floats, leg: Floats) -> bool:
    """Return whether there is a next leg, and within 45 degrees of the line."""
    if len(leg) < 2:
        return False
    on = leg[1] - leg[0]
    # a . b = |a| |b| cos(angle)
    return bool(line @ on > math.cos(math.pi / 4) * math.hypot(*line) * math.hypot(*on))
