"""Which numbers of a sample an estimator's parameters depend on, and from which step on.

The same drive is tried again with one pose, or one input, displaced. A pose stands in the y of its
step and in the phi of the next two; an input in the phi of the step after it.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from robsim.teach.doctor._situations import Situation
from robsim.teach.doctor._trial import EstimatorUnderTest, Trial

DISPLACED_AT = 200  # the step
_OFFSET = (3.0, 3.0, 0.1)  # px, px, rad: far beyond the noise, so that no dead zone hides it
_VOLTS = 0.3
_WATCHED = 30  # steps
_CHANGE = 1e-9  # relative; less is rounding
_IN_PHI = 2  # steps for which a pose stands in phi
Delays = list[int | None]


class Influence:
    """The steps after which the parameters change, with what is displaced.

    Parameters
    ----------
    estimator : EstimatorUnderTest
        The estimator.
    usual : Trial
        Its trial without displacement.
    """

    def __init__(self, estimator: EstimatorUnderTest, usual: Trial) -> None:
        self._estimator = estimator
        self._usual = usual

    @cached_property
    def of_input(self) -> Delays:
        """Steps until each row of the parameters changes with an input in phi; None = never."""
        u = self._usual.situation.u.copy()
        u[DISPLACED_AT - 1] += _VOLTS
        return _delays(self._changed(replace(self._usual.situation, u=u)))

    @cached_property
    def of_pose(self) -> list[Delays]:
        """The same for a pose, first in y: a list for each component that is displaced."""
        return [_delays(self._changed(self._displaced(axis))) for axis in range(3)]

    @cached_property
    def memory(self) -> int | None:
        """The number of samples after which one is forgotten; None = longer than was watched."""
        changed = self._changed(self._displaced(0)).any(axis=1)
        if not changed.any():
            return 0
        last = int(np.flatnonzero(changed)[-1])
        return None if last == _WATCHED - 1 else max(0, last - _IN_PHI) + 1

    @property
    def is_none(self) -> bool:
        """Whether nothing of a sample has any effect."""
        delays = [*self.of_input, *(delay for one in self.of_pose for delay in one)]
        return all(delay is None for delay in delays)

    @property
    def is_mismatched(self) -> tuple[bool, bool]:
        """Whether y comes later than phi, and whether phi comes later than y."""
        own = [one[axis] for axis, one in enumerate(self.of_pose)]
        pairs = [
            (y, phi)
            for y, phi in zip(own, self.of_input, strict=True)
            if y is not None and phi is not None
        ]
        return any(y > phi for y, phi in pairs), any(phi > y for y, phi in pairs)

    @property
    def mixed(self) -> list[tuple[int, int]]:
        """The pairs of axes (of the sample, of the parameters) of which one changes the other."""
        return [
            (i, j)
            for i, one in enumerate(self.of_pose)
            for j, delay in enumerate(one)
            # The heading stands in phi of x and y, too.
            if i != j and delay is not None and not (i == 2 and delay > 0)
        ]

    def _displaced(self, axis: int) -> Situation:
        poses = self._usual.situation.poses.copy()
        poses[DISPLACED_AT, axis] += _OFFSET[axis]
        return replace(self._usual.situation, poses=poses)

    def _changed(self, displaced: Situation) -> npt.NDArray[np.bool_]:
        """Return whether each row of the parameters differs (N, 3), from the step on."""
        steps = slice(DISPLACED_AT, DISPLACED_AT + _WATCHED)
        after = self._estimator.try_in(displaced.first(steps.stop)).outputs[steps]
        before = self._usual.outputs[steps][: len(after)]
        differs = abs(after - before) > _CHANGE * (1 + abs(before))
        return np.asarray(differs.reshape(-1, 3, 5).any(axis=2))


def _delays(changed: npt.NDArray[np.bool_]) -> Delays:
    return [int(one.argmax()) if one.any() else None for one in changed.T]
