"""`check_estimator`: the checks of a state estimator in recorded situations."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from os import PathLike

import numpy as np

from robsim._core import Estimate, Step
from robsim.base.check_report import CheckReport, Problem
from robsim.base.checks import check_float
from robsim.teach.doctor._errors import problem_of
from robsim.teach.doctor._lines import line_of_measurement
from robsim.teach.doctor._run_checks import (
    BUDGET,
    covariance_problem,
    replay_problem,
    run_checks,
    together_problem,
)
from robsim.teach.doctor._situations import DT
from robsim.teach.doctor._slots import STATE
from robsim.teach.doctor._trial import EstimatorUnderTest
from robsim.teach.doctor.consistency import (
    ahead_problem,
    consistency_remarks,
    growth_problem,
    inputs_problem,
    lost_problem,
    reduction_problem,
    size_problem,
    transpose_problem,
)
from robsim.teach.doctor.gain import (
    Gains,
    divergence_problem,
    gain_remarks,
    ignored_problem,
    late_problem,
    unused_problem,
)
from robsim.teach.doctor.trials import SETTLED, Trials, distances

_NO_INPUT = (
    "it never uses step.last_u, the inputs: correct for a constant-velocity filter, but a model "
    "with inputs predicts better"
)
_NO_DT = (
    "it never uses step.dt: correct only if its model, or its gains, are made for the dt of the "
    "run; then pass dt=... to this check"
)


def check_estimator(
    make: Callable[[], Callable[[Step], Estimate]] | str | PathLike[str],
    *,
    dt: float | None = None,
    budget: float = BUDGET,
) -> CheckReport:
    """Check a state estimator in several situations and report what is wrong with it.

    It gets the same steps as ``estimate_state`` of `Simulation`, with measurements and empty
    frames. Looked at are its results (type, symmetry, definiteness); whether they depend on its own
    past steps alone; what it makes of a displaced measurement (the gain, and the step of the first
    change); its covariance while the robot is not seen and when it is seen again; the errors beside
    its covariance (NEES); its prediction with other inputs; the heading beyond +-pi. Faults
    that do not depend on each other are all reported, their consequences are not.

    Parameters
    ----------
    make : callable or path
        ``make() -> estimate``: returns a fresh estimator, ``estimate(step) -> Estimate``. For
        example a class with ``__call__``, or a function that defines and returns another. Or a
        file ``estimate_state.py``, or the callback folder that has it.
    dt : float, optional
        The only time between two steps (s) that it is made for. Default: any; a remark says if it
        never uses ``step.dt``.
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

    Notes
    -----
    What cannot be told, since the estimates are the same: a constant in the place of ``step.dt``
    from speeds and gains that are per step, which gets a remark only; a measurement of the step
    before from an estimate of the step before; exchanged motors from a heading of wrong sign; a
    prediction that is done twice from a dt or inputs that are twice as large, and in a filter that
    estimates its velocity from a larger Q (it takes the velocity for half as large); standard
    deviations in place of variances from an R for another camera, which gets a remark only, since
    the doctor does not know the camera. Filters with Q and R that are 4 times too large or small
    pass.

    The mean NEES is 3 for a consistent filter; a problem is above 20, with the noise of the
    sharpest camera, too. Sources: Bar-Shalom, Li and Kirubarajan, Estimation with Applications to
    Tracking and Navigation, 2001, 5.2 (gain and covariance of the update), 5.4 (consistency,
    NEES), 6.5 (alpha-beta filters); Simon, Optimal State Estimation, 2006, chapter 5 (forms of the
    update of P).

    Examples
    --------
    >>> print(robsim.check_estimator(MyFilter))
    """
    if dt is not None:
        dt = check_float("dt", dt, "s", minimum=1e-3, maximum=10)
    return run_checks(make, STATE, budget, partial(_checks, dt=dt))


def _checks(estimator: EstimatorUnderTest, dt: float | None) -> Iterator[Problem | str]:
    trials = Trials(estimator, dt or DT)
    if trials.seen.error is not None:
        yield problem_of(trials.seen)
        return
    gains = Gains(trials)
    # If one of these fails, the others are meaningless.
    cause = replay_problem(trials.seen) or ignored_problem(trials, gains)
    if cause is not None:
        yield cause
        return
    transposed, late = transpose_problem(trials), late_problem(trials, gains)
    # A wrong covariance is a cause of the others.
    diverged = None if transposed else divergence_problem(trials, gains)
    wrong = None if transposed else covariance_problem(trials.seen)
    unused = unused_problem(trials, gains)
    yield from filter(None, (transposed, unused, late, diverged, wrong))
    failed = next((one for one in (trials.gap, trials.late) if one.error), None)
    if failed is not None:
        yield problem_of(failed)
        return
    if not (late or unused or trials.diverged_at is not None):
        inputs = inputs_problem(trials)
        ahead = None if inputs else ahead_problem(trials)
        lost = None if growth_problem(trials) else lost_problem(trials)
        yield from filter(None, (inputs, ahead, lost))
        is_readable = wrong is None or wrong.kind == "covariance not symmetric"
        if is_readable and not (transposed or ahead or lost):
            yield from _covariance_problems(trials, gains, has_errors=inputs is not None)
    if trials.hidden.error is not None:
        yield problem_of(trials.hidden)
        return
    yield from filter(None, (together_problem(trials.hidden, trials.turns),))
    if trials.diverged_at is None:
        yield from _wrapping_problems(trials)
    yield from _unused_remarks(trials, is_free=dt is None)
    if not late:
        yield from gain_remarks(trials, gains)


def _covariance_problems(
    trials: Trials, gains: Gains, *, has_errors: bool
) -> Iterator[Problem | str]:
    """Yield what is wrong with the size of the covariance: the first cause, or else remarks."""
    cause = growth_problem(trials) or reduction_problem(trials, gains)
    if has_errors and cause is None:  # which no covariance would fit
        return
    cause = cause or size_problem(trials)
    if cause is not None:
        yield cause
    else:
        yield from consistency_remarks(trials)


def _wrapping_problems(trials: Trials) -> Iterator[Problem]:
    trial = trials.turned
    if trial.error is not None:
        yield problem_of(trial)
        return
    # A filter that lags does so in every curve; one that does not wrap turns the wrong way at +-pi.
    angle = distances(trial)[1]
    is_off = angle > 3 * distances(trials.hidden)[1][SETTLED:].max() + 0.3
    is_off[: int(np.argmax(trials.turns.poses[:, 2] < 0))] = False
    if is_off.any():
        k = int(is_off.argmax())
        yield trial.problem(
            "heading not wrapped",
            f"its heading is {np.degrees(angle[k]):.0f} degrees off once the robot has turned past "
            "+-pi: wrap the innovation, robsim.wrap_angle(measured - predicted), and average no "
            "angles",
            k,
            line_of_measurement(trials.estimator),
        )


def _unused_remarks(trials: Trials, *, is_free: bool) -> Iterator[str]:
    """Yield a remark if the time between steps or the inputs have no effect.

    A filter whose speeds and gains are per step, such as a line through the last measurements, is
    right without dt, and gives the same estimates as one with a constant dt.
    """
    if is_free and trials.is_unchanged(replace(trials.blinks, dt=trials.blinks.dt / 2)):
        yield _NO_DT
    if trials.ignores_inputs:
        yield _NO_INPUT
