"""Check whether parameters predict better than no learning at all, and find the cause.

The baseline is 2 x(k-1) - x(k-2), a robot of constant speed, which needs no parameters. The error
is the rms of phi (theta - theta_true) over all later samples, relative to the baseline. Right
estimators reach 0.01 to 0.2, as the disturbances of the drive are small.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import cached_property
from itertools import permutations
from typing import Any

import numpy as np
import numpy.typing as npt

from robsim._core import RecursiveLeastSquares, RobotModel, RobotParameters, regression
from robsim.base.check_report import Problem
from robsim.base.checks import Floats
from robsim.base.source_line import SourceLine
from robsim.teach.doctor._kept import arrays_in, attributes_of
from robsim.teach.doctor._lines import line_that_reads, line_that_sets
from robsim.teach.doctor._situations import Situation
from robsim.teach.doctor._trial import EstimatorUnderTest, Trial
from robsim.teach.doctor.gain import AXES, delays, named

DISPLACED_AT = 200  # the step
_OFFSET = (3.0, 3.0, 0.1)  # px, px, rad: far beyond the noise, so that no dead zone hides it
_VOLTS = 0.3
_WATCHED = 30  # steps
_CHANGE = 1e-9  # relative; less is rounding
_IN_PHI = 2  # steps for which a pose stands in phi
Delays = list[int | None]


class Influence:
    """The steps after which the parameters change, compared with a trial without displacement.

    The doctor repeats the drive with one displaced pose or input. A pose is part of the y of
    its step and of the phi of the next two; an input is part of the phi of the next step.
    """

    def __init__(self, usual: Trial) -> None:
        self._usual = usual

    @cached_property
    def of_input(self) -> Delays:
        """Steps until each row of the parameters changes with an input in phi; None = never."""
        u = self._usual.situation.u.copy()
        u[DISPLACED_AT - 1] += _VOLTS
        return delays(self._changed(replace(self._usual.situation, u=u)))

    @cached_property
    def of_pose(self) -> list[Delays]:
        """The same for a pose, first in y: a list for each component that is displaced."""
        return [delays(self._changed(self._displaced(axis))) for axis in range(3)]

    @cached_property
    def memory(self) -> int | None:
        """The number of samples after which one is forgotten; None = longer than the test."""
        changed = self._changed(self._displaced(0)).any(axis=1)
        if not changed.any():
            return 0
        last = int(np.flatnonzero(changed)[-1])
        return None if last == _WATCHED - 1 else max(0, last - _IN_PHI) + 1

    @property
    def is_mismatched(self) -> tuple[bool, bool]:
        own = [one[axis] for axis, one in enumerate(self.of_pose)]
        pairs = [
            (y, phi)
            for y, phi in zip(own, self.of_input, strict=True)
            if y is not None and phi is not None
        ]
        return any(y > phi for y, phi in pairs), any(phi > y for y, phi in pairs)

    @property
    def mixed(self) -> list[tuple[int, int]]:
        """The pairs of axes (of the sample, of the parameters) with a wrong influence."""
        return [
            (i, j)
            for i, one in enumerate(self.of_pose)
            for j, delay in enumerate(one)
            # The heading stands in phi of x and y, too.
            if i != j and delay is not None and not (i == 2 and delay > 0)
        ]

    def _displaced(self, axis: int) -> Situation:
        poses = self._usual.situation.poses.copy()
        poses[DISPLACED_AT, axis] += _OFFSET[axis]
        return replace(self._usual.situation, poses=poses)

    def _changed(self, displaced: Situation) -> npt.NDArray[np.bool_]:
        """Return whether each row of the parameters differs (N, 3), from the step on."""
        steps = slice(DISPLACED_AT, DISPLACED_AT + _WATCHED)
        after = self._usual.estimator.try_in(displaced.first(steps.stop)).outputs[steps]
        before = self._usual.outputs[steps][: len(after)]
        differs = abs(after - before) > _CHANGE * (1 + abs(before))
        return np.asarray(differs.reshape(-1, 3, 5).any(axis=2))


# P grows by 1 / lambda at each sample without new information. Beyond 1e15 times its size a double
# has no digit left of the earlier knowledge.
MAXIMUM_GROWTH = 1e15


def largest_square(estimator: Any) -> float:
    """Return the largest number in the square matrices that an estimator keeps, 0 without any.

    The search covers its attributes, the variables of a closure, and lists and dicts of these.
    """
    sizes = [abs(one).max() for one in arrays_in(estimator) if _is_square(one)]
    return float(max(sizes, default=0.0))


def keeps_symmetric(estimator: Any) -> bool:
    """Return whether the estimator keeps square matrices, all symmetric to the last digit."""
    if isinstance(estimator, RecursiveLeastSquares):
        return True
    squares = [one for one in arrays_in(estimator) if _is_square(one)]
    return bool(squares) and all(np.array_equal(one, np.swapaxes(one, -1, -2)) for one in squares)


def line_of_matrix(estimator: EstimatorUnderTest) -> SourceLine | None:
    """Return the last line that sets a square matrix, such as P, or else the definition."""
    kept = attributes_of(estimator.made)
    names = [name for name, one in kept.items() if any(map(_is_square, arrays_in(one, 1)))]
    return line_that_sets(estimator, names)


def _is_square(values: Floats) -> bool:
    return values.ndim >= 2 and values.shape[-1] == values.shape[-2] > 1


_NOTHING = "learns nothing"
_MISMATCHED = "sample mismatched"
_STAYS = 0.1  # of the displacement in a step
_LEARNED = 0.95  # of the rms of 2 x(k-1) - x(k-2)
_LAST = 150  # samples in the mean.
_UNKNOWNS = 5  # of an axis
_RUNAWAY = 1e6  # right ones are below 10
_FITTED = 0.02  # share of an error that is left after the update; least squares leave about 1
_ORDINARY = 0.95  # share of the samples whose error an update reduces
_COLUMNS = ("a1", "a2", "b1", "b2", "d1")
_GOES_ON = np.tile((2.0, -1.0, 0.0, 0.0, 0.0), (3, 1))


class Learning:
    """The errors of the parameters of a trial."""

    def __init__(self, trial: Trial) -> None:
        situation = trial.situation
        phi, self.y = regression(situation.poses, situation.u)
        self.phi = phi[-_LAST:]
        self.y = self.y[-_LAST:]
        self.theta_true = RobotModel(RobotParameters(dt=situation.dt)).theta
        # The sample of step k and the parameters of steps k - 1 and k.
        self.before = trial.outputs[-_LAST - 1 : -1].reshape(-1, 3, 5)
        self.after = trial.outputs[-_LAST:].reshape(-1, 3, 5)
        thetas = trial.outputs[np.isfinite(trial.outputs).all(axis=1)].reshape(-1, 3, 5)
        self.never_changed = (thetas == thetas[0]).all(axis=0)  # (3, 5)
        self.are_whole = bool((thetas == np.round(thetas)).all())
        self.rows_are_one = bool((thetas == thetas[:, :1]).all())

    def error_of(self, theta: Floats) -> Floats:
        """Return the error of parameters (3, 5) or (N, 3, 5), relative to the baseline."""
        return np.asarray(self._rms(theta) / self._rms(_GOES_ON))

    @property
    def is_near(self) -> bool:
        """Whether the parameters are within the reach of a displaced sample."""
        return bool((abs(self.before) < _RUNAWAY).all())

    @property
    def left(self) -> Floats:
        """The share of the error of each sample that is left after its update (N, 3)."""
        e_before = self.y - np.sum(self.phi * self.before, axis=2)
        e_after = self.y - np.sum(self.phi * self.after, axis=2)
        return np.asarray(abs(e_after) / np.maximum(abs(e_before), 1e-9))

    def _rms(self, theta: Floats) -> Floats:
        with np.errstate(all="ignore"):
            e = np.sum(self.phi * (theta - self.theta_true), axis=2)
            return np.asarray(np.sqrt(np.mean(e**2, axis=0)))


def mismatch_problem(trial: Trial, influence: Influence) -> Problem | None:
    learning = Learning(trial)
    # Whole numbers hide the effect of a sample.
    if not learning.is_near or learning.are_whole:
        return None
    is_y_late, is_phi_late = influence.is_mismatched
    if influence.mixed or not (is_y_late or is_phi_late):
        return None
    late, other = ("y", "phi") if is_y_late else ("phi", "y")
    return trial.problem(
        _MISMATCHED,
        f"it uses {other} of a step with {late} of the previous step: a displaced {other} "
        f"changes its parameters at once, a displaced {late} a step later; phi and y of one "
        "call belong together, y = phi @ theta",
        DISPLACED_AT,
        line_that_reads(trial.estimator, late),
    )


def learning_items(trial: Trial, influence: Influence) -> Iterator[Problem | str]:
    """Yield the reasons of parameters that predict no better than the baseline."""
    learning = Learning(trial)
    error = learning.error_of(learning.before)
    # Without its inputs the robot is predicted somewhat better than by the baseline.
    has_no_inputs = learning.never_changed[:, 2:4].all(axis=1) & ~learning.before[-1, :, 2:4].any(
        axis=1
    )
    is_bad = ~(error < _LEARNED) | has_no_inputs
    if not is_bad.any():
        return
    result = (
        f"after {len(trial.outputs)} samples its parameters predict {named(is_bad)} with "
        f"{error[is_bad].max():.3g} times the error of 2 x(k-1) - x(k-2), which learns nothing"
    )
    looks = (_from_values, _from_displacements, _from_updates)
    found = next((one for look in looks for one in look(learning, influence)), None)
    if found is None:  # they come slowly
        yield (
            f"{result}; each update reduces the error of its sample by "
            f"{1 - np.median(learning.left):.2g} of it, like a gradient method (LMS, NLMS): "
            "right, but too slow for regressors that are nearly dependent. The doctor cannot "
            "distinguish this from least squares with too small a gain"
        )
        return
    kind, cause = found
    line = line_of_matrix(trial.estimator) if kind == _NOTHING else None
    yield trial.problem(kind, f"{result}: {cause}", len(trial.outputs) - 1, line)


def _from_values(learning: Learning, influence: Influence) -> Iterator[tuple[str, str]]:
    if learning.are_whole:
        yield (
            "whole numbers",
            "its parameters are whole numbers at all steps: theta is an integer array, which "
            "cuts off all fractions; use floats, such as np.zeros((3, 5))",
        )
    if learning.rows_are_one and not learning.never_changed[0, 0]:
        yield (
            "axes mixed",
            "its three rows are the same at all steps: each axis has its own theta[i], phi[i], "
            "y[i] and P; one filter for all three causes this, and so does [[0.0] * 5] * 3, which "
            "is one list three times",
        )
    # They grow without bound, so that nothing else can be seen in them.
    if not learning.is_near and np.nanmedian(learning.left) > 1:
        yield (
            "wrong sign",
            "an update makes the error of its sample larger: theta = theta + K (y - phi @ "
            "theta); check the signs of K and of the error, and use the error of this "
            "axis",
        )
    if _is_standing(learning):
        yield (
            _MISMATCHED,
            "they are (1, 0, 0, 0, 0), so that y is x(k-1): it uses phi of a step with y of the "
            "previous step; phi and y of one call belong together",
        )


def _is_standing(learning: Learning) -> bool:
    """Return whether they are (1, 0, 0, 0, 0): then the fitted y is x(k-1), a part of phi."""
    ahead = np.eye(5)[0]
    off = np.sum(learning.phi * (learning.before - ahead), axis=2)
    displacement = np.sum(learning.phi * (_GOES_ON - ahead), axis=2)
    is_off = np.sum(off**2, axis=0) > _STAYS**2 * np.sum(displacement**2, axis=0)
    return not is_off[:2].any()  # a heading jumps where it is wrapped


def _from_displacements(learning: Learning, influence: Influence) -> Iterator[tuple[str, str]]:
    if all(
        delay is None for delays in (influence.of_input, *influence.of_pose) for delay in delays
    ):
        yield (
            _NOTHING,
            f"at step {DISPLACED_AT} neither phi nor y changes them; its gain or its P has become "
            "0, or it ignores the sample: these cannot be distinguished at that step",
        )
    for turned, kind, sentence in _rearranged(learning.before):
        if (learning.error_of(turned) < _LEARNED / 2).all():
            yield kind, sentence
    for i, j in influence.mixed:
        yield (
            "axes mixed",
            f"a displaced {AXES[i]} changes the parameters of {AXES[j]}: each axis has its own "
            "phi[i], y[i], theta[i] and P, (5, 5); one P, one phi or one filter for all three, and "
            "exchanged rows of y, cause this",
        )
    columns = np.flatnonzero(learning.never_changed.all(axis=0))
    if 0 < len(columns) < _UNKNOWNS:
        names = " and ".join(_COLUMNS[i] for i in columns)
        yield (
            "parameters not learned",
            f"{names} never change{'s' * (len(columns) == 1)}: the estimator leaves out that part "
            "of phi; phi[i] is x(k-1), x(k-2), u1, u2, 1, for the parameters a1, a2, b1, b2, d1",
        )


def _rearranged(theta: Floats) -> Iterator[tuple[Floats, str, str]]:
    """Yield rearranged parameters, with kind and sentence for the case that these are right."""
    ahead = np.eye(5)[0]
    yield -theta, "wrong sign", "with the opposite sign they are right"
    kind = "wrong parameters"
    displacement = "with 1 added to a1 they are right: they fit the displacement y - x(k-1)"
    yield theta + ahead, kind, displacement
    yield theta - ahead, kind, "with 1 taken from a1 they are right"
    for order in ([1, 0, 2, 3, 4], [0, 1, 3, 2, 4], [1, 0, 3, 2, 4]):
        exchanged = [column + 1 for column in range(5) if order[column] != column]
        right = f"in the order a1, a2, b1, b2, d1 they are right: columns {exchanged} are exchanged"
        yield theta[:, :, order], "order", right
    for rows in permutations(range(3)):
        if rows != (0, 1, 2):
            right = "in the order x, y, heading of the rows they are right"
            yield theta[:, list(rows)], "order", right


def _from_updates(learning: Learning, influence: Influence) -> Iterator[tuple[str, str]]:
    memory = influence.memory
    if memory is not None and memory < _UNKNOWNS:
        yield (
            _NOTHING,
            f"it remembers {memory} sample{'s' * (memory != 1)}, but {_UNKNOWNS} parameters need "
            "more: keep the earlier theta and P and update them",
        )
    with np.errstate(invalid="ignore"):
        left, middle = learning.left, np.median(learning.left)
    if middle < _FITTED:
        yield (
            _NOTHING,
            "each update fits its own sample exactly, also the last ones, and loses all that it "
            "learned earlier: P is not reduced, P = P - K phi' P (or it is NLMS with step 1, "
            "the same equation: these cannot be distinguished)",
        )
    if abs(middle - 1) < 1e-3:
        yield (
            _NOTHING,
            "an update hardly changes the error of its sample: its gain is too small; P (or "
            "the step size) must start large, such as P = 1e6 * np.eye(5), and not shrink without "
            "reason",
        )
    if not ((left < 1 + 1e-9).mean() > _ORDINARY and middle < 1 - 1e-3):
        yield (
            "wrong parameters",
            "an update does not reduce the error of its sample: check the gain, the signs and "
            "the order of rows and columns",
        )
