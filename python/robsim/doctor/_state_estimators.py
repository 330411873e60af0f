"""The check of state estimators."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial

import numpy as np

from robsim._base.check_report import CheckReport, Problem
from robsim._base.checks import Floats, check_float
from robsim._core import Estimate, Step, wrap_angle
from robsim.doctor._covariance import covariance_problem
from robsim.doctor._errors import problem_of
from robsim.doctor._examination import BUDGET, examine
from robsim.doctor._memory import replay_problem, together_problem
from robsim.doctor._situations import DT, UNSEEN, Situation, blinking, turning, weaving
from robsim.doctor._stages import STATE
from robsim.doctor._trial import EstimatorUnderTest, Trial

_SETTLED = 60  # steps after which an estimate has found the robot
_FAR = (100.0, 1.2)  # px, rad: who is that far off does not follow the robot
_VARIANCES = [3, 7, 11]  # where they are in an output: pose, covariance, state

_NO_INPUT = (
    "it never uses step.last_u, the inputs: right for a constant-velocity filter, but they say "
    "where the robot goes"
)
_DT_OF_A_MODEL = (
    "it never uses step.dt: right only if its model is made for the dt of the run; if it is, say "
    "so with dt=..."
)


def check_estimator(
    make: Callable[[], Callable[[Step], Estimate]],
    *,
    dt: float | None = None,
    budget: float = BUDGET,
) -> CheckReport:
    """Run a state estimator through a checks of situations and say what is wrong with it.

    It gets what `Simulation` gives to ``estimate_state``, with measurements and empty frames. What
    follows from another problem is left out: mend that, and check again.

    Parameters
    ----------
    make : callable
        ``make() -> estimate``: returns a fresh estimator, ``estimate(step) -> Estimate``. A class
        with ``__call__``, for example, or a function that defines and returns another.
    dt : float, optional
        The only time between two steps (s) that it is made for. Default: it has to go by
        ``step.dt``.
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
    >>> print(robsim.check_estimator(MyFilter))
    """
    if dt is not None:
        dt = check_float("dt", dt, "s", minimum=1e-3, maximum=10)
    return examine(make, STATE, budget, partial(_checks, dt=dt))


def _checks(estimator: EstimatorUnderTest, dt: float | None) -> Iterator[Problem | str]:
    weaves, turns = weaving(dt or DT), turning(dt or DT)
    alone = estimator.try_in(weaves)
    if alone.error is not None:
        yield problem_of(estimator, alone)
        return
    # With one of these, nothing below would mean anything.
    root = replay_problem(estimator, alone) or _ignores_measurements(estimator, alone)
    if root is not None:
        yield root
        return
    ill = covariance_problem(estimator, alone) or _divergence(estimator, alone)
    if ill is not None:
        yield ill
    unseen = _unseen(estimator, weaves, is_honest=ill is None)
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
    if ill is None:
        yield from _round(estimator, hidden, turns)
    yield from _ignored_inputs(estimator, hidden, is_dt_free=dt is None)


def _ignores(estimator: EstimatorUnderTest, alone: Trial, changed: Situation) -> bool:
    """Return whether the estimates are the same, to the last digit, in a changed situation."""
    return np.array_equal(alone.outputs, estimator.try_in(changed).outputs)


def _ignores_measurements(estimator: EstimatorUnderTest, alone: Trial) -> Problem | None:
    if not _ignores(estimator, alone, alone.situation.seen_elsewhere()):
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


def _divergence(estimator: EstimatorUnderTest, alone: Trial) -> Problem | None:
    distance, angle = _errors(alone)
    is_far = (distance > _FAR[0]) | (angle > _FAR[1])
    is_far[:_SETTLED] = False
    if not is_far.any():
        return None
    k = int(is_far.argmax())
    return Problem(
        kind="does not follow",
        sentence=f"its estimate is {distance[k]:.3g} px and {np.degrees(angle[k]):.0f} degrees "
        "off, though the robot is seen at every step: look at the gain, signs, units (heading in "
        "rad) and the order x, y, heading",
        situation=alone.situation.name,
        step=k,
        line=estimator.line,
    )


def _unseen(estimator: EstimatorUnderTest, weaves: Situation, *, is_honest: bool) -> Problem | None:
    """Return what goes wrong when the robot is not seen, for a while or from the start."""
    gap = estimator.try_in(weaves.unseen("robot out of sight", UNSEEN))
    if gap.error is not None:
        return problem_of(estimator, gap)
    late = estimator.try_in(weaves.unseen("robot not seen yet", range(5)))
    if late.error is not None:
        return problem_of(estimator, late)
    has_grown = gap.outputs[UNSEEN[-1]] > gap.outputs[UNSEEN[0] - 1]
    if not is_honest or has_grown[_VARIANCES].any():
        return None
    return Problem(
        kind="covariance does not grow",
        sentence=f"after {len(UNSEEN)} steps without a measurement it is as sure as before them: "
        "its covariance has to grow while nothing is seen",
        situation=gap.situation.name,
        step=UNSEEN[-1],
        line=estimator.line,
    )


def _round(estimator: EstimatorUnderTest, usual: Trial, turns: Situation) -> Iterator[Problem]:
    """Yield what goes wrong when the heading crosses +-pi."""
    trial = estimator.try_in(turns)
    if trial.error is not None:
        yield problem_of(estimator, trial)
        return
    # A filter that lags does so in every curve; one that does not wrap swings round at +-pi.
    angle = _errors(trial)[1]
    is_off = angle > 3 * _errors(usual)[1][_SETTLED:].max() + 0.3
    is_off[: int(np.argmax(turns.poses[:, 2] < 0))] = False
    if is_off.any():
        k = int(is_off.argmax())
        yield Problem(
            kind="heading not wrapped",
            sentence=f"its heading is {np.degrees(angle[k]):.0f} degrees off once the robot has "
            "turned past +-pi: wrap the innovation, robsim.wrap_angle(measured - predicted), and "
            "average no angles",
            situation=turns.name,
            step=k,
            line=estimator.line,
        )


def _ignored_inputs(
    estimator: EstimatorUnderTest, alone: Trial, *, is_dt_free: bool
) -> Iterator[Problem | str]:
    """Yield what an estimator makes no use of: the time between steps, the inputs."""
    situation = alone.situation
    needs_no_dt = is_dt_free and _ignores(estimator, alone, replace(situation, dt=situation.dt / 2))
    needs_no_input = _ignores(estimator, alone, replace(situation, u=situation.u + 0.1))
    if needs_no_dt and not needs_no_input:
        yield _DT_OF_A_MODEL
    elif needs_no_dt:
        yield Problem(
            kind="ignores dt",
            sentence="its estimate is the same whether step.dt is "
            f"{situation.dt:g} or {situation.dt / 2:g} s: use step.dt, not a number of your own; "
            "if it is for one dt only, say so with dt=...",
            line=estimator.line,
        )
    if needs_no_input:
        yield _NO_INPUT
