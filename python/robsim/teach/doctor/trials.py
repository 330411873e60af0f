"""The trials of a state estimator that several of its checks look at."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property

import numpy as np

from robsim.base.checks import Floats
from robsim.teach.doctor._situations import (
    UNSEEN,
    Situation,
    blinking,
    pose_difference,
    turning,
    weaving,
)
from robsim.teach.doctor._trial import EstimatorUnderTest, Trial

SETTLED = 60  # steps after which the estimate has to be near the truth
_FOUND_AGAIN = 25  # steps with measurements after a gap; in this time a right one is back
_LOST_BY = (5.0, 0.2)  # px, rad
_MAXIMUM_ERROR = (100.0, 1.2)  # px, rad: beyond it the estimate has diverged


class Trials:
    """Trials of one estimator at one sample time (s), each run when it is first looked at."""

    def __init__(self, estimator: EstimatorUnderTest, dt: float) -> None:
        self.estimator = estimator
        self.weaves, self.turns, self.blinks = weaving(dt), turning(dt), blinking(dt)

    @cached_property
    def seen(self) -> Trial:
        """The robot weaves and is seen at every step."""
        return self.estimator.try_in(self.weaves)

    @cached_property
    def gap(self) -> Trial:
        return self.estimator.try_in(self.weaves.unseen("robot out of sight", UNSEEN))

    @cached_property
    def late(self) -> Trial:
        return self.estimator.try_in(self.weaves.unseen("robot not seen yet", range(5)))

    @cached_property
    def hidden(self) -> Trial:
        return self.estimator.try_in(self.blinks)

    @cached_property
    def turned(self) -> Trial:
        return self.estimator.try_in(self.turns)

    @cached_property
    def diverged_at(self) -> int | None:
        """The first step, after it has settled, at which the estimate is far from the truth."""
        distance, angle = distances(self.seen)
        is_off = (distance > _MAXIMUM_ERROR[0]) | (angle > _MAXIMUM_ERROR[1])
        is_off[:SETTLED] = False
        return int(is_off.argmax()) if is_off.any() else None

    @cached_property
    def is_lost_after_gap(self) -> bool:
        """Whether it is still far off long after it was seen again, but not without the gap."""
        (gap, gap_angle), (seen, seen_angle) = distances(self.gap), distances(self.seen)
        last = slice(UNSEEN.stop + _FOUND_AGAIN, None)
        is_off = gap[last].min() > _LOST_BY[0] + seen[SETTLED:].max()
        is_turned = gap_angle[last].min() > _LOST_BY[1] + seen_angle[SETTLED:].max()
        return bool(is_off or is_turned)

    @cached_property
    def way_in_gap(self) -> float:
        """The length of the estimated way while the robot is not seen, relative to the true one."""
        steps = slice(UNSEEN.start - 1, UNSEEN.stop)
        lengths = [
            np.hypot(*np.diff(poses[steps, :2], axis=0).T).sum()
            for poses in (self.gap.outputs, self.weaves.poses)
        ]
        return float(lengths[0] / lengths[1])

    @cached_property
    def ignores_inputs(self) -> bool:
        return self.is_unchanged(replace(self.blinks, u=self.blinks.u + 0.1))

    def is_unchanged(self, changed: Situation) -> bool:
        return np.array_equal(self.hidden.outputs, self.estimator.try_in(changed).outputs)


def errors(trial: Trial) -> Floats:
    """Return the estimates minus the truth (N, 3), in px, px, rad."""
    return pose_difference(trial.outputs[:, :3], trial.situation.poses[: len(trial.outputs)])


def distances(trial: Trial) -> tuple[Floats, Floats]:
    """Return the distance (px) and the angle (rad) between estimate and truth, step by step."""
    error = errors(trial)
    return np.hypot(error[:, 0], error[:, 1]), abs(error[:, 2])


def variances(trial: Trial) -> Floats:
    """Return the variances it gives of x, y and the heading (N, 3)."""
    return trial.outputs[:, [3, 7, 11]]
