"""Feedback controllers to a point and along waypoints, for ``Simulation(control=...)``."""

from __future__ import annotations

import math
from dataclasses import KW_ONLY, dataclass, field, fields
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from robsim._core import Step, atan2, cos, hypot, sin, wrap_angle
from robsim.base.checks import Floats, as_float_array, check_float, check_heading
from robsim.base.text import quoted

MAXIMUM_COORDINATE = 1e6  # px


def dot(a: Floats, b: Floats) -> float:
    """Return a . b for vectors (2,): numpy's product differs in the last bit between processors."""
    return float(a[0] * b[0] + a[1] * b[1])


def nearest_on_segment(position: Floats, start: Floats, end: Floats) -> Floats:
    """Return the point (2,) of the segment start -> end closest to a position (2,)."""
    along = end - start
    square = dot(along, along)
    # fraction = (position - start) . (end - start) / |end - start|^2, within 0..1
    fraction = dot(position - start, along) / square if square else 0.0
    return np.asarray(start + min(max(fraction, 0.0), 1.0) * along)


def as_waypoints(waypoints: ArrayLike) -> Floats:
    """Return waypoints as a read-only copy, an array (N, 2)."""
    expected = "waypoints must be an array (N, 2) of positions x, y in px, N at least 1"
    try:
        points = np.array(waypoints)
    except ValueError:
        raise ValueError(f"{expected}, got {quoted(waypoints)}") from None
    if points.dtype.kind not in "iuf":
        raise TypeError(f"{expected}, got {quoted(waypoints)}")
    if points.ndim != 2 or points.shape[1] != 2 or not len(points):
        hint = ": for a single one write [(x, y)]" if points.shape == (2,) else ""
        raise ValueError(f"{expected}, got shape {points.shape}{hint}")
    if not (np.abs(points) <= MAXIMUM_COORDINATE).all():  # NaN fails, too
        raise ValueError(
            f"waypoints must be finite numbers within +-{MAXIMUM_COORDINATE:g} px, "
            f"got {quoted(waypoints)}"
        )
    points = points.astype(np.float64)
    points.setflags(write=False)
    return points


def as_pose(pose: ArrayLike, name: str = "pose") -> Floats:
    """Return a pose x, y (px), heading (rad) as an array (3,)."""
    expected = f"{name} must be an array (3,): x, y in px, heading in rad"
    try:
        values = np.array(pose)
    except ValueError:
        raise ValueError(f"{expected}, got {quoted(pose)}") from None
    if values.dtype.kind not in "iuf":
        raise TypeError(f"{expected}, got {quoted(pose)}")
    if values.shape != (3,):
        raise ValueError(f"{expected}, got shape {values.shape}")
    if not (np.abs(values) <= MAXIMUM_COORDINATE).all():  # NaN fails, too
        raise ValueError(
            f"{name} must be finite, within {MAXIMUM_COORDINATE:g} px, got {quoted(pose)}"
        )
    check_heading(name, values[2])
    return values.astype(np.float64)


def as_goals(goals: ArrayLike) -> Floats:
    """Return the goals of a robot: a position (2,), a pose (3,) or waypoints (N, 2)."""
    expected = "goals must be a position (2,), a pose (3,) or waypoints (N, 2), finite, in px"
    points = as_float_array("goals", goals)
    is_one, is_path = points.shape in ((2,), (3,)), points.ndim == 2 and points.shape[1] == 2
    if not (is_one or is_path) or not len(points) or not np.isfinite(points).all():
        raise ValueError(f"{expected}, got {quoted(goals)}")
    return points


