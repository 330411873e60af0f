"""Whether the covariance that an estimator claims is the one of its gain.

A Kalman filter has P+ = (I - K) P- and P+ = K R. Its gain K is measured, with displaced
measurements; P+ and P- are its own, of the same step with and without a measurement.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import product

import numpy as np

from robsim._core import Measurement
from robsim.base.check_report import Problem
from robsim.base.checks import Floats
from robsim.teach.doctor._kept import arrays_in
from robsim.teach.doctor._lines import line_of_covariance, line_of_measurement
from robsim.teach.doctor._situations import MEASUREMENT_SIGMA, UNSEEN
from robsim.teach.doctor.gain import Gains
from robsim.teach.doctor.trials import DISPLACED_AT, SETTLED, Trials, errors, variances

# Of a gain: rounding makes 1e-12. One that is exactly 1 hands the measurement on.
_EQUAL = 1e-8
_EXACT = 1e-10
_NEARLY_ALL = 0.98
_SMALLER = 0.25  # gain that the covariance asks for, below the one in use
_CHANGES = 0.05  # of the covariance
_GROWS = 1.5  # times, in the steps between two gaps
_GAPS = (30, 110)  # steps, the first ones of two gaps of equal length
# Standard deviations in place of variances: log(P+/P-) / log(1 - K) is 0.5, otherwise 1.
_HALF = (0.35, 0.68)
_LIKE_ERRORS = (0.3, 3.0)  # variances relative to the rms of the errors
_KNOWN = 0.95  # gain up to which 1 - K is known well
_SAME = 0.1
_REPEATED = range(1, 4)
_FACTOR = 4.0


def gain_problem(trials: Trials, gains: Gains) -> Problem | None:
    """Return whether the gain is that of one step, whatever the covariance is."""
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
    asked = 1 - seen / unseen  # K = 1 - P+ / P-
    is_larger = bool((K - asked > _SMALLER).any())
    if not ((is_followed and (not is_exact or changes or grows)) or (changes and is_larger)):
        return None
    return trials.seen.problem(
        "gain kept",
        f"its gain is the same ({K.min():.3g}) when the robot has been seen for long and after a "
        f"gap, while its covariance asks for {asked.min():.2g}: compute K = P H' / (H P H' + R) "
        "anew at every measurement, not once",
        DISPLACED_AT,
        line_of_measurement(trials.estimator),
    )


def claim_problems(trials: Trials, gains: Gains) -> Iterator[Problem | str]:
    """Yield whether it claims standard deviations, or P+ = K R / n: n measurements for one."""
    n, are_deviations, is_sure = _claim(trials, gains)
    if are_deviations or _are_roots(trials, gains):
        yield trials.seen.problem(
            "standard deviations",
            "its covariance has standard deviations in the place of variances: they are the roots "
            "of what its gain, or R, asks for; return P itself, in px^2 and rad^2",
            line=line_of_covariance(trials.estimator),
        )
    if n > 1 and is_sure:
        yield trials.gap.problem(
            "measurement repeated",
            f"after a measurement its covariance is 1/{n} of R: it takes one measurement for {n} "
            "independent ones; update once with each",
            UNSEEN.stop,
            line_of_measurement(trials.estimator),
        )
    elif n > 1:
        yield (
            f"its covariance after a measurement is 1/{n} of that of the measurement: right for "
            "another camera, or else it uses each measurement several times"
        )


def _claim(trials: Trials, gains: Gains) -> tuple[int, bool, bool]:
    """Return n, and whether there is a root, in P+ = K R / n, and whether R is its own."""
    claimed = variances(trials.gap)[UNSEEN.stop] / gains.after_gap
    own = list(_variances_known(trials))
    if any(_is_same(claimed, one) for one in own):
        return 1, False, True
    given = np.square(MEASUREMENT_SIGMA)
    for n, are_deviations in product(_REPEATED, (False, True)):
        of_claim = n * (claimed**2 if are_deviations else claimed)
        if any(_is_same(of_claim, one) for one in own):
            return n, are_deviations, True
        if (n > 1 or are_deviations) and _is_same(of_claim, given):
            return n, are_deviations, are_deviations or _follows(trials)
    return 1, False, True


def _are_roots(trials: Trials, gains: Gains) -> bool:
    """Return whether P+ / P- is the root of 1 - K, and P as large as the errors."""
    K = gains.usual
    ratio = variances(trials.seen)[DISPLACED_AT] / variances(trials.gap)[DISPLACED_AT]
    is_known = (K > 1 - _NEARLY_ALL) & (K < _KNOWN)
    if not is_known.any() or (abs(K - gains.after_gap) < _EQUAL).all():
        return False
    exponent = np.log(ratio[is_known]) / np.log(1 - K[is_known])
    rms = np.sqrt(np.mean(errors(trials.seen)[SETTLED:] ** 2, axis=0))
    size = np.mean(variances(trials.seen)[SETTLED:], axis=0) / rms
    (low, high), (least, most) = _HALF, _LIKE_ERRORS
    are_like_errors = least < size.min() and size.max() < most
    return bool(low < exponent.min() and exponent.max() < high and are_like_errors)


def _is_same(one: Floats, other: Floats) -> bool:
    return bool((abs(one / other - 1) < _SAME).all())


def _variances_known(trials: Trials) -> Iterator[Floats]:
    """Yield what an estimator knows that could be the variances (3,) of a measurement."""
    for one in arrays_in(trials.estimator.made, shared=True):
        if one.shape == (3, 3) and (np.diag(one) > 0).all():
            yield np.diag(one)
        elif one.shape == (3,) and (one > 0).all():
            yield one
            yield one**2


def _follows(trials: Trials) -> bool:
    """Return whether it takes the covariance of a measurement from the measurement."""
    drive = trials.gap.situation.first(UNSEEN.stop + 1)
    last = drive.measurements[-1]
    assert last is not None
    assert last.covariance is not None
    doubted = Measurement(last.pose, covariance=_FACTOR * last.covariance)
    trial = trials.estimator.try_in(
        replace(drive, measurements=(*drive.measurements[:-1], doubted))
    )
    if trial.error is not None:
        return False
    k = UNSEEN.stop
    return bool((variances(trial)[k] > np.sqrt(_FACTOR) * variances(trials.gap)[k]).all())
