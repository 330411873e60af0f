"""Check whether an estimator's claimed covariance matches its gain.

A Kalman filter has P+ = (I - K) P- and P+ = K R. Its gain K is measured, with displaced
measurements; P+ and P- are the estimator's, of the same step with and without a measurement.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

import numpy as np

from robsim.base.check_report import Problem
from robsim.base.checks import Floats
from robsim.teach.doctor._kept import arrays_in
from robsim.teach.doctor._lines import line_of_covariance, line_of_measurement
from robsim.teach.doctor._situations import MEASUREMENT_SIGMA, UNSEEN
from robsim.teach.doctor.gain import Gains
from robsim.teach.doctor.trials import DISPLACED_AT, Trials, variances

_EQUAL = 1e-8  # differences of gains; rounding makes 1e-12
_EXACT = 1e-10  # a gain of 1 hands the measurement on
_NEARLY_ALL = 0.98
_SMALLER = 0.25  # the gain of the covariance, below the one in use
_CHANGES = 0.05
_GROWS = 1.5
_GAPS = (30, 110)  # steps, the first ones of two equal gaps
_SHARE = 0.3  # after a gap a Kalman filter has a gain of nearly 1
_SAME = 0.1
_REPEATED = range(1, 4)


def gain_problem(trials: Trials, gains: Gains) -> Problem | None:
    """Return a problem if the gain is constant while the covariance is not."""
    K, later = gains.usual, gains.after_gap
    if (abs(K - later) > _EQUAL).any():
        return None
    P, unseen = variances(trials.gap), variances(trials.gap)[DISPLACED_AT]
    seen, again = variances(trials.seen)[DISPLACED_AT], P[UNSEEN.stop]
    is_followed = bool((K > _NEARLY_ALL).all())
    is_exact = bool((abs(1 - K) < _EXACT).all())
    changes = bool((abs(seen / again - 1) > _CHANGES).any())
    first, last = variances(trials.hidden)[_GAPS, :]
    grows = bool((last > _GROWS * first).any())
    own = 1 - seen / unseen  # K = 1 - P+ / P-
    is_larger = bool((K - own > _SMALLER).any())
    if not ((is_followed and (not is_exact or changes or grows)) or (changes and is_larger)):
        return None
    return trials.seen.problem(
        "gain kept",
        f"its gain is the same ({K.min():.3g}) when the robot has been seen for long and after a "
        f"gap, but its covariance would give {own.min():.2g}: compute K = P H' / (H P H' + R) at "
        "every measurement, not once",
        DISPLACED_AT,
        line_of_measurement(trials.estimator),
    )


def claim_problems(trials: Trials, gains: Gains) -> Iterator[Problem]:
    """Yield a problem if P holds standard deviations, or P+ = K R / n: n measurements for one."""
    K = gains.after_gap
    if (abs(K - 1) > _SHARE).any():
        return
    claimed = variances(trials.gap)[UNSEEN.stop] / K
    own = list(_variances_known(trials))
    if any(_is_same(claimed, one) for one in own):
        return
    pairs = list(product(_REPEATED, (claimed, claimed**2)))
    n, claim = next(
        (
            (n, claim)
            for n, claim in pairs
            if any(_is_same(n * claim, R) for R in (*own, np.square(MEASUREMENT_SIGMA)))
        ),
        (1, claimed),
    )
    if claim is not claimed:
        yield trials.gap.problem(
            "standard deviations",
            "its covariance has standard deviations instead of variances: after a measurement they "
            "are the roots of R; return P itself, in px^2 and rad^2",
            UNSEEN.stop,
            line_of_covariance(trials.estimator),
        )
    if n > 1:
        yield trials.gap.problem(
            "measurement repeated",
            f"after a measurement its covariance is 1/{n} of R, as if one measurement were {n} "
            "independent ones; update once with each",
            UNSEEN.stop,
            line_of_measurement(trials.estimator),
        )


def _is_same(one: Floats, other: Floats) -> bool:
    return bool((abs(one / other - 1) < _SAME).all())


def _variances_known(trials: Trials) -> Iterator[Floats]:
    """Yield numbers of an estimator that could be the variances (3,) of a measurement."""
    for one in arrays_in(trials.estimator.made, shared=True):
        if one.shape == (3, 3) and (np.diag(one) > 0).all():
            yield np.diag(one)
        elif one.shape == (3,) and (one > 0).all():
            yield one
            yield one**2
