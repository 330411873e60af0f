"""The direction in which a controller steers, from several places and headings."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from robsim._core import wrap_angle
from robsim.base.check_report import Problem
from robsim.base.checks import Floats
from robsim.teach.doctor._errors import problem_of
from robsim.teach.doctor._trial import EstimatorUnderTest, Trial
from robsim.teach.doctor.callbacks.scenes import CENTRE, Place, Setting
from robsim.teach.doctor.callbacks.single_calls import Failed

# Without any symmetry: the directions to a point on a wall or in the middle must differ.
_PLACES = ((250.0, 310.0), (930.0, 240.0), (880.0, 930.0), (330.0, 870.0), (590.0, 420.0))  # px
_HEADINGS = 18
_BISECTIONS = 4
_STEPS = 2  # at rest: differences of poses have become 0
_SMALL = 1e-3  # V
_MEETS = 20.0  # px, rms distance of the directions from the point where they meet
_FARTHEST = 2500.0  # px from the middle: farther away, directions are as good as parallel
_NEAR = math.radians(45)
_PARALLEL = math.radians(10)
_KICK = 0.1  # V
_COMES_NEAR = 100.0  # px
_LAST = 200  # steps, in which it must stand still
_MOVES, _TURNS = 0.5, 1.0  # px per step, degrees per step

_CANNOT_BE_TOLD = "its steering points to no single place, so the check cannot verify its direction"

_LONG_WAY = (
    "where its heading is beyond +-pi from its aim, it turns the long way round: "
    "for a line or a path this may be intended; else wrap the heading error, "
    "robsim.wrap_angle(wanted - heading)"
)

# The inverse of a wrong formula for a direction, its kind, and the sentence on the mistake.
MISTAKES: tuple[tuple[Callable[[float], float], str, str], ...] = (
    (
        lambda direction: -direction,
        "y axis",
        "it turns as if the y axis pointed up: y points down, and headings are clockwise on the "
        "image, so that the direction to a point is arctan2(y_goal - y, x_goal - x)",
    ),
    (
        lambda direction: math.pi / 2 - direction,
        "swapped arguments",
        "it turns as if x and y were exchanged: the direction to a point is "
        "arctan2(y_goal - y, x_goal - x), with y first",
    ),
)


@dataclass(frozen=True)
class _Steering:
    """The turns of a robot that stands at a place, by its heading."""

    place: Floats  # x, y (px)
    aims: list[tuple[float, float]]  # the headings to which it turns from both sides, u1 + u2 there
    turns_away_at: list[float]  # the headings from which it turns to both sides

    @property
    def direction(self) -> float | None:
        """The direction in which the robot drives, forwards if possible; None = not unique."""
        ways = {drive < 0: wrap_angle(h + math.pi * (drive < 0)) for h, drive in self.aims}
        if not self.aims or len(self.aims) != len(ways):
            return None
        return ways.get(False, ways.get(True))


def steering_findings(usual: Trial, setting: Setting) -> Iterator[Problem | str]:
    """Yield faults of a controller's turns, and doubts; `usual` is a long trial."""
    controller = usual.estimator
    try:
        steerings = [_steering_at(controller, place, setting) for place in _PLACES]
    except Failed as failed:
        yield failed.problem
        return
    wrong = _not_wrapped(controller, steerings)
    if wrong is not None:
        # Along a line it is u1 - u2 = -a y - b heading, which is right near the line.
        yield wrong if _has_goal(steerings) else _LONG_WAY
        return
    yield from _kicks(controller, setting)
    yield from _goal_findings(steerings, usual)


