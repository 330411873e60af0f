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
    REMEMBERS,
    Done,
    covariance_problem,
    replay_problem,
    run_checks,
    together_problem,
)
from robsim.teach.doctor._situations import DT
from robsim.teach.doctor._slots import STATE
from robsim.teach.doctor._trial import EstimatorUnderTest
from robsim.teach.doctor.claims import claim_problems, gain_problem
from robsim.teach.doctor.consistency import (
    ahead_problem,
    consistency_remarks,
    growth_problem,
    lost_problem,
    reduction_problem,
    size_problem,
    thrown_problem,
    transpose_problem,
)
from robsim.teach.doctor.gain import (
    UNKNOWN_CAUSES,
    Gains,
    divergence_problem,
    gain_remarks,
    ignored_problem,
    late_problem,
    unused_problem,
)
from robsim.teach.doctor.inputs import inputs_problems
from robsim.teach.doctor.trials import SETTLED, Trials, distances

_NO_INPUT = (
    "it never uses step.last_u, the inputs: correct for a constant-velocity filter, but a model "
    "with inputs predicts better"
)
_NO_DT = (
    "it never uses step.dt: correct only if its model or its gains have a constant dt, the dt of "
    "the run; then pass dt=... to this check"
)


def check_estimator(
    make: Callable[[], Callable[[Step], Estimate]] | str | PathLike[str],
    *,
    dt: float | None = None,
    budget: float = BUDGET,
) -> CheckReport:
    """Check a state estimator in several situations and report its problems.

    The estimator gets the same steps as ``estimate_state`` of `Simulation`, with measurements and
    empty frames. The checks examine the type of its results, and the symmetry and the definiteness
    of the covariance. The results may depend only on the estimator's own past steps. Displaced
    measurements show the filter's gain, and the step in which the estimate first changes. The
    checks compare the covariance with the gain, with R and with the errors (NEES), also while the
    robot is not seen. Other inputs test the prediction in the first step, in a turn and on a
    straight line. A drive in circles tests headings beyond +-pi. The report lists all independent
    faults, but not their consequences.

    Parameters
    ----------
    make : callable or path
        ``make() -> estimate``: returns a new estimator, ``estimate(step) -> Estimate``. Examples
        are a class with ``__call__``, and a function that defines and returns another function. A
        path of a file ``estimate_state.py``, or of the callback folder with this file, is also
        accepted.
    dt : float, optional
        The step time (s), if the estimator supports only one. By default the estimator must support
        any step time; the report has a remark if the estimator never uses ``step.dt``.
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
    Some faults cannot be distinguished, because the estimates are the same:

    - A constant instead of ``step.dt`` and speeds and gains per step, which get a remark only.
    - A measurement of the previous step and an estimate of the previous step.
    - Exchanged motors and a heading of wrong sign.
    - A double prediction and twice the dt or inputs; in a filter that estimates its velocity (which
      it takes for half as large), also a larger Q.
    - Standard deviations in R and an R for another camera, which gets a remark only.

    A repeated measurement has the same effect as a halved R. The doctor knows the R of its
    measurements, and searches for R among the numbers that the estimator stores. Inputs that act a
    step late have the same effect as Euler's method. To distinguish these, the doctor searches for
    the speed among the stored numbers. Filters whose Q and R are too large or too small by a factor
    of 4 pass the check.

    The mean NEES is 3 for a consistent filter; a value above 20 is a problem, even with the noise
    of the sharpest camera. Sources: Bar-Shalom, Li and Kirubarajan, Estimation with Applications to
    Tracking and Navigation, 2001, 5.2 (gain and covariance of the update), 5.4 (consistency, NEES),
    6.5 (alpha-beta filters); Simon, Optimal State Estimation, 2006, chapter 5 (forms of the update
    of P).

    Examples
    --------
    >>> print(robsim.check_estimator(robsim.estimation.reference.ExtendedKalmanFilter))
    ExtendedKalmanFilter passed all checks
    """
    if dt is not None:
        dt = check_float("dt", dt, "s", minimum=1e-3, maximum=10)
    return run_checks(make, STATE, budget, partial(_checks, dt=dt))


def _checks(estimator: EstimatorUnderTest, dt: float | None) -> Iterator[Problem | str | Done]:
    trials = Trials(estimator, dt or DT)
    if trials.seen.error is not None:
        yield problem_of(trials.seen)
        return
    gains = Gains(trials)
    # If one of these fails, the others are meaningless.
    memory = replay_problem(trials.seen, trials.undisplaced)
    cause = ignored_problem(trials, gains) if memory is None else memory
    if cause is not None:
        yield cause
        if cause.kind != REMEMBERS:  # which the filter forgets while the robot is seen
            return
    yield Done("the same steps again")
    transposed, late = transpose_problem(trials), late_problem(trials, gains)
    # A wrong covariance is a cause of the others.
    diverged = None if transposed else divergence_problem(trials, gains)
    wrong = None if transposed else covariance_problem(trials.seen)
    unused = unused_problem(trials, gains)
    failed = next((one for one in (trials.gap, trials.late, trials.hidden) if one.error), None)
    inputs = [] if failed or late or unused else list(inputs_problems(trials))
    if diverged is not None and diverged.kind in UNKNOWN_CAUSES and inputs:
        diverged = None
    elif diverged is not None:
        inputs = []
    yield from filter(None, (transposed, unused, late, diverged, wrong, *inputs))
    yield Done("measurements and inputs")
    if failed is not None:
        yield problem_of(failed)
    elif not (late or unused or trials.diverged_at is not None):
        ahead = None if inputs else ahead_problem(trials)
        stays = growth_problem(trials)
        thrown = None if stays else thrown_problem(trials, gains)
        lost = None if stays or thrown else lost_problem(trials)
        yield from filter(None, (ahead, thrown, lost))
        yield Done("steps without a measurement")
        is_readable = wrong is None or wrong.kind == "covariance not symmetric"
        if is_readable and not (transposed or ahead or lost):
            yield from _covariance_problems(trials, gains, has_errors=bool(inputs or thrown))
        yield Done("covariance")
    if trials.hidden.error is not None:
        return
    if memory is None:
        yield from filter(None, (together_problem(trials.hidden, trials.turns),))
    yield Done("two at the same time")
    if trials.diverged_at is None:
        yield from _wrapping_problems(trials)
        yield Done("headings beyond +-180 degrees")
    yield from _unused_remarks(trials, is_free=dt is None)
    if not late:
        yield from gain_remarks(trials, gains)


def _covariance_problems(
    trials: Trials, gains: Gains, *, has_errors: bool
) -> Iterator[Problem | str]:
    """Yield faults of the covariance: causes, or else remarks."""
    causes = [growth_problem(trials) or reduction_problem(trials, gains)]
    causes += [gain_problem(trials, gains)]
    found = [*filter(None, causes), *claim_problems(trials, gains)]
    yield from found
    # which no covariance would fit
    if found or has_errors:
        return
    yield from [size] if (size := size_problem(trials, gains)) else consistency_remarks(trials)


def _wrapping_problems(trials: Trials) -> Iterator[Problem]:
    trial = trials.turned
    if trial.error is not None:
        yield problem_of(trial)
        return
    # A lagging filter lags in every curve; a filter without wrapping turns the wrong way at +-pi.
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

    A filter with speeds and gains per step, such as a line through the last measurements, is
    right without dt. It gives the same estimates as a filter with a constant dt.
    """
    if is_free and trials.is_unchanged(replace(trials.blinks, dt=trials.blinks.dt / 2)):
        yield _NO_DT
    if trials.ignores_inputs:
        yield _NO_INPUT