class _Motion:
    """The last known pose and the low-pass filtered velocity of the robot."""

    smoothing = 0.5  # s: time constant of the low-pass filter of the velocity
    memory = 2.0  # s: after a longer gap the velocity starts from 0

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Reset the memory of the run."""
        self.k = -1
        self.is_new = True  # the newest pose is the first one
        self.pose = np.zeros(3)  # x, y (px), heading (rad)
        self.velocity = np.zeros(3)  # of x, y (px/s) and heading (rad/s)

    def update(self, step: Step) -> bool:
        """Take the estimated pose of a step, or else the measured one; False if it has neither."""
        try:
            k = step.k
        except AttributeError:
            raise TypeError(
                f"step must be a Step, got {quoted(step)}; to make one by hand, use "
                "robsim.Step(measurement=(x, y, heading))"
            ) from None
        if k == 0 or k < self.k:
            self.reset()
        seen = step.estimate or step.measurement
        if seen is None:
            return False
        gap = (step.k - self.k) * step.dt
        self.is_new = self.k < 0
        if self.is_new or gap > self.memory:
            self.velocity = np.zeros(3)
        elif gap > 0:
            displacement = seen.pose - self.pose
            displacement[2] = wrap_angle(displacement[2])
            # v(k) = v(k-1) + gap/(gap + smoothing) (displacement/gap - v(k-1))
            change = displacement - gap * self.velocity
            self.velocity = self.velocity + change / (gap + self.smoothing)
        self.k, self.pose = step.k, seen.pose
        return True


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class _Drive:
    """The control law towards a goal, shared by both controllers, and its options."""

    maximum_voltage: float = 1.0  # V
    maximum_speed: float = 40.0  # px/s
    distance_gain: float = 0.5  # px/s per px
    speed_gain: float = 0.1  # V per px/s
    heading_gain: float = 0.7  # V per rad
    turn_gain: float = 0.4  # V per rad/s
    minimum_voltage: float = 0.3  # V
    _motion: _Motion = field(default_factory=_Motion, init=False)

    _remembers_run: ClassVar = True
    needs: ClassVar = ("measurement", "estimate")  # one of them, to know where the robot is

    def __post_init__(self) -> None:
        for name, unit in {
            "maximum_voltage": "V",
            "maximum_speed": "px/s",
            "distance_gain": "px/s per px",
            "speed_gain": "V per px/s",
            "heading_gain": "V per rad",
            "turn_gain": "V per rad/s",
            "minimum_voltage": "V",
        }.items():
            check_float(name, getattr(self, name), unit, minimum=0)

    def _options(self) -> dict[str, Any]:
        """Return the options in the order of the call: positional arguments first."""
        shown = sorted((f for f in fields(self) if f.init), key=lambda f: bool(f.kw_only))
        return {f.name: getattr(self, f.name) for f in shown}

    def _key(self) -> tuple[type, bytes]:
        return type(self), np.concatenate([*map(np.ravel, self._options().values())]).tobytes()

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, _Drive):
            return NotImplemented
        return self._key() == other._key()  # the memory of a run does not count

    def __hash__(self) -> int:
        return hash(self._key())

    def __repr__(self) -> str:
        options = ", ".join(f"{name}={value!r}" for name, value in self._options().items())
        return f"{type(self).__name__}({options})"

    def _towards(self, goal: Floats) -> tuple[float, float]:
        """Return the voltages (u1, u2) that drive the robot to a position and stop it there."""
        position, heading = self._motion.pose[:2], self._motion.pose[2]
        velocity, turn_rate = self._motion.velocity[:2], self._motion.velocity[2]
        # wanted velocity = distance_gain (goal - position), at most maximum_speed
        wanted = self.distance_gain * (goal - position)
        wanted *= min(1.0, self.maximum_speed / max(hypot(*wanted), 1e-9))
        # force = speed_gain (wanted velocity - velocity): it also brakes a sideways slide
        force = self.speed_gain * (wanted - velocity)
        if hypot(*force) < self.minimum_voltage:
            return 0.0, 0.0
        # the components of the force along the heading and to its right
        ahead = force[0] * cos(heading) + force[1] * sin(heading)
        right = force[1] * cos(heading) - force[0] * sin(heading)
        # error = angle from the robot's axis to the force, at the nearer end of the axis
        error = atan2(math.copysign(1, ahead) * right, abs(ahead))
        # turn = heading_gain error - turn_gain turn rate; the remaining voltage drives
        limit = self.maximum_voltage
        turn = _limited(self.heading_gain * error - self.turn_gain * turn_rate, limit)
        drive = _limited(ahead, limit - abs(turn))
        # u1 = drive + turn, u2 = drive - turn: a faster left wheel turns the robot to the right
        return _limited(drive + turn, limit), _limited(drive - turn, limit)


def _limited(value: float, limit: float) -> float:
    return float(min(max(value, -limit), limit))


@dataclass(frozen=True, eq=False, repr=False)
class GoToPoint(_Drive):
    """Drives the robot to a point, forwards or backwards, and stops it there.

    The controller uses the estimated pose if a state estimator runs, otherwise the measured pose.
    The voltages are (0, 0) while the robot is not seen. The controller stores the last pose: create
    a new controller for each simulation.

    Parameters
    ----------
    x, y : float
        The point (work-area px).
    maximum_voltage : float
        Maximum voltage of each motor, forwards and backwards (V). Turning has priority over
        driving.
    maximum_speed : float
        Maximum of the wanted speed (px/s). The default robot drives at 33 px/s with 1 V.
    distance_gain : float
        Wanted speed per distance from the goal (px/s per px): large = brakes late.
    speed_gain : float
        Voltage per velocity error (V per px/s).
    heading_gain : float
        Voltage per heading error (V per rad): turns the robot's axis to the wanted force.
    turn_gain : float
        Voltage per turn rate (V per rad/s): damps the turning.
    minimum_voltage : float
        Dead zone: for a smaller force the voltages are 0 (V). The robot may stop at a distance of
        ``minimum_voltage / (speed_gain * distance_gain)`` from the goal; by default, this distance
        is 6 px.

    Raises
    ------
    TypeError, ValueError
        If a value is not a finite number, or an option is below 0.

    Notes
    -----
    The default robot slides sideways, like a hovercraft: a turn of the robot does not turn its
    path. The control law therefore uses forces. The distance gives the wanted velocity, the
    velocity error gives a force, and the robot turns its axis towards that force::

        wanted velocity = distance_gain (goal - position), at most maximum_speed
        force = speed_gain (wanted velocity - velocity);
        turn = heading_gain (direction of the force - heading) - turn_gain turn rate
        drive = component of the force along the heading, at most maximum_voltage - |turn|
        u1 = drive + turn,  u2 = drive - turn

    The velocity and the turn rate are low-pass filtered differences of the poses.

    Examples
    --------
    >>> sim = robsim.Simulation(measure=True, control=robsim.GoToPoint(900, 300), seed=1)
    >>> trace = sim.run(200)
    >>> trace.pose_true[-1, :2].round()
    array([903., 298.])
    """

    x: float
    y: float

    def __post_init__(self) -> None:
        super().__post_init__()
        check_float("x", self.x, "px")
        check_float("y", self.y, "px")

    def __call__(self, step: Step) -> tuple[float, float]:
        """Return the voltages (u1, u2) of a step."""
        if not self._motion.update(step):
            return 0.0, 0.0
        return self._towards(np.array([self.x, self.y]))


@dataclass
class _Progress:
    """The progress of a controller along its waypoints."""

    next_waypoint: int = 0
    last: Floats = field(default_factory=lambda: np.zeros(2))  # where its segment begins


@dataclass(frozen=True, eq=False, repr=False)
class FollowPath(_Drive):
    """Drives the robot along straight lines from waypoint to waypoint and stops it at the last one.

    The first line begins where the robot is first seen in a run. The controller works like
    `GoToPoint`, with a goal on the path ahead of the robot. At a corner sharper than 45 degrees the
    goal stops, so that the robot slows down there.

    Parameters
    ----------
    waypoints : array (N, 2)
        Positions (x, y) in work-area px, in the order of travel.
    waypoint_radius : float
        Distance at which a waypoint counts as reached (px).
    lookahead : float
        Distance along the path from the point nearest to the robot to the goal (px): small = slow
        and close to the line.
    maximum_voltage, maximum_speed, minimum_voltage : float
        As for `GoToPoint`.
    distance_gain, speed_gain, heading_gain, turn_gain : float
        As for `GoToPoint`.

    Raises
    ------
    TypeError, ValueError
        If the waypoints are not finite numbers of shape (N, 2), or as for `GoToPoint`.

    Examples
    --------
    >>> corners = [(400, 400), (800, 400), (800, 800), (400, 800), (400, 400)]
    >>> sim = robsim.Simulation(measure=True, control=robsim.FollowPath(corners), seed=1)
    >>> score = robsim.score_path(sim.run(500), corners)
    >>> score.reached, round(score.rmse, 1)
    (5, 4.2)
    """

    waypoints: ArrayLike
    _: KW_ONLY
    waypoint_radius: float = 20.0
    lookahead: float = 60.0
    _progress: _Progress = field(default_factory=_Progress, init=False)

    def __post_init__(self) -> None:
        super().__post_init__()
        check_float("waypoint_radius", self.waypoint_radius, "px", minimum=0)
        check_float("lookahead", self.lookahead, "px", minimum=0)
        object.__setattr__(self, "waypoints", as_waypoints(self.waypoints))

    @property
    def next_waypoint(self) -> int:
        """Index of the current target waypoint; the index stays at the last waypoint."""
        return self._progress.next_waypoint

    def __call__(self, step: Step) -> tuple[float, float]:
        """Return the voltages (u1, u2) of a step."""
        if not self._motion.update(step):
            return 0.0, 0.0
        return self._towards(self._goal(self._motion.pose[:2]))

    def _goal(self, position: Floats) -> Floats:
        """Return the position to drive to now: `lookahead` ahead along the path."""
        path = self._remaining_path(position)
        goal, remaining = nearest_on_segment(position, path[0], path[1]), self.lookahead
        is_on_line = hypot(*(position - goal)) <= self.waypoint_radius
        for i, waypoint in enumerate(path[1:]):
            length = hypot(*(waypoint - goal))
            if length > remaining:
                return np.asarray(goal + remaining / length * (waypoint - goal))
            goal, remaining = waypoint, remaining - length
            # a robot off the line has to come near the waypoint first
            if not is_on_line or not _is_smooth_turn(path[1] - path[0], path[i + 1 : i + 3]):
                break
        return goal

    def _remaining_path(self, position: Floats) -> Floats:
        """Return the last waypoint reached and those to come, and update the progress."""
        points, progress = np.asarray(self.waypoints), self._progress
        if self._motion.is_new:
            progress.next_waypoint, progress.last = 0, position
        while (
            progress.next_waypoint < len(points) - 1
            and hypot(*(position - points[progress.next_waypoint])) <= self.waypoint_radius
        ):
            progress.last = points[progress.next_waypoint]
            progress.next_waypoint += 1
        return np.vstack((progress.last, points[progress.next_waypoint :]))


def _is_smooth_turn(line: Floats, leg: Floats) -> bool:
    """Return whether there is a next leg, and within 45 degrees of the line."""
    if len(leg) < 2:
        return False
    following = leg[1] - leg[0]
    # a . b = |a| |b| cos(angle)
    limit = math.sqrt(0.5) * hypot(*line) * hypot(*following)
    return bool(dot(line, following) > limit)
