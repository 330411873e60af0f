"""Faults in the worst drive of a controller on the way to its goal."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from robsim._core import wrap_angle
from robsim.base.check_report import Problem
from robsim.base.checks import Floats
from robsim.base.report import percent
from robsim.simulation.slots import RobotSlots
from robsim.teach.doctor.callbacks.steering import MISTAKES
from robsim.teach.doctor.task_checks.seen_run import SeenRun
from robsim.teach.tasks.definition import Task
from robsim.teach.tasks.solutions import Solution
from robsim.teach.tasks.trial import TaskTrial, try_solution

_SLOT = RobotSlots.control.name
_OWN = "robsim_own_control"  # the module of the controller
_RUNS = 3
_ARRIVES = 40.0  # px, from the goal
_HEADINGS = ("-heading", f"{np.pi / 2} - heading")  # each undoes a mistake of MISTAKES


_EXCHANGED = f"""
from {_OWN} import control as own


def control(step):
    left, right = own(step)
    return right, left
"""


# A robot in a mirror: the heading is another one, and left is right.
_MIRRORED = f"""
import robsim
from {_OWN} import control as own


def control(step):
    seen = step.measurement
    if seen is not None:
        x, y, heading = seen.pose
        seen = robsim.Measurement((x, y, {{heading}}), covariance=seen.covariance)
    left, right = own(
        robsim.Step(k=step.k, t=step.t, dt=step.dt, last_u=step.last_u[::-1], measurement=seen)
    )
    return right, left
"""


_LIMITED = f"""
import numpy as np
from {_OWN} import control as own


def control(step):
    return np.clip(own(step), -{{limit}}, {{limit}})
