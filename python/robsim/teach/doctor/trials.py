"""The trials of a state estimator that several of its checks use."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np

from robsim.base.checks import Floats
from robsim.teach.doctor._kept import arrays_in
from robsim.teach.doctor._situations import (
    UNSEEN,
    Situation,
    blinking,
    pose_difference,
    turning,
    weaving,
)
from robsim.teach.doctor._trial import EstimatorUnderTest, Trial

SETTLED = 50  # steps after which the estimate has to be near the truth
DISPLACED_AT = UNSEEN.start  # the step from which the measurements are displaced
OFFSET = np.array((1.0, -1.0, 0.02))  # px, px, rad: two sigma, no outlier
_WATCHED = 12  # steps
_PUSH = 0.1  # V
_COMPARED = 40  # steps
_FOUND_AGAIN = 25  # steps with measurements after a gap; a right filter recovers in this time
_LOST_BY = (5.0, 0.2)  # px, rad
_MAXIMUM_ERROR = (100.0, 1.2)  # px, rad: beyond it the estimate has diverged


class Trials:
    """Trials of one estimator at one sample time (s), each run at its first use."""

    def __init__(self, estimator: EstimatorUnderTest, dt: float) -> None:
        self.estimator = estimator
        self.weaves, self.turns, self.blinks = weaving(dt), turning(dt), blinking(dt)
        self.kept: dict[str, list[Floats]] = {}

    @cached_property
    def seen(self) -> Trial:
        """The robot weaves and is seen at every step."""
        return self.estimator.try_in(self.weaves)

    @cached_property
    def displaced(self) -> Trial:
        """The same, but all measurements from `DISPLACED_AT` on are displaced."""
        drive = self.weaves.displaced(OFFSET, DISPLACED_AT)
        return self.estimator.try_in(drive.first(DISPLACED_AT + _WATCHED))

    @property
    def undisplaced(self) -> Trial:
        """The steps of that trial before a measurement is displaced."""
        trial, start = self.displaced, DISPLACED_AT
        error = None if trial.failed_at >= start else trial.error
        drive = self.weaves.first(start)
        return replace(trial, situation=drive, outputs=trial.outputs[:start], error=error)

    @cached_property
    def gap(self) -> Trial:
        return self.estimator.try_in(self._gap, self._keep("gap"))

    @cached_property
    def pushed(self) -> Trial:
        """The gap, with more voltage on the left motor than in the other trial."""
        drive = self._gap.pushed(UNSEEN, _PUSH).first(UNSEEN.stop)
        return self.estimator.try_in(drive, self._keep("pushed"))

    @cached_property
    def late(self) -> Trial:
        return self.estimator.try_in(self.weaves.unseen("robot not seen yet", range(5)).first(8))

    @cached_property
    def hidden(self) -> Trial:
        return self.estimator.try_in(self.blinks)

    @cached_property
    def turned(self) -> Trial:
        return self.estimator.try_in(self.turns)

    @property
    def _gap(self) -> Situation:
        return self.weaves.unseen("robot out of sight", UNSEEN)

    def _keep(self, name: str) -> Callable[[int, Any], None]:
        """Return a function that keeps an estimator's numbers at the first step with new inputs."""

        def watch(k: int, made: Any) -> None:
            if k == UNSEEN.start + 1:
                self.kept[name] = [np.array(one) for one in arrays_in(made, shared=True)]

        return watch

    @cached_property
    def response(self) -> tuple[Floats, Floats]:
        """The changes of the estimate and of the robot by the voltages in the gap, (N, 3)."""
        trials = (self.pushed, self.gap)
        by_trial = [
            [poses[UNSEEN.start : UNSEEN.stop, :3] for poses in pair]
            for pair in zip(*((one.outputs, one.situation.poses) for one in trials), strict=True)
        ]
        own, true = (pose_difference(*pair) for pair in by_trial)
        return own, true

    @cached_property
    def diverged_at(self) -> int | None:
        """The first step, after it has settled, at which the estimate is far from the truth."""
        distance, angle = distances(self.seen)
        is_off = (distance > _MAXIMUM_ERROR[0]) | (angle > _MAXIMUM_ERROR[1])
        is_off[:SETTLED] = False
        return int(is_off.argmax()) if is_off.any() else None

    @cached_property
    def is_lost_after_gap(self) -> bool:
        """Whether the estimate is far off long after a gap, but not without the gap."""
        (gap, gap_angle), (seen, seen_angle) = distances(self.gap), distances(self.seen)
        last = slice(UNSEEN.stop + _FOUND_AGAIN, None)
        is_off = gap[last].min() > _LOST_BY[0] + seen[SETTLED:].max()
        is_turned = gap_angle[last].min() > _LOST_BY[1] + seen_angle[SETTLED:].max()
        return bool(is_off or is_turned)

    @cached_property
    def way_in_gap(self) -> float:
        """The estimated distance while the robot is not seen, relative to the true distance."""
        steps = slice(UNSEEN.start - 1, UNSEEN.stop)
        lengths = [
            np.hypot(*np.diff(poses[steps, :2], axis=0).T).sum()
            for poses in (self.gap.outputs, self.weaves.poses)
        ]
        return float(lengths[0] / lengths[1])

    @cached_property
    def ignores_inputs(self) -> bool:
        return not self.response[0].any() and self.is_unchanged(
            replace(self.blinks, u=self.blinks.u + 0.1)
        )

    def is_unchanged(self, changed: Situation) -> bool:
        outputs = self.estimator.try_in(changed.first(_COMPARED)).outputs
        return np.array_equal(self.hidden.outputs[:_COMPARED], outputs)


def errors(trial: Trial) -> Floats:
    """Return the estimates minus the truth (N, 3), in px, px, rad."""
    return pose_difference(trial.outputs[:, :3], trial.situation.poses[: len(trial.outputs)])


def distances(trial: Trial) -> tuple[Floats, Floats]:
    """Return the distance (px) and the angle (rad) between estimate and truth, step by step."""
    error = errors(trial)
    return np.hypot(error[:, 0], error[:, 1]), abs(error[:, 2])


def variances(trial: Trial) -> Floats:
    """Return the estimator's variances of x, y and the heading (N, 3)."""
    return trial.outputs[:, [3, 7, 11]]
