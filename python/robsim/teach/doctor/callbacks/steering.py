"""Which way a controller steers, from several places and headings, and what that tells of it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np

from robsim._core import wrap_angle
from robsim.base.check_report import Problem
from robsim.base.checks import Floats
from robsim.teach.doctor._errors import problem_of
from robsim.teach.doctor._trial import EstimatorUnderTest, Trial
from robsim.teach.doctor.callbacks.scenes import CENTRE, Place, Setting

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

_CANNOT_BE_TOLD = (
    "whether it steers the right way cannot be told: its steering points to no single place"
)

_LONG_WAY = (
    "where its heading is beyond +-pi from the one that it aims at, it turns the long way round: "
    "for a line or a path that may be meant; else wrap the heading error, "
    "robsim.wrap_angle(wanted - heading)"
)

# What a wrong formula makes of a direction, undone; the sentence says what is wrong.
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
    """The voltages of a controller for a robot that stands at a place, by its heading.

    Attributes
    ----------
    place : array (2,)
        x, y (px).
    headings : array (n,)
        Headings within -pi..pi, increasing; the last one is next to the first.
    turn : array (n,)
        u1 - u2 (V); above 0 = it turns to the right, so that the heading increases.
    aims : list of (heading, drive)
        Where it turns from both sides, and u1 + u2 there.
    turns_away_at : list of float
        The headings from which it turns to both sides.
    """

    place: Floats
    headings: Floats
    turn: Floats
    aims: list[tuple[float, float]]
    turns_away_at: list[float]

    @property
    def direction(self) -> float | None:
        """Where it drives to, forwards if it can; None = to no single direction."""
        ways = {drive < 0: wrap_angle(h + math.pi * (drive < 0)) for h, drive in self.aims}
        if not self.aims or len(self.aims) != len(ways):
            return None
        return ways.get(False, ways.get(True))


def steering_findings(
    controller: EstimatorUnderTest, usual: Trial, setting: Setting
) -> Iterator[Problem | str]:
    """Yield what is wrong with the way in which a controller turns, and what cannot be told.

    Parameters
    ----------
    controller : EstimatorUnderTest
        The controller.
    usual : Trial
        A long trial of it.
    setting : Setting
        Where it is tried.
    """
    steerings = []
    for place in _PLACES:
        steering = _steering_at(controller, place, setting)
        if isinstance(steering, Problem):
            yield steering
            return
        steerings.append(steering)
    wrong = _not_wrapped(controller, steerings)
    if wrong is not None:
        # Along a line it is u1 - u2 = -a y - b heading, which is right near the line.
        yield wrong if _has_goal(steerings) else _LONG_WAY
        return
    yield from _kicks(controller, setting)
    yield from _goal_findings(controller, steerings, usual)


def _steering_at(
    controller: EstimatorUnderTest, place: Place, setting: Setting
) -> _Steering | Problem:
    here = setting.place(place)

    def voltages(heading: float) -> Floats:
        scene = setting.turned(_standing(here), place, [heading] * _STEPS)
        trial = controller.try_in(scene)
        if trial.error is not None:
            raise _Failed(problem_of(controller, trial))
        return np.asarray(trial.outputs[-1])

    def turn(heading: float) -> float:
        u = voltages(heading)
        return float(u[0] - u[1])

    headings = (np.arange(_HEADINGS) + 0.5) * 2 * np.pi / _HEADINGS - np.pi
    aims, away = [], []
    try:
        turns = np.array([turn(heading) for heading in headings])
        for i, after in enumerate(np.roll(turns, -1)):
            before = turns[i]
            if min(abs(before), abs(after)) < _SMALL or before * after > 0:
                continue
            # the heading at which the robot turns neither way
            low, high = headings[i], headings[i] + 2 * np.pi / _HEADINGS
            for _ in range(_BISECTIONS):
                middle = (low + high) / 2
                low, high = (middle, high) if turn(middle) * before > 0 else (low, middle)
            heading = wrap_angle((low + high) / 2)
            if before > 0:
                aims.append((heading, float(voltages(heading).sum())))
            else:
                away.append(heading)
    except _Failed as failed:
        return failed.problem
    return _Steering(np.array(here), headings, turns, aims, away)


class _Failed(Exception):
    """A controller has failed where the robot stands; `problem` says how."""

    def __init__(self, problem: Problem) -> None:
        super().__init__(problem.sentence)
        self.problem = problem


def _standing(place: Place | Floats) -> str:
    return f"robot stands at ({place[0]:.0f}, {place[1]:.0f})"


def _not_wrapped(controller: EstimatorUnderTest, steerings: list[_Steering]) -> Problem | None:
    """Return whether the robot turns the long way round where its heading jumps.

    With one aim, the heading from which it turns to both sides is opposite to it; without wrapping
    it is +-pi, wherever the aim is.
    """
    telling = [one for one in steerings if len(one.aims) == 1 and abs(one.aims[0][0]) > _NEAR]
    wrong = [one for one in telling if _turns_away_at_the_jump(one)]
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


def _turns_away_at_the_jump(steering: _Steering) -> bool:
    within = np.pi / _HEADINGS
    return len(steering.turns_away_at) == 1 and np.pi - abs(steering.turns_away_at[0]) < within


def _kicks(controller: EstimatorUnderTest, setting: Setting) -> Iterator[Problem]:
    """Yield whether the voltages jump for a step when a robot that is turned crosses +-pi."""
    headings = np.radians(np.arange(24) * 5.0 + 122.5)
    crossing, kicks = 12, []  # the first step beyond +-pi, either way round
    for place, way in product(_PLACES[:3], (1, -1)):
        scene = setting.turned("robot turns past +-pi", place, way * headings)
        trial = controller.try_in(scene)
        if trial.error is not None:
            yield problem_of(controller, trial)
            return
        turn = trial.outputs[:, 0] - trial.outputs[:, 1]
        changes = abs(np.diff(turn[4:]))
        at = crossing - 5  # the change of the crossing
        others = np.delete(changes, (at, at + 1)).max()
        returns = abs(turn[crossing + 5] - turn[crossing - 1]) < 0.4 * changes[at]
        if changes[at] > max(_KICK, 5 * others) and returns:
            kicks.append(changes[at])
    if len(kicks) >= 2:
        yield Problem(
            kind="heading not wrapped",
            sentence=f"u1 - u2 jumps by {max(kicks):.2g} V for a moment when the heading passes "
            "+-pi: wrap the difference of two headings, robsim.wrap_angle(new - old)",
            situation=scene.name,
            k=crossing,
            line=controller.line,
        )


def _goal_findings(
    controller: EstimatorUnderTest, steerings: list[_Steering], usual: Trial
) -> Iterator[Problem | str]:
    places, directions = _known(steerings)
    if len(places) < 4:
        yield _CANNOT_BE_TOLD
        return
    met = _meeting_point(places, np.array(directions))
    if met is not None:
        goal, way = met
        if way > 0:
            yield from _goal_not_reached(goal, usual)
        else:
            yield Problem(
                kind="turns away",
                sentence=f"from everywhere it turns its back on ({goal[0]:.0f}, {goal[1]:.0f}) and "
                "drives away: left and right are exchanged, or a sign is wrong; u1 is the left "
                "motor, and a faster left wheel turns the robot to the right, to larger headings",
                situation=_standing(places[0]),
                line=controller.line,
            )
        return
    for undone, kind, sentence in MISTAKES:
        met = _meeting_point(places, np.array([undone(direction) for direction in directions]))
        if met is not None:
            x, y = met[0]
            yield Problem(
                kind=kind,
                sentence=f"{sentence}; it seems to mean the point ({x:.0f}, {y:.0f})",
                situation=_standing(places[0]),
                line=controller.line,
            )
            return
    yield _CANNOT_BE_TOLD


def _known(steerings: list[_Steering]) -> tuple[Floats, list[float]]:
    """Return the places from which it drives to a single direction, and the directions."""
    known = [(one.place, one.direction) for one in steerings if one.direction is not None]
    return np.array([place for place, _ in known]), [d for _, d in known if d is not None]


def _has_goal(steerings: list[_Steering]) -> bool:
    """Return whether it steers to one place, be it by a wrong formula, or to one heading."""
    places, directions = _known(steerings)
    if directions and np.ptp(wrap_angle(np.array(directions) - directions[0])) < _PARALLEL:
        return True
    formulas = [lambda direction: direction, *(undone for undone, *_ in MISTAKES)]
    return len(places) >= 3 and any(
        _meeting_point(places, np.array([undone(one) for one in directions])) is not None
        for undone in formulas
    )


def _meeting_point(places: Floats, directions: Floats) -> tuple[Floats, int] | None:
    """Return where lines meet, and whether the directions lead to it (1) or away from it (-1)."""
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


def _goal_not_reached(goal: Floats, usual: Trial) -> Iterator[str]:
    distances = np.linalg.norm(usual.trace.pose_true[:, :2] - goal, axis=1)
    if distances.min() > _COMES_NEAR:
        yield (
            f"it turns towards ({goal[0]:.0f}, {goal[1]:.0f}), but in {len(distances)} steps comes "
            f"no nearer than {distances.min():.0f} px"
        )
