"""`check_parameter_estimator`: the checks of a parameter estimator in recorded situations."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from os import PathLike
from typing import Any

import numpy as np

from robsim._core import regression
from robsim.base.check_report import CheckReport, Problem
from robsim.base.checks import Floats, check_int
from robsim.teach.doctor._errors import problem_of
from robsim.teach.doctor._run_checks import (
    BUDGET,
    Done,
    replay_problem,
    run_checks,
    together_problem,
)
from robsim.teach.doctor._situations import DT, STANDS, Situation, excited, resting
from robsim.teach.doctor._slots import PARAMETERS
from robsim.teach.doctor._trial import BadResult, EstimatorUnderTest, Trial
from robsim.teach.doctor.learning import (
    MAXIMUM_GROWTH,
    Influence,
    keeps_symmetric,
    largest_square,
    learning_items,
    line_of_matrix,
    mismatch_problem,
)

_SHORT = 400  # steps
_QUIET = 0.1  # of the usual disturbances, which then hardly matter.
_WORSE = 3.0  # times the largest error before the rest
_REPEATED = 6  # samples
_DIVERGED = 10.0  # prediction error relative to the rms displacement per step
_EARLY = 3000  # updates; later only an asymmetric P diverges
_RECOVERY = 100  # steps after a rest within which the parameters must be good again


def check_parameter_estimator(
    make: Callable[[], Any] | str | PathLike[str], *, updates: int = 10_000, budget: float = BUDGET
) -> CheckReport:
    """Check a parameter estimator in several situations and report its problems.

    The results of the estimator must have the right shape, be finite and depend on its own past
    samples alone. They must predict better than ``2 x(k-1) - x(k-2)``, the prediction for constant
    speed. They must stay accurate in a long run and after 1000 steps at rest. If a check fails,
    poses and inputs are displaced one by one. The step and the axis of the first change then show
    the cause. Phi and y may come from different steps, axes may be mixed, or samples may be
    forgotten. The report leaves out the consequences of a problem.

    Parameters
    ----------
    make : callable or path
        ``make() -> estimator``: returns a new estimator, as ``init_parameter_estimator`` does: an
        object with ``update(phi, y)``. It may also return a new ``estimate_parameters`` callback,
        ``estimate(step) -> (3, 5) or None``. The path of a file ``init_parameter_estimator.py``, or
        of the callback folder with this file, is also accepted.
    updates : int
        Length of the longest run; 3000 at most if P stays symmetric. Least squares with
        forgetting diverges if P is not kept symmetric: after about 1 000 updates for
        lambda = 0.95, 2 700 for 0.99, 20 000 for 0.999.
    budget : float
        Maximum of the median time per call (s).

    Returns
    -------
    CheckReport
        True if all checks pass. In a test, call the report's ``raise_for_problems()``, which lists
        every problem.

    Raises
    ------
    TypeError, ValueError
        If `make` is not callable, or a number is out of range.

    Notes
    -----
    The check cannot distinguish normalised least mean squares (NLMS) with step 1 from least squares
    with constant P, because the equations are equal. Nor can it distinguish a gain that is too
    small from a gradient method, which is correct but slow; both get a remark. The check searches
    for windup in the square matrices that an estimator stores. If these matrices are hidden, the
    check sees windup only in the parameters.

    Sources: Goodwin and Sin, Adaptive Filtering, Prediction and Control, 1984, chapter 3
    (projection, least squares, covariance resetting); Astrom and Wittenmark, Adaptive Control,
    1995, chapter 11 (estimator windup); Bierman, Factorization Methods for Discrete Sequential
    Estimation, 1977, chapter V (rounding in P).

    Examples
    --------
    >>> make = lambda: robsim.RecursiveLeastSquares(5, n_filters=3)
    >>> print(robsim.check_parameter_estimator(make))
    RecursiveLeastSquares passed all checks
    """
    updates = check_int("updates", updates, minimum=1000, maximum=10_000_000)
    return run_checks(make, PARAMETERS, budget, partial(_checks, updates=updates))


def _checks(estimator: EstimatorUnderTest, updates: int) -> Iterator[Problem | str | Done]:
    alone = estimator.try_in(excited(DT, _SHORT, _QUIET))
    if alone.error is not None:
        yield problem_of(alone)
        return
    rests = resting(DT)
    # If one of these fails, the others are meaningless.
    cause = _no_adaptation(alone) or replay_problem(alone)
    if cause is not None:
        yield cause
        return
    yield from filter(None, (together_problem(alone, rests),))
    yield Done("the same samples again, two at the same time")
    influence = Influence(alone)
    mismatch = mismatch_problem(alone, influence)
    found = [mismatch] if mismatch else list(learning_items(alone, influence))
    yield from found
    yield Done("learning")
    if any(isinstance(one, Problem) for one in found):
        return
    diverges = _divergence(estimator, excited(DT, updates))
    yield from filter(None, (diverges,))
    yield Done("a long run")
    if diverges is None:
        yield from _rest_problems(estimator, rests)
        yield Done("a rest")


def _no_adaptation(alone: Trial) -> Problem | None:
    thetas = alone.outputs[np.isfinite(alone.outputs).all(axis=1)]
    if len(thetas) == 0:
        sentence = "it returns None at every step: return the parameters, an array of shape (3, 5)"
    elif (thetas == thetas[0]).all():
        sentence = "its parameters never change: phi and y have no effect"
    else:
        return None
    return alone.problem("no adaptation", sentence)


def _relative_errors(trial: Trial) -> Floats:
    """Return the one-step prediction errors of the worst axis over the rms displacement."""
    situation = trial.situation
    phi, y = regression(situation.poses, situation.u)
    phi, y = (part[: len(trial.outputs) - 2] for part in (phi, y))
    # The sample of step k and the estimate of step k - 1.
    theta = trial.outputs[1:-1].reshape(-1, 3, 5)
    # e = y - phi theta
    e = y - np.sum(phi * theta, axis=2)
    displacement = y - phi[:, :, 0]
    relative = np.asarray(abs(e) / np.sqrt(np.mean(displacement**2, axis=0)))
    return np.concatenate((np.full(2, np.nan), relative.max(axis=1)))


def _divergence(estimator: EstimatorUnderTest, drive: Situation) -> Problem | None:
    trial = estimator.try_in(drive.first(_EARLY) if keeps_symmetric(estimator.made) else drive)
    is_off = _relative_errors(trial) > _DIVERGED
    is_off[:_SHORT] = False
    # Once or twice is the transient of a covariance reset.
    if trial.error is None and np.sum(is_off) < _REPEATED:
        return None
    if trial.error is not None and not _is_numerical(trial.error):
        return problem_of(trial)
    k = int(is_off.argmax()) if is_off.any() else trial.failed_at
    found = trial.problem(
        "diverges",
        "its parameters are good at first and diverge later: with forgetting (lambda < 1) in "
        "P = (P - outer(K, phi @ P)) / lambda, rounding errors make P asymmetric and grow; then "
        "add P = (P + P.T) / 2. If your code has this line, lambda is too small: its memory, "
        "1 / (1 - lambda) samples, must be several times the 5 parameters",
        k,
        line_of_matrix(estimator),
    )
    return replace(found, situation="robot drives around for a long time")


def _is_numerical(error: BaseException) -> bool:
    if isinstance(error, BadResult):
        return error.kind == "not finite"
    return isinstance(error, (ArithmeticError, np.linalg.LinAlgError))


def _rest_problems(estimator: EstimatorUnderTest, rests: Situation) -> Iterator[Problem]:
    sizes = {}

    def watch(k: int, made: Any) -> None:
        if k in (STANDS.start, STANDS.stop - 1):
            sizes[k] = largest_square(made)

    trial = estimator.try_in(rests, watch)
    after = trial.outputs[STANDS.stop :]
    has_overflowed = trial.error is not None and _is_numerical(trial.error)
    if trial.error is not None and not has_overflowed:
        yield problem_of(trial)
        return
    if not has_overflowed and (after == after[0]).all():
        yield trial.problem(
            "adaptation stops",
            f"after {len(STANDS)} steps of constant input its parameters never change again: its "
            "gain or its P has become 0",
            STANDS.stop,
        )
        return
    growth = sizes.get(STANDS.stop - 1, 0.0) / max(sizes.get(STANDS.start, 0.0), 1e-300)
    is_large = bool(sizes.get(STANDS.start)) and growth > MAXIMUM_GROWTH
    errors = _relative_errors(trial)
    # One that learns slowly is no better before the rest.
    usual = float(np.nanmax(errors[STANDS.start // 2 : STANDS.start]))
    is_off = errors[STANDS.stop + _RECOVERY :] > max(_DIVERGED, _WORSE * usual)
    if has_overflowed or is_large or is_off.any():
        reason = f": its P grows {growth:.0e}-fold in the rest" if is_large else ""
        yield trial.problem(
            "windup",
            f"a long constant input makes its parameters wrong{reason}; with forgetting, P grows "
            "by 1 / lambda at every sample without new information, and needs a "
            "bound: limit its trace, or forget only while there is excitation",
            trial.failed_at if has_overflowed else STANDS.stop,
            line_of_matrix(estimator),
        )
