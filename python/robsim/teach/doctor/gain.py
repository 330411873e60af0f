"""The effect of a measurement on an estimate: its size and its delay.

The doctor repeats a drive with displaced measurements. The gain of any filter is the change of its
estimate divided by the displacement.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property

import numpy as np
import numpy.typing as npt

from robsim.base.check_report import Problem
from robsim.base.checks import Floats
from robsim.teach.doctor._lines import line_of_covariance, line_of_measurement
from robsim.teach.doctor._situations import UNSEEN, pose_difference
from robsim.teach.doctor._trial import Trial
from robsim.teach.doctor.trials import DISPLACED_AT, OFFSET, Trials, distances

AXES = ("x", "y", "heading")
_FAR = 30.0  # times as far
_RESPONSE = 1e-6  # of the displacement; less is rounding
_NO_Q = "no process noise"
_DIVERGES = "diverges from truth"
UNKNOWN_CAUSES = (_NO_Q, _DIVERGES)  # of a divergence, which inputs may have, too
_LOST = 1e6  # px; beyond it a displacement of 1 px is lost in rounding
_HARDLY = 0.2  # a gain below it leaves a moving robot behind


def named(chosen: npt.NDArray[np.bool_]) -> str:
    return " and ".join(name for name, one in zip(AXES, chosen, strict=True) if one)


def delays(changed: npt.NDArray[np.bool_]) -> list[int | None]:
    """Return the first step in which each column is set; None = it never is."""
    return [int(one.argmax()) if one.any() else None for one in changed.T]


class Gains:
    """The responses of an estimator to measurements.

    A gain is the share of a measurement's displacement that the estimate follows at once.
    """

    def __init__(self, trials: Trials) -> None:
        self._trials = trials

    @cached_property
    def in_time(self) -> Floats:
        """The response (N, 3) from the first displaced measurement on."""
        return self._changes(self._trials.seen, DISPLACED_AT, self._trials.displaced)

    @property
    def usual(self) -> Floats:
        """The gain when the robot has been seen for a long time, (3,)."""
        return np.asarray(self.in_time[0])

    @property
    def delay(self) -> list[int | None]:
        """The number of steps until each component changes then; None = it does not."""
        return delays(abs(self.in_time) > _RESPONSE)

    @cached_property
    def far(self) -> Floats:
        """The gain (2, 3) of measurements that are displaced far, to either side."""
        offsets = (_FAR * OFFSET, -_FAR * OFFSET)
        return np.array([self._at_once(self._trials.seen, DISPLACED_AT, one) for one in offsets])

    @cached_property
    def after_gap(self) -> Floats:
        """The gain of the first measurement after a while out of sight, (3,)."""
        return self._at_once(self._trials.gap, UNSEEN.stop, OFFSET)

    @cached_property
    def first(self) -> Floats:
        """The gain of the second measurement (3, 3): of each component on each."""
        columns = [
            self._at_once(self._trials.seen, 1, offset) * OFFSET for offset in np.diag(OFFSET)
        ]
        # K(i, j) = change of i / displacement of j
        return np.asarray(np.array(columns).T / OFFSET)

    def _at_once(self, usual: Trial, start: int, offset: Floats) -> Floats:
        """Return the change of an estimate (3,) by a displaced measurement of the same step."""
        drive = usual.situation.displaced(offset, start).first(start + 1)
        return np.asarray(self._changes(usual, start, self._trials.estimator.try_in(drive))[0])

    def _changes(self, usual: Trial, start: int, trial: Trial) -> Floats:
        """Return the changes of an estimate (N, 3) from a step on, in units of `OFFSET`."""
        before, after = (one.outputs[start : len(trial.outputs), :3] for one in (usual, trial))
        if len(after) == 0:
            return np.zeros((1, 3))
        with np.errstate(all="ignore"):
            return np.asarray(pose_difference(after, before[: len(after)]) / OFFSET)


def ignored_problem(trials: Trials, gains: Gains) -> Problem | None:
    if any(one is not None for one in gains.delay):
        return None
    if trials.diverged_at is not None and (abs(gains.first) > _RESPONSE).any():
        return None
    return trials.seen.problem(
        "ignores measurement",
        "its estimate is the same wherever the robot is seen: step.measurement.pose has no effect",
        line=line_of_measurement(trials.estimator),
    )


def unused_problem(trials: Trials, gains: Gains) -> Problem | None:
    if trials.diverged_at is not None:
        return None
    is_unused = np.array([one is None for one in gains.delay])
    # A gate may leave out one that is displaced little, but not all.
    if is_unused.any():
        is_unused &= np.max(abs(gains.far), axis=0) <= _RESPONSE
    if not is_unused.any():
        return None
    return trials.seen.problem(
        "ignores measurement",
        f"its estimate of {named(is_unused)} ignores the measured value: use all of "
        "step.measurement.pose, x, y and heading",
        line=line_of_measurement(trials.estimator),
    )


def late_problem(trials: Trials, gains: Gains) -> Problem | None:
    if trials.diverged_at is not None or not any(gains.delay):
        return None
    # The median of some measurements does not move with one that stays the largest.
    at_once = np.max(abs(gains.far), axis=0).tolist()
    late = [
        (name, n)
        for name, n, gain in zip(AXES, gains.delay, at_once, strict=True)
        if n and gain < _RESPONSE
    ]
    if not late:
        return None
    names = " and ".join(name for name, _ in late) if len(late) < 3 else "pose"
    steps = max(n for _, n in late)
    count = "one step" if steps == 1 else f"{steps} steps"
    return trials.seen.problem(
        "measurement late",
        f"the {names} measured at a step has no effect on its estimate of that step, but "
        f"{count} later: it uses the measurement of an earlier step, or returns the estimate of an "
        "earlier step (the prediction before the update): these cannot be distinguished, because "
        "both give the same numbers",
        DISPLACED_AT,
        line_of_measurement(trials.estimator),
    )


def divergence_problem(trials: Trials, gains: Gains) -> Problem | None:
    k = trials.diverged_at
    if k is None:
        return None
    distance, angle = distances(trials.seen)
    kind, cause = _cause(gains, is_near=float(distance.max()) < _LOST)
    line_of = line_of_covariance if kind == _NO_Q else line_of_measurement
    return trials.seen.problem(
        kind,
        f"its estimate is {distance[k]:.3g} px and {np.degrees(angle[k]):.0f} degrees off, "
        f"although the robot is seen at every step: {cause}",
        k,
        line_of(trials.estimator),
    )


def _cause(gains: Gains, *, is_near: bool) -> tuple[str, str]:
    K = gains.first
    own, others = np.diag(K), abs(K - np.diag(np.diag(K)))
    plane = own[:2]
    if (own < -_HARDLY).any() and (others < 0.5).all():
        return (
            "gain of wrong sign",
            f"displaced by 1, {named(own < -_HARDLY)} moves by {own.min():.2g} at the second "
            "step: the innovation is measured - predicted, and must be added",
        )
    if (abs(plane) < others[:2, :2].max(axis=1)).all():
        return (
            "components exchanged",
            "a displaced measured x moves its y, and the other way round: the order is "
            "x, y, heading",
        )
    if abs(own[2]) > 20 or 0 < abs(own[2]) < 1 / 20 < plane.min():
        return (
            "heading in degrees",
            f"a measured heading displaced by 1 rad moves its heading by {own[2]:.3g}: headings "
            "are in rad, also the heading of Estimate",
        )
    if (own > 1.5).any():
        return (
            "gain too large",
            f"displaced by 1, {named(own > 1.5)} moves by {own.max():.3g} at the second step: a "
            "gain K is at most 1; check K = P H' / (H P H' + R)",
        )
    if is_near and (stopped := stopped_listening(gains)):
        return stopped
    return (
        _DIVERGES,
        "its first gains are right: check the prediction, units (heading in rad) and the "
        "order x, y, heading",
    )


def stopped_listening(gains: Gains) -> tuple[str, str] | None:
    usual, first = abs(gains.usual), np.diag(gains.first)
    if (usual >= _HARDLY).any():
        return None
    return (
        _NO_Q,
        f"it follows a displaced measurement by {usual.max():.2g} at step {DISPLACED_AT} "
        f"({first.max():.2g} at the second step): it has stopped listening, because its covariance "
        "has become too small; add the process noise Q at each prediction, P = F P F' + Q, or a "
        "larger one",
    )


def gain_remarks(trials: Trials, gains: Gains) -> Iterator[str]:
    if trials.diverged_at is not None:
        return
    gain = gains.usual
    if np.allclose(gain, 1, atol=1e-9):
        yield (
            "it only passes the measurement on (its gain is 1): nothing is filtered while the "
            "robot is seen"
        )
    elif (abs(gain) < 0.05).all() and not any(gains.delay):
        yield (
            f"it hardly listens to measurements (its gain is {abs(gain).max():.2g}): "
            "correct only if its model is exact, without disturbances, slip and walls"
        )
