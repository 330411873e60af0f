"""Whether parameters predict better than no learning at all, and why they do not.

Measured against 2 x(k-1) - x(k-2), the robot that goes on as before, which needs no parameters:
rms of phi (theta - theta_true) over the samples that are yet to come, relative to its own. Right
estimators reach 0.01 to 0.2, as the disturbances of the drive are small.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import permutations
from typing import Any

import numpy as np

from robsim._core import RobotModel, RobotParameters, regression
from robsim.base.check_report import Problem
from robsim.base.checks import Floats
from robsim.base.source_line import SourceLine
from robsim.teach.doctor._lines import line_that_reads, line_that_sets
from robsim.teach.doctor._trial import EstimatorUnderTest, Trial
from robsim.teach.doctor.influence import DISPLACED_AT, Influence

# P grows by 1 / lambda at each sample that brings nothing new. Beyond 1e15 times its size a double
# has no digit left of what was known.
MAXIMUM_GROWTH = 1e15
_DEPTH = 3  # of objects within the estimator
_FEW = 10  # matrices, not samples


def largest_square(estimator: Any) -> float:
    """Return the largest number in the square matrices that an estimator keeps; 0 = it has none.

    Looked at are its attributes, the variables of a closure, and lists and dicts of these.

    Parameters
    ----------
    estimator : object
        The estimator.
    """
    sizes = [abs(one).max() for one in _arrays(estimator, _DEPTH) if _is_square(one)]
    return float(max(sizes, default=0.0))


def line_of_matrix(estimator: EstimatorUnderTest) -> SourceLine | None:
    """Return the last line that sets a square matrix, such as P, or else the definition."""
    kept = _attributes(estimator.made)
    names = [name for name, one in kept.items() if any(map(_is_square, _arrays(one, 1)))]
    return line_that_sets(estimator, names)


def _arrays(value: Any, depth: int) -> Iterator[Floats]:
    if isinstance(value, np.ndarray):
        if value.dtype.kind == "f" and value.size:
            yield value
        return
    if depth == 0 or isinstance(value, (str, bytes, type)):
        return
    if isinstance(value, (list, tuple)) and len(value) < _FEW and (of_lists := _matrix(value)):
        yield from of_lists
        return
    cells = getattr(value, "__closure__", None) or ()
    inner = [cell.cell_contents for cell in cells if _is_filled(cell)]
    inner += value if isinstance(value, (list, tuple)) and len(value) < _FEW else ()
    inner += value.values() if isinstance(value, dict) and len(value) < _FEW else ()
    inner += _attributes(value).values()
    for one in inner:
        yield from _arrays(one, depth - 1)


def _attributes(value: Any) -> dict[str, Any]:
    """Return the attributes of an object, in its dict or its slots."""
    slots = [name for cls in type(value).__mro__ for name in getattr(cls, "__slots__", ())]
    kept = {name: getattr(value, name) for name in slots if hasattr(value, name)}
    return kept | getattr(value, "__dict__", {})


def _matrix(rows: Sequence[Any]) -> list[Floats]:
    """Return lists of lists of numbers as an array; empty = they are something else."""
    if not rows or not all(isinstance(row, (list, tuple)) for row in rows):
        return []
    try:
        return [np.array(rows, dtype=float)]
    except (TypeError, ValueError):
        return []


def _is_filled(cell: Any) -> bool:
    try:
        _ = cell.cell_contents
    except ValueError:
        return False
    return True


def _is_square(values: Floats) -> bool:
    return values.ndim >= 2 and values.shape[-1] == values.shape[-2] > 1


_NOTHING = "learns nothing"
_MISMATCHED = "sample mismatched"
_STAYS = 0.1  # of the displacement in a step
_LEARNED = 0.95  # of the rms of 2 x(k-1) - x(k-2)
_LAST = 150  # samples over which it is measured
_UNKNOWNS = 5  # of an axis
_RUNAWAY = 1e6  # right ones are below 10
_FITTED = 0.02  # share of an error that is left after the update; least squares leave about 1
_ORDINARY = 0.95  # share of the samples whose error an update reduces
_NAMES = ("x", "y", "heading")
_COLUMNS = ("a1", "a2", "b1", "b2", "d1")
_GOES_ON = np.tile((2.0, -1.0, 0.0, 0.0, 0.0), (3, 1))


class Learning:
    """What the parameters of a trial are worth.

    Parameters
    ----------
    trial : Trial
        The trial with its outputs.
    """

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
        """Return the error of parameters (3, 5) or (N, 3, 5), relative to going on as before."""
        return np.asarray(self._rms(theta) / self._rms(_GOES_ON))

    @property
    def error(self) -> Floats:
        return self.error_of(self.before)

    @property
    def is_near(self) -> bool:
        """Whether they have not grown beyond what a displaced sample could change."""
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


def mismatch_problem(
    estimator: EstimatorUnderTest, trial: Trial, influence: Influence
) -> Problem | None:
    """Return whether phi of one step is used with y of another."""
    learning = Learning(trial)
    # Whole numbers hide the effect of a sample.
    if not learning.is_near or learning.are_whole:
        return None
    is_y_late, is_phi_late = influence.is_mismatched
    if influence.mixed or not (is_y_late or is_phi_late):
        return None
    late, other = ("y", "phi") if is_y_late else ("phi", "y")
    return Problem(
        kind=_MISMATCHED,
        sentence=f"it uses {other} of a step with {late} of the step before: a displaced {other} "
        f"changes its parameters at once, a displaced {late} a step later; phi and y of one call "
        "belong together, y = phi @ theta",
        situation=trial.situation.name,
        k=DISPLACED_AT,
        line=line_that_reads(estimator, late),
    )


def learning_items(
    estimator: EstimatorUnderTest, trial: Trial, influence: Influence
) -> Iterator[Problem | str]:
    """Yield why the parameters predict no better than going on as before does, if so."""
    learning = Learning(trial)
    error = learning.error
    # Without its inputs the robot is predicted somewhat better than by going on as before.
    has_no_inputs = learning.never_changed[:, 2:4].all(axis=1) & ~learning.before[-1, :, 2:4].any(
        axis=1
    )
    is_bad = ~(error < _LEARNED) | has_no_inputs
    if not is_bad.any():
        return
    worst = " and ".join(name for name, bad in zip(_NAMES, is_bad, strict=True) if bad)
    result = (
        f"after {len(trial.outputs)} samples its parameters predict {worst} with "
        f"{error[is_bad].max():.3g} times the error of 2 x(k-1) - x(k-2), which learns nothing"
    )
    found = _cause(learning, influence)
    if found is None:
        yield (
            f"{result}; each update reduces the error of its sample by "
            f"{1 - np.median(learning.left):.2g} of it, as a gradient method (LMS, NLMS) does: "
            "right, but too slow for regressors that are nearly dependent. The doctor cannot tell "
            "it from least squares with too small a gain"
        )
        return
    kind, cause = found
    yield Problem(
        kind=kind,
        sentence=f"{result}: {cause}",
        situation=trial.situation.name,
        k=len(trial.outputs) - 1,
        line=line_of_matrix(estimator) if kind == _NOTHING else estimator.line,
    )


def _cause(learning: Learning, influence: Influence) -> tuple[str, str] | None:
    """Return kind and sentence of parameters that predict nothing; None = they come slowly."""
    return (
        _rounded(learning)
        or _one_row(learning)
        or _runaway(learning)
        or _standing(learning)
        or _dead(influence)
        or _rearranged(learning)
        or _mixed(influence)
        or _unused(learning)
        or _forgetful(learning, influence)
        or _unsteady(learning)
    )


def _rounded(learning: Learning) -> tuple[str, str] | None:
    if not learning.are_whole:
        return None
    return (
        "whole numbers",
        "its parameters are whole numbers at all steps: theta is an array of integers, which cuts "
        "off what is added; make it of floats, such as np.zeros((3, 5))",
    )


def _one_row(learning: Learning) -> tuple[str, str] | None:
    if not learning.rows_are_one or learning.never_changed[0, 0]:
        return None
    return (
        "axes mixed",
        "its three rows are the same at all steps: each axis has its own theta[i], phi[i], y[i] "
        "and P; one filter for all three does this, and [[0.0] * 5] * 3, which is one list three "
        "times",
    )


def _unused(learning: Learning) -> tuple[str, str] | None:
    """Return whether a parameter stays what it was at the start."""
    columns = np.flatnonzero(learning.never_changed.all(axis=0))
    if not 0 < len(columns) < _UNKNOWNS:
        return None
    names = " and ".join(_COLUMNS[i] for i in columns)
    return (
        "parameters not learned",
        f"{names} never change{'s' * (len(columns) == 1)}: the estimator leaves out that part of "
        "phi; phi[i] is x(k-1), x(k-2), u1, u2, 1, for the parameters a1, a2, b1, b2, d1",
    )


def _runaway(learning: Learning) -> tuple[str, str] | None:
    """Return whether they grow without bound, so that nothing else can be seen in them."""
    if learning.is_near or not np.nanmedian(learning.left) > 1:
        return None
    return (
        "wrong sign",
        "an update makes the error of its own sample larger: theta = theta + K (y - phi @ theta); "
        "look at the signs of K and of the error, and that it is the error of this axis",
    )


def _standing(learning: Learning) -> tuple[str, str] | None:
    """Return whether they are (1, 0, 0, 0, 0): the y that they fit is x(k-1), which is in phi."""
    ahead = np.eye(5)[0]
    off = np.sum(learning.phi * (learning.before - ahead), axis=2)
    displacement = np.sum(learning.phi * (_GOES_ON - ahead), axis=2)
    is_off = np.sum(off**2, axis=0) > _STAYS**2 * np.sum(displacement**2, axis=0)
    if is_off[:2].any():  # a heading jumps where it is wrapped
        return None
    return (
        _MISMATCHED,
        "they are (1, 0, 0, 0, 0), so that y is x(k-1): it uses phi of a step with y of the step "
        "before; phi and y of one call belong together",
    )


def _dead(influence: Influence) -> tuple[str, str] | None:
    if not influence.is_none:
        return None
    return (
        _NOTHING,
        f"at step {DISPLACED_AT} neither phi nor y changes them; its gain or its P has become 0, "
        "or it does not use the sample: these cannot be told apart at that step",
    )


def _rearranged(learning: Learning) -> tuple[str, str] | None:
    """Return whether the parameters are right when turned round."""
    theta = learning.before
    ahead = np.eye(5)[0]
    columns = [[1, 0, 2, 3, 4], [0, 1, 3, 2, 4], [1, 0, 3, 2, 4]]
    candidates = [
        (-theta, "wrong sign", "with the opposite sign they are right"),
        (theta + ahead, "wrong parameters", "with 1 added to a1 they are right: they are those of "
         "the displacement y - x(k-1)"),
        (theta - ahead, "wrong parameters", "with 1 taken from a1 they are right"),
        *((theta[:, :, order], "order", "in the order a1, a2, b1, b2, d1 they are right: columns "
           f"{[*map(int, np.flatnonzero(np.array(order) != np.arange(5)) + 1)]} are exchanged")
          for order in columns),
        *((theta[:, list(rows)], "order", "in the order x, y, heading of the rows they are right")
          for rows in permutations(range(3)) if rows != (0, 1, 2)),
    ]  # fmt: skip
    for turned, kind, sentence in candidates:
        if (learning.error_of(turned) < _LEARNED / 2).all():
            return kind, sentence
    return None


def _mixed(influence: Influence) -> tuple[str, str] | None:
    pairs = influence.mixed
    if not pairs:
        return None
    i, j = pairs[0]
    return (
        "axes mixed",
        f"a displaced {_NAMES[i]} changes the parameters of {_NAMES[j]}: each axis has its own "
        "phi[i], y[i], theta[i] and P, (5, 5); one P, one phi or one filter for all three, and "
        "exchanged rows of y, do this",
    )


def _forgetful(learning: Learning, influence: Influence) -> tuple[str, str] | None:
    memory = influence.memory
    if memory is not None and memory < _UNKNOWNS:
        return (
            _NOTHING,
            f"it remembers {memory} sample{'s' * (memory != 1)}, but {_UNKNOWNS} parameters need "
            "more: keep what was learned before (theta and P) and add to it",
        )
    if np.median(learning.left) < _FITTED:
        return (
            _NOTHING,
            "each update fits its own sample exactly, also the last ones, and loses what was "
            "learned before: P is not reduced, P = P - K phi' P (or it is NLMS with step 1, which "
            "is the same equation, so that these cannot be told apart)",
        )
    return None


def _unsteady(learning: Learning) -> tuple[str, str] | None:
    """Return that updates do not reduce the error of their own sample; None = they do."""
    with np.errstate(invalid="ignore"):
        left = learning.left
        if (left < 1 + 1e-9).mean() > _ORDINARY and np.median(left) < 1 - 1e-3:
            return None
    if abs(np.median(left) - 1) < 1e-3:
        return (
            _NOTHING,
            "an update hardly changes the error of its own sample: its gain is too small; P (or "
            "the step size) must start large, such as P = 1e6 * np.eye(5), and not shrink without "
            "reason",
        )
    return (
        "wrong parameters",
        "an update does not reduce the error of its own sample: check the gain, the signs and the "
        "order of rows and columns",
    )
