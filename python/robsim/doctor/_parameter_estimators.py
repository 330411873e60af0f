"""The check of parameter estimators."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np

from robsim._base.check_report import CheckReport, Problem
from robsim._base.checks import Floats, check_int
from robsim._core import regression
from robsim.doctor._errors import problem_of
from robsim.doctor._examination import BUDGET, examine
from robsim.doctor._memory import replay_problem, together_problem
from robsim.doctor._situations import DT, STANDS, Situation, excited, resting
from robsim.doctor._stages import PARAMETERS
from robsim.doctor._trial import BadResult, EstimatorUnderTest, Trial

_SHORT = 400  # steps
_FAR = 10.0  # times the way of a step: who predicts that badly has lost the robot
_RELEARNED = 100  # steps after which it has found its way again


def check_parameter_estimator(
    make: Callable[[], Any], *, updates: int = 10_000, budget: float = BUDGET
) -> CheckReport:
    """Run a parameter estimator through a checks of situations and say what is wrong with it.

    What follows from another problem is left out: mend that, and check again.

    Parameters
    ----------
    make : callable
        ``make() -> estimator``: returns a fresh estimator, as ``init_parameter_estimator`` does:
        an object with ``update(phi, y)``. Or a fresh callback as for ``estimate_parameters``,
        ``estimate(step) -> (3, 5) or None``.
    updates : int
        Length of the longest run. Without a symmetric P least squares that forgets diverges: in
        1 000 updates or so for lambda = 0.95, 2 700 for 0.99, 20 000 for 0.999.
    budget : float
        Time that a call may take, in the median (s).

    Returns
    -------
    CheckReport
        True if nothing is wrong. In a test, call its ``raise_for_problems()``: that shows every
        sentence.

    Raises
    ------
    TypeError, ValueError
        If `make` is not callable, or a number is out of range.

    Examples
    --------
    >>> print(robsim.check_parameter_estimator(MyLeastSquares))
    """
    updates = check_int("updates", updates, minimum=1000, maximum=10_000_000)
    return examine(make, PARAMETERS, budget, partial(_checks, updates=updates))


def _checks(estimator: EstimatorUnderTest, updates: int) -> Iterator[Problem]:
    drive = excited(DT, updates)
    alone = estimator.try_in(drive.first(_SHORT))
    if alone.error is not None:
        yield problem_of(estimator, alone)
        return
    rests = resting(DT)
    # With one of these, nothing below would mean anything.
    root = (
        _still(estimator, alone)
        or replay_problem(estimator, alone)
        or together_problem(estimator, alone, rests)
        or _bad(estimator, alone)
        or _diverged(estimator, drive)
    )
    if root is not None:
        yield root
        return
    yield from _rested(estimator, rests)


def _still(estimator: EstimatorUnderTest, alone: Trial) -> Problem | None:
    """Return that nothing was learned."""
    learned = alone.outputs[np.isfinite(alone.outputs).all(axis=1)]
    if len(learned) == 0:
        what = "it returns None at every step: return the parameters, an array of shape (3, 5)"
    elif (learned == learned[0]).all():
        what = "its parameters never change: phi and y have no effect"
    else:
        return None
    return Problem(
        kind="never learns", sentence=what, situation=alone.situation.name, line=estimator.line
    )


def _misses(trial: Trial) -> Floats:
    """Return how far predictions miss at each step, the worst axis, in ways of a usual step."""
    situation = trial.situation
    phi, y = regression(situation.poses, situation.u)
    phi, y = (part[: len(trial.outputs) - 2] for part in (phi, y))
    # The sample of step k and what was known at step k - 1.
    theta = trial.outputs[1:-1].reshape(-1, 3, 5)
    # e = y - phi theta
    e = y - np.sum(phi * theta, axis=2)
    way = y - phi[:, :, 0]  # from the last place to this one
    relative = np.asarray(abs(e) / np.sqrt(np.mean(way**2, axis=0)))
    return np.concatenate((np.full(2, np.nan), relative.max(axis=1)))


def _bad(estimator: EstimatorUnderTest, alone: Trial) -> Problem | None:
    """Return that what was learned predicts nothing."""
    miss = float(np.median(_misses(alone)[-100:]))
    if miss < 1:
        return None
    return Problem(
        kind="learns wrong",
        sentence=f"after {_SHORT} samples y - phi @ theta is {miss:.3g} times the way of a step, "
        "so that its parameters are worth nothing: look at the gain, the signs and the order of "
        "rows and columns",
        situation=alone.situation.name,
        step=_SHORT - 1,
        line=estimator.line,
    )


def _diverged(estimator: EstimatorUnderTest, drive: Situation) -> Problem | None:
    """Return that it is right at first and loses its way later."""
    trial = estimator.try_in(drive)
    is_far = _misses(trial) > _FAR
    is_far[:_SHORT] = False
    if trial.error is None and not is_far.any():
        return None
    if trial.error is not None and not _is_numerical(trial.error):
        return problem_of(estimator, trial)
    k = int(is_far.argmax()) if is_far.any() else trial.failed_at
    return Problem(
        kind="diverges",
        sentence="its parameters are good at first and run away later: if it forgets (lambda < 1) "
        "with P = (P - outer(K, phi @ P)) / lambda, rounding makes P asymmetric and grows; put "
        "P = (P + P.T) / 2 after it",
        situation="robot drives around for long",
        step=k,
        line=estimator.line,
    )


def _is_numerical(error: BaseException) -> bool:
    """Return whether numbers that grow without bound end in such an error."""
    if isinstance(error, BadResult):
        return error.kind == "not finite"
    return isinstance(error, (ArithmeticError, np.linalg.LinAlgError))


def _rested(estimator: EstimatorUnderTest, rests: Situation) -> Iterator[Problem]:
    """Yield what a long rest, in which there is nothing to learn, does to it."""
    trial = estimator.try_in(rests)
    after = trial.outputs[STANDS.stop :]
    has_burst = trial.error is not None and _is_numerical(trial.error)
    if trial.error is not None and not has_burst:
        yield problem_of(estimator, trial)
    elif not has_burst and (after == after[0]).all():
        yield Problem(
            kind="freezes",
            sentence=f"after {len(STANDS)} steps of constant input its parameters never change "
            "again: its gain or its P has become 0",
            situation=rests.name,
            step=STANDS.stop,
            line=estimator.line,
        )
    elif has_burst or (_misses(trial)[STANDS.stop + _RELEARNED :] > _FAR).any():
        yield Problem(
            kind="blows up",
            sentence="constant input for long makes its parameters worthless: while there is "
            "nothing to learn, P must not grow without bound",
            situation=rests.name,
            step=trial.failed_at if has_burst else STANDS.stop + _RELEARNED,
            line=estimator.line,
        )