def _steering_at(controller: EstimatorUnderTest, place: Place, setting: Setting) -> _Steering:
    here = setting.place(place)

    def steered(heading: float) -> tuple[float, float]:
        """Return u1 - u2 and u1 + u2."""
        trial = controller.try_in(setting.turned(_standing(here), place, [heading] * _STEPS))
        if trial.error is not None:
            raise Failed(problem_of(trial))
        left, right = trial.outputs[-1]
        return float(left - right), float(left + right)

    headings = (np.arange(_HEADINGS) + 0.5) * 2 * np.pi / _HEADINGS - np.pi
    aims, away = [], []
    turns = np.array([steered(heading)[0] for heading in headings])
    for i, after in enumerate(np.roll(turns, -1)):
        before = turns[i]
        if min(abs(before), abs(after)) < _SMALL or before * after > 0:
            continue
        # the heading at which the robot turns neither way
        low, high = headings[i], headings[i] + 2 * np.pi / _HEADINGS
        for _ in range(_BISECTIONS):
            middle = (low + high) / 2
            low, high = (middle, high) if steered(middle)[0] * before > 0 else (low, middle)
        heading = wrap_angle((low + high) / 2)
        if before > 0:
            aims.append((heading, steered(heading)[1]))
        else:
            away.append(heading)
    return _Steering(np.array(here), aims, away)


def _standing(place: Place | Floats) -> str:
    return f"robot stands at ({place[0]:.0f}, {place[1]:.0f})"


def _not_wrapped(controller: EstimatorUnderTest, steerings: list[_Steering]) -> Problem | None:
    """Return a problem if the robot turns the long way round where its heading jumps.

    With one aim, the robot turns to both sides from the opposite heading; without wrapping,
    from +-pi, for any aim.
    """
    telling = [one for one in steerings if len(one.aims) == 1 and abs(one.aims[0][0]) > _NEAR]
    at_the_jump = np.pi - np.pi / _HEADINGS
    wrong = [one for one in telling if [abs(h) > at_the_jump for h in one.turns_away_at] == [True]]
    if len(wrong) < 2 or len(wrong) < 0.8 * len(telling):
        return None
    one = max(wrong, key=lambda one: min(abs(one.aims[0][0]), 2.5))
    aim = one.aims[0][0]
    # From the other side of +-pi the short way leads over it.
    start = -math.copysign(math.radians(170), aim)
    long_way = abs(aim - start)
    sides = ("right", "left") if aim > start else ("left", "right")
    return Problem(
        kind="heading not wrapped",
        sentence=f"with the heading {math.degrees(start):.0f} degrees it turns {sides[0]} by "
        f"{math.degrees(long_way):.0f} degrees to face {math.degrees(aim):.0f} degrees, and not "
        f"{sides[1]} by {360 - math.degrees(long_way):.0f}: wrap the heading error, "
        "robsim.wrap_angle(wanted - heading)",
        situation=_standing(one.place),
        line=controller.line,
    )


def _kicks(controller: EstimatorUnderTest, setting: Setting) -> Iterator[Problem]:
    """Yield a problem if the voltages jump for a step when a turned robot crosses +-pi."""
    headings = np.radians(np.arange(24) * 5.0 + 122.5)
    crossing, kicks = 12, []  # the first step beyond +-pi, either way round
    for place, way in product(_PLACES[:3], (1, -1)):
        scene = setting.turned("robot turns past +-pi", place, way * headings)
        trial = controller.try_in(scene)
        if trial.error is not None:
            yield problem_of(trial)
            return
        turn = trial.outputs[:, 0] - trial.outputs[:, 1]
        changes = abs(np.diff(turn[4:]))
        at = crossing - 5  # the change of the crossing
        others = np.delete(changes, (at, at + 1)).max()
        returns = abs(turn[crossing + 5] - turn[crossing - 1]) < 0.4 * changes[at]
        if changes[at] > max(_KICK, 5 * others) and returns:
            kicks.append(changes[at])
    if len(kicks) >= 2:
        yield trial.problem(
            "heading not wrapped",
            f"u1 - u2 jumps by {max(kicks):.2g} V for a moment when the heading passes +-pi: wrap "
            "the difference of two headings, robsim.wrap_angle(new - old)",
            crossing,
        )