"""


def _undone() -> Iterator[tuple[str, str, str]]:
    yield (
        "motors exchanged",
        "left and right are exchanged: u1 is the left motor, and a faster left wheel turns the "
        "robot to the right, to larger headings. With exchanged voltages it reaches the goal",
        _EXCHANGED,
    )
    for (_, kind, sentence), heading in zip(MISTAKES, _HEADINGS, strict=True):
        code = _MIRRORED.format(heading=heading)
        yield kind, f"{sentence}. With that undone it reaches the goal", code


def _trial(task: Task, solution: Solution, code: str) -> TaskTrial:
    files = {**solution.files, _OWN: solution.files[_SLOT], _SLOT: code.encode()}
    return try_solution(task, replace(solution, files=files), runs=_RUNS, progress=False)


_AT_REST = 0.5  # px per step
_MOVES = 1.0  # px per step
_LAST = 0.2  # of a run
_LOST = 100.0  # px from the goal, at the end.
_FARTHER = 1.4  # times the way of the reference
_SLOWER = 0.7  # times the speed of the reference
_HELD = 0.8  # of the steps in which the robot is not seen
_NO_VOLTAGE = 1e-9  # V


class _Drive(SeenRun):
    """A drive to a goal, or along waypoints, next to the reference."""

    @property
    def goals(self) -> Floats:
        """The goal (3,) or (2,), or the waypoints (N, 2)."""
        assert self.task.goals is not None
        return self.task.goals

    @property
    def poses(self) -> Floats:
        return self.trace.pose_true

    @property
    def waypoints(self) -> Floats:
        """The waypoints, or the goal alone, (N, 2)."""
        return np.atleast_2d(self.goals)[:, :2]

    @property
    def distances(self) -> Floats:
        """The distance from the last goal, step by step (px)."""
        return np.asarray(np.hypot(*(self.poses[:, :2] - self.waypoints[-1]).T))

    @property
    def last_steps(self) -> Floats:
        """The length of each of the last steps (px)."""
        return _step_lengths(self.poses)[-round(_LAST * len(self.poses)) :]

    @property
    def is_at_rest(self) -> bool:
        return float(np.mean(self.last_steps)) < _AT_REST


def drive_findings(run: SeenRun) -> Iterator[Problem]:
    if run.task.goals is None:
        return
    if run.trial.rule is not None:
        yield _against_the_rules(run.trial, run.solution)
        return
    drive = _Drive(run.trial, run.solution, run.trace, run.reference)
    cause = next((found for look in _LOOKS if (found := look(drive))), None)
    yield from filter(None, (cause, _waits(drive)))


def _against_the_rules(trial: TaskTrial, solution: Solution) -> Problem:
    limit = float(trial.task.values.get("MAXIMUM_VOLTAGE", 1.0))
    rest = _trial(trial.task, solution, _LIMITED.format(limit=limit))
    points = f": then it has {percent(rest.points)} of the points" if rest.limits else ""
    return Problem(
        kind="against the rules",
        sentence=f"{trial.rule}; limit them, numpy.clip(u, -{limit:g}, {limit:g}){points}",
        situation=f"run {trial.broken[0]} of the task",
    )


def _lost(drive: _Drive) -> Problem | None:
    goal = drive.waypoints[-1]
    if drive.distances[-1] < _LOST:
        return None
    for kind, sentence, code in _undone():
        trace = _trial(drive.task, drive.solution, code).trace
        if trace is not None and np.hypot(*(trace.pose_true[-1, :2] - goal)) < _ARRIVES:
            return drive.problem(kind, sentence)
    return None


def _elsewhere(drive: _Drive) -> Problem | None:
    last = drive.poses[-round(_LAST * len(drive.poses)) :, :2]
    stays = np.hypot(*(last - last.mean(axis=0)).T).max() < _LOST / 2
    if drive.goals.ndim > 1 or drive.distances[-1] < _LOST or not stays:
        return None
    place, goal = (f"({x:.0f}, {y:.0f})" for x, y in (last[-1], drive.waypoints[0]))
    return drive.problem(
        "another goal",
        f"it stays at {place}, {drive.distances[-1]:.0f} px from the goal. The goal of this task "
        f"is {goal}: from task import GOAL",
    )


def _stands(drive: _Drive) -> Problem | None:
    if abs(drive.trace.u).max() > _NO_VOLTAGE:
        return None
    return drive.problem("never drives", "it never drives: its voltages are (0, 0)")


def _swings(drive: _Drive) -> Problem | None:
    own, others = (
        float(_step_lengths(poses).sum()) for poses in (drive.poses, drive.reference.pose_true)
    )
    is_near = drive.distances.min() < _LOST / 2
    if own < _FARTHER * others or drive.is_at_rest or not is_near:
        return None
    return drive.problem(
        "does not brake",
        f"it drives {own:.0f} px where the reference drives {others:.0f} px, and at the end still "
        f"moves by {np.mean(drive.last_steps):.1f} px per step, {drive.distances[-1]:.0f} px from "
        "the goal: it drives past it again and again. Brake in time: the speed counts as well as "
        "the distance, such as u = k1 distance - k2 speed",
    )


def _stops_short(drive: _Drive) -> Problem | None:
    tolerance = drive.tolerance("POSITION_TOLERANCE", 20.0)
    if drive.goals.ndim > 1 or not drive.is_at_rest or drive.distances[-1] <= tolerance:
        return None
    return drive.problem(
        "stops short",
        f"it stands still {drive.distances[-1]:.0f} px from the goal, too far to be parked: "
        f"parked means within {tolerance:g} px. Does it stop too early, or is friction stronger "
        "than its small voltage?",
        k=_last_move(drive.poses),
    )


def _faces_elsewhere(drive: _Drive) -> Problem | None:
    if drive.goals.shape != (3,) or drive.distances[-1] > drive.tolerance(
        "POSITION_TOLERANCE", 20.0
    ):
        return None
    error = float(wrap_angle(drive.poses[-1, 2] - drive.goals[2]))
    if abs(error) <= drive.tolerance("HEADING_TOLERANCE", 0.15):
        return None
    return drive.problem(
        "heading of the goal",
        f"it reaches the position, but faces {np.degrees(drive.poses[-1, 2]):.0f} degrees at the "
        f"end, and not the goal's {np.degrees(drive.goals[2]):.0f}: turn there on the spot, by "
        "the heading error, robsim.wrap_angle(goal - heading)",
    )


def _skips(drive: _Drive) -> Problem | None:
    radius = drive.tolerance("WAYPOINT_RADIUS", 25.0)
    if drive.goals.ndim == 1:
        return None
    apart = np.hypot(*(drive.poses[:, None, :2] - drive.waypoints).T)  # (waypoints, steps)
    missed = np.flatnonzero(apart.min(axis=1) > radius)
    later = missed[missed < len(apart) - 1]
    if not len(later) or apart[later[0] + 1 :].min() > radius:
        return None
    number = int(later[0])
    return drive.problem(
        "cuts corners",
        f"it passes waypoint {number} of {len(apart)} at a distance of {apart[number].min():.0f} "
        f"px, and continues to the next: a waypoint is reached within {radius:g} px",
        k=int(apart[number].argmin()),
    )


def _slow(drive: _Drive) -> Problem | None:
    own, others = (_speed(poses) for poses in (drive.poses, drive.reference.pose_true))
    if not own < _SLOWER * others:
        return None
    return drive.problem(
        "slow",
        f"while it drives it moves by {own:.1f} px per step, the reference by {others:.1f}: so it "
        "needs more time, or more than the run has",
    )


def _overshoots(drive: _Drive) -> Problem | None:
    tolerance = drive.tolerance("POSITION_TOLERANCE", 20.0)
    inside = np.flatnonzero(drive.distances <= tolerance)
    if drive.goals.ndim > 1 or not len(inside):
        return None
    after = drive.distances[inside[0] :]
    if after.max() <= 1.5 * tolerance:
        return None
    return drive.problem(
        "overshoots",
        f"it reaches the goal, and then leaves it by {after.max():.0f} px: brake in time, the "
        "speed counts as well as the distance",
        k=int(inside[0] + after.argmax()),
    )


_LOOKS = (
    *(_stands, _lost, _elsewhere, _swings, _stops_short),
    *(_faces_elsewhere, _skips, _slow, _overshoots),
)


def _waits(drive: _Drive) -> Problem | None:
    trace = drive.trace
    is_unseen = ~trace.seen
    stands = np.asarray((abs(trace.u) <= _NO_VOLTAGE).all(axis=1))
    if is_unseen.sum() < 5 or stands[is_unseen].mean() < _HELD or stands[~is_unseen].mean() > 0.5:
        return None
    return drive.problem(
        "waits unseen",
        f"its voltages are 0 in {int(stands[is_unseen].sum())} of {int(is_unseen.sum())} steps in "
        "which the robot is not seen: drive on by the last pose and the model, which costs less "
        "time",
        k=int(np.flatnonzero(is_unseen & stands)[0]),
    )


def _step_lengths(poses: Floats) -> Floats:
    return np.asarray(np.hypot(*np.diff(poses[:, :2], axis=0).T))


def _speed(poses: Floats) -> float:
    """Return the median distance of a step in which it drives (px)."""
    lengths = _step_lengths(poses)
    moving = lengths[lengths > _MOVES]
    return float(np.median(moving)) if len(moving) else 0.0


def _last_move(poses: Floats) -> int:
    moving = np.flatnonzero(_step_lengths(poses) > _MOVES)
    return int(moving[-1]) + 1 if len(moving) else 0
