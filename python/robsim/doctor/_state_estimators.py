"""`check_estimator`: the checks of a state estimator in recorded situations."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from os import PathLike

import numpy as np

from robsim._base.check_report import CheckReport, Problem
from robsim._base.checks import Floats, check_float
from robsim._core import Estimate, Step, wrap_angle
from robsim.doctor._covariance import covariance_problem
from robsim.doctor._errors import problem_of
from robsim.doctor._reproducibility import replay_problem, together_problem
from robsim.doctor._run_checks import BUDGET, run_checks
from robsim.doctor._situations import DT, UNSEEN, Situation, blinking, turning, weaving
from robsim.doctor._slots import STATE
from robsim.doctor._trial import EstimatorUnderTest, Trial

_SETTLING_STEPS = 60  # after which the estimate has to be near the truth
_MAXIMUM_ERROR = (100.0, 1.2)  # px, rad: beyond it the estimate has diverged
_VARIANCES = [3, 7, 11]  # their indices in an output: pose, covariance, state

_NO_INPUT = (
    "it never uses step.last_u, the inputs: correct for a constant-velocity filter, but a model "
    "with inputs predicts better"
)
_NO_DT = (
    "it never uses step.dt: correct only if its model is made for the dt of the run; then pass "
    "dt=... to this check"
)


def check_estimator(
    make: Callable[[], Callable[[Step], Estimate]] | str | PathLike[str],
    *,
    dt: float | None = None,
    budget: float = BUDGET,
) -> CheckReport:
    """Check a state estimator in several situations and report what is wrong with it.

    It gets the same steps as ``estimate_state`` of `Simulation`, with measurements and empty
    frames. Consequences of another problem are not reported: fix that one, and check again.

    Parameters
    ----------
    make : callable or path
        ``make() -> estimate``: returns a fresh estimator, ``estimate(step) -> Estimate``. For
        example a class with ``__call__``, or a function that defines and returns another. Or a
        file ``estimate_state.py``, or the callback folder that has it.
    dt : float, optional
        The only time between two steps (s) that it is made for. Default: it has to use
        ``step.dt``.
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
    >>> print(robsim.check_estimator(MyFilter))
    """
    if dt is not None:
        dt = check_float("dt", dt, "s", minimum=1e-3, maximum=10)
    return run_checks(make, STATE, budget, partial(_checks, dt=dt))


def _checks(estimator: EstimatorUnderTest, dt: float | None) -> Iterator[Problem | str]:
    weaves, turns = weaving(dt or DT), turning(dt or DT)
    alone = estimator.try_in(weaves)
    if alone.error is not None:
        yield problem_of(estimator, alone)
        return
    # If one of these fails, the others are meaningless.
    cause = replay_problem(estimator, alone) or _ignores_measurements(estimator, alone)
    if cause is not None:
        yield cause
        return
    wrong = covariance_problem(estimator, alone) or _diverges_from_truth(estimator, alone)
    if wrong is not None:
        yield wrong
    unseen = _unseen_problem(estimator, weaves, is_plausible=wrong is None)
    if unseen is not None:
        yield unseen
        return
    hidden = estimator.try_in(blinking(weaves.dt))
    if hidden.error is not None:
        yield problem_of(estimator, hidden)
        return
    shared = together_problem(estimator, hidden, turns)
    if shared is not None:
        yield shared
    if wrong is None:
        yield from _wrapping_problems(estimator, hidden, turns)
    yield from _ignores_inputs(estimator, hidden, is_dt_free=dt is None)


def _ignores(estimator: EstimatorUnderTest, alone: Trial, changed: Situation) -> bool:
    """Return whether the estimates are exactly the same in a changed situation."""
    return np.array_equal(alone.outputs, estimator.try_in(changed).outputs)


def _ignores_measurements(estimator: EstimatorUnderTest, alone: Trial) -> Problem | None:
    if not _ignores(estimator, alone, alone.situation.with_measurement_offset()):
        return None
    return Problem(
        kind="ignores measurement",
        sentence="its estimate is the same wherever the robot is seen: step.measurement.pose has "
        "no effect",
        situation=alone.situation.name,
        line=estimator.line,
    )


def _errors(trial: Trial) -> tuple[Floats, Floats]:
    """Return the distance (px) and the angle (rad) between estimate and truth, step by step."""
    error = trial.outputs[:, :3] - trial.situation.poses[: len(trial.outputs)]
    return np.hypot(error[:, 0], error[:, 1]), abs(wrap_angle(error[:, 2]))


def _diverges_from_truth(estimator: EstimatorUnderTest, alone: Trial) -> Problem | None:
    distance, angle = _errors(alone)
    is_off = (distance > _MAXIMUM_ERROR[0]) | (angle > _MAXIMUM_ERROR[1])
    is_off[:_SETTLING_STEPS] = False
    if not is_off.any():
        return None
    k = int(is_off.argmax())
    return Problem(
        kind="diverges from truth",
        sentence=f"its estimate is {distance[k]:.3g} px and {np.degrees(angle[k]):.0f} degrees "
        "off, though the robot is seen at every step: check the gain, signs, units (heading in "
        "rad) and the order x, y, heading",
        situation=alone.situation.name,
        k=k,
        line=estimator.line,
    )


def _unseen_problem(
    estimator: EstimatorUnderTest, weaves: Situation, *, is_plausible: bool
) -> Problem | None:
    """Return the problem when the robot is not seen, for a while or from the start."""
    gap = estimator.try_in(weaves.unseen("robot out of sight", UNSEEN))
    if gap.error is not None:
        return problem_of(estimator, gap)
    late = estimator.try_in(weaves.unseen("robot not seen yet", range(5)))
    if late.error is not None:
        return problem_of(estimator, late)
    has_grown = gap.outputs[UNSEEN[-1]] > gap.outputs[UNSEEN[0] - 1]
    if not is_plausible or has_grown[_VARIANCES].any():
        return None
    return Problem(
        kind="covariance does not grow",
        sentence=f"after {len(UNSEEN)} steps without a measurement no variance is larger than "
        "before them: the covariance has to grow while the robot is not seen",
        situation=gap.situation.name,
        k=UNSEEN[-1],
        line=estimator.line,
    )


def _wrapping_problems(
    estimator: EstimatorUnderTest, usual: Trial, turns: Situation
) -> Iterator[Problem]:
    """Yield the problems when the heading crosses +-pi."""
    trial = estimator.try_in(turns)
    if trial.error is not None:
        yield problem_of(estimator, trial)
        return
    # A filter that lags does so in every curve; one that does not wrap turns the wrong way at +-pi.
    angle = _errors(trial)[1]
    is_off = angle > 3 * _errors(usual)[1][_SETTLING_STEPS:].max() + 0.3
    is_off[: int(np.argmax(turns.poses[:, 2] < 0))] = False
    if is_off.any():
        k = int(is_off.argmax())
        yield Problem(
            kind="heading not wrapped",
            sentence=f"its heading is {np.degrees(angle[k]):.0f} degrees off once the robot has "
            "turned past +-pi: wrap the innovation, robsim.wrap_angle(measured - predicted), and "
            "average no angles",
            situation=turns.name,
            k=k,
            line=estimator.line,
        )


def _ignores_inputs(
    estimator: EstimatorUnderTest, alone: Trial, *, is_dt_free: bool
) -> Iterator[Problem | str]:
    """Yield a problem or a remark if the time between steps or the inputs have no effect."""
    situation = alone.situation
    needs_no_dt = is_dt_free and _ignores(estimator, alone, replace(situation, dt=situation.dt / 2))
    needs_no_input = _ignores(estimator, alone, replace(situation, u=situation.u + 0.1))
    if needs_no_dt and not needs_no_input:
        yield _NO_DT
    elif needs_no_dt:
        yield Problem(
            kind="ignores dt",
            sentence="its estimate is the same whether step.dt is "
            f"{situation.dt:g} or {situation.dt / 2:g} s: use step.dt, not a constant; if it is "
            "for one dt only, pass dt=... to this check",
            line=estimator.line,
        )
    if needs_no_input:
        yield _NO_INPUT