def _goal_findings(steerings: list[_Steering], usual: Trial) -> Iterator[Problem | str]:
    places, directions = _known(steerings)
    if len(places) < 4:
        yield _CANNOT_BE_TOLD
        return
    met = _meeting_point(places, np.array(directions))
    if met is not None and met[1] > 0:
        (x, y), poses = met[0], usual.trace.pose_true
        distances = np.hypot(poses[:, 0] - x, poses[:, 1] - y)
        if distances.min() > _COMES_NEAR:
            yield (
                f"it turns towards ({x:.0f}, {y:.0f}), but in {len(poses)} steps comes no nearer "
                f"than {distances.min():.0f} px"
            )
        elif distances[-_LAST:].max() < _COMES_NEAR:
            yield from _unrest(poses[-_LAST:])
        return
    found = _wrong_way(places, directions, None if met is None else met[0])
    if found is None:
        yield _CANNOT_BE_TOLD
    else:
        yield replace(usual.problem(*found), situation=_standing(places[0]))


def _unrest(poses: Floats) -> Iterator[str]:
    moves = float(np.mean(np.hypot(*np.diff(poses[:, :2], axis=0).T)))
    turns = float(np.degrees(np.mean(abs(wrap_angle(np.diff(poses[:, 2]))))))
    if moves > _MOVES or turns > _TURNS:
        yield (
            f"it does not stand still at its goal: in the last {len(poses)} steps it moves by "
            f"{moves:.1f} px and turns by {turns:.0f} degrees per step; return (0, 0) where it has "
            "arrived"
        )


def _wrong_way(
    places: Floats, directions: list[float], left: Floats | None
) -> tuple[str, str] | None:
    """Return kind and sentence of a wrong way of steering; `left`: the point that it leaves."""
    if left is not None:
        return (
            "turns away",
            f"from everywhere it turns its back on ({left[0]:.0f}, {left[1]:.0f}) and drives away: "
            "left and right are exchanged, or a sign is wrong; u1 is the left motor, and a faster "
            "left wheel turns the robot to the right, to larger headings",
        )
    for undone, kind, sentence in MISTAKES:
        met = _meeting_point(places, np.array([undone(direction) for direction in directions]))
        if met is not None:
            x, y = met[0]
            return kind, f"{sentence}; its goal seems to be the point ({x:.0f}, {y:.0f})"
    return None


def _known(steerings: list[_Steering]) -> tuple[Floats, list[float]]:
    known = [(one.place, one.direction) for one in steerings if one.direction is not None]
    return np.array([place for place, _ in known]), [d for _, d in known if d is not None]


def _has_goal(steerings: list[_Steering]) -> bool:
    """Return whether it steers to one place, even by a wrong formula, or to one heading."""
    places, directions = _known(steerings)
    if directions and np.ptp(wrap_angle(np.array(directions) - directions[0])) < _PARALLEL:
        return True
    formulas = [lambda direction: direction, *(undone for undone, *_ in MISTAKES)]
    return len(places) >= 3 and any(
        _meeting_point(places, np.array([undone(one) for one in directions])) is not None
        for undone in formulas
    )


def _meeting_point(places: Floats, directions: Floats) -> tuple[Floats, int] | None:
    """Return the point where lines meet; 1 = the directions lead to it, -1 = away from it."""
    d = np.column_stack((np.cos(directions), np.sin(directions)))
    # the projection onto the normal of each line, N = I - d d'; least squares of N (goal - place)
    N = np.eye(2) - d[:, :, None] * d[:, None, :]
    normal = N.sum(axis=0)
    if np.linalg.eigvalsh(normal)[0] < 1e-3:
        return None
    goal = np.linalg.solve(normal, np.einsum("nij,nj->i", N, places))
    distances = np.linalg.norm(np.einsum("nij,nj->ni", N, goal - places), axis=1)
    along = np.sum((goal - places) * d, axis=1)
    is_far = np.linalg.norm(goal - np.array(CENTRE[:2])) > _FARTHEST
    if is_far or np.sqrt(np.mean(distances**2)) > _MEETS or len(set(np.sign(along))) > 1:
        return None
    return goal, int(np.sign(along[0]))
