"""`check_parameter_estimator`: the checks of a parameter estimator in recorded situations."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from os import PathLike
from typing import Any

import numpy as np

from robsim._base.check_report import CheckReport, Problem
from robsim._base.checks import Floats, check_int
from robsim._core import regression
from robsim.doctor._errors import problem_of
from robsim.doctor._reproducibility import replay_problem, together_problem
from robsim.doctor._run_checks import BUDGET, run_checks
from robsim.doctor._situations import DT, STANDS, Situation, excited, resting
from robsim.doctor._slots import PARAMETERS
from robsim.doctor._trial import BadResult, EstimatorUnderTest, Trial

_SHORT = 400  # steps
_DIVERGED = 10.0  # prediction error relative to the rms displacement per step
_RECOVERY = 100  # steps after a rest within which the parameters must be good again


def check_parameter_estimator(
    make: Callable[[], Any] | str | PathLike[str], *, updates: int = 10_000, budget: float = BUDGET
) -> CheckReport:
    """Check a parameter estimator in several situations and report what is wrong with it.

    Consequences of another problem are not reported: fix that one, and check again.

    Parameters
    ----------
    make : callable or path
        ``make() -> estimator``: returns a fresh estimator, as ``init_parameter_estimator`` does:
        an object with ``update(phi, y)``. Or a fresh callback as for ``estimate_parameters``,
        ``estimate(step) -> (3, 5) or None``. Or a file ``init_parameter_estimator.py``, or the
        callback folder that has it.
    updates : int
        Length of the longest run. Least squares with forgetting diverges if P is not kept
        symmetric: after about 1 000 updates for lambda = 0.95, 2 700 for 0.99, 20 000 for 0.999.
    budget : float
        Maximum of the median time per call (s).

    Returns
    -------
    CheckReport
        True if all checks pass. In a test, call its ``raise_for_problems()``: that shows every
        problem.

    Raises
    ------
    TypeError, ValueError
        If `make` is not callable, or a number is out of range.

    Examples
    --------
    >>> print(robsim.check_parameter_estimator(MyLeastSquares))
    """
    updates = check_int("updates", updates, minimum=1000, maximum=10_000_000)
    return run_checks(make, PARAMETERS, budget, partial(_checks, updates=updates))


def _checks(estimator: EstimatorUnderTest, updates: int) -> Iterator[Problem]:
    drive = excited(DT, updates)
    alone = estimator.try_in(drive.first(_SHORT))
    if alone.error is not None:
        yield problem_of(estimator, alone)
        return
    rests = resting(DT)
    # If one of these fails, the others are meaningless.
    cause = (
        _no_adaptation(estimator, alone)
        or replay_problem(estimator, alone)
        or together_problem(estimator, alone, rests)
        or _wrong_parameters(estimator, alone)
        or _divergence(estimator, drive)
    )
    if cause is not None:
        yield cause
        return
    yield from _rest_problems(estimator, rests)


def _no_adaptation(estimator: EstimatorUnderTest, alone: Trial) -> Problem | None:
    """Return whether the parameters never change."""
    thetas = alone.outputs[np.isfinite(alone.outputs).all(axis=1)]
    if len(thetas) == 0:
        sentence = "it returns None at every step: return the parameters, an array of shape (3, 5)"
    elif (thetas == thetas[0]).all():
        sentence = "its parameters never change: phi and y have no effect"
    else:
        return None
    return Problem(
        kind="no adaptation", sentence=sentence, situation=alone.situation.name, line=estimator.line
    )


def _relative_errors(trial: Trial) -> Floats:
    """Return the one-step prediction errors relative to the rms displacement, the worst axis."""
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


def _wrong_parameters(estimator: EstimatorUnderTest, alone: Trial) -> Problem | None:
    """Return whether the parameters predict no better than the last pose does."""
    error = float(np.median(_relative_errors(alone)[-100:]))
    if error < 1:
        return None
    return Problem(
        kind="wrong parameters",
        sentence=f"after {_SHORT} samples y - phi @ theta is {error:.3g} times the displacement in "
        "a step, so that its parameters predict nothing: check the gain, the signs and the order "
        "of rows and columns",
        situation=alone.situation.name,
        k=_SHORT - 1,
        line=estimator.line,
    )


def _divergence(estimator: EstimatorUnderTest, drive: Situation) -> Problem | None:
    """Return whether good parameters diverge later."""
    trial = estimator.try_in(drive)
    is_off = _relative_errors(trial) > _DIVERGED
    is_off[:_SHORT] = False
    if trial.error is None and not is_off.any():
        return None
    if trial.error is not None and not _is_numerical(trial.error):
        return problem_of(estimator, trial)
    k = int(is_off.argmax()) if is_off.any() else trial.failed_at
    return Problem(
        kind="diverges",
        sentence="its parameters are good at first and diverge later: with forgetting (lambda < 1) "
        "in P = (P - outer(K, phi @ P)) / lambda, rounding errors make P asymmetric and grow; add "
        "P = (P + P.T) / 2 after it",
        situation="robot drives around for a long time",
        k=k,
        line=estimator.line,
    )


def _is_numerical(error: BaseException) -> bool:
    """Return whether an error may come from numbers that grow without bound."""
    if isinstance(error, BadResult):
        return error.kind == "not finite"
    return isinstance(error, (ArithmeticError, np.linalg.LinAlgError))


def _rest_problems(estimator: EstimatorUnderTest, rests: Situation) -> Iterator[Problem]:
    """Yield the problems after a long rest without excitation."""
    trial = estimator.try_in(rests)
    after = trial.outputs[STANDS.stop :]
    has_overflowed = trial.error is not None and _is_numerical(trial.error)
    if trial.error is not None and not has_overflowed:
        yield problem_of(estimator, trial)
    elif not has_overflowed and (after == after[0]).all():
        yield Problem(
            kind="adaptation stops",
            sentence=f"after {len(STANDS)} steps of constant input its parameters never change "
            "again: its gain or its P has become 0",
            situation=rests.name,
            k=STANDS.stop,
            line=estimator.line,
        )
    elif has_overflowed or (_relative_errors(trial)[STANDS.stop + _RECOVERY :] > _DIVERGED).any():
        yield Problem(
            kind="windup",
            sentence="a long constant input makes its parameters wrong: without excitation P must "
            "not grow without bound",
            situation=rests.name,
            k=trial.failed_at if has_overflowed else STANDS.stop + _RECOVERY,
            line=estimator.line,
        )
