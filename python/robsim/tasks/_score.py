"""`Score`: a number that a run of a task is scored by, and how those of several runs make one."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from robsim._base.checks import Floats, check_choice

KINDS = ("ratio", "consistency")


@dataclass(frozen=True, kw_only=True)
class Score:
    """A number that each run of a task has, and what it is.

    Parameters
    ----------
    name : str
        Its name, as in the numbers that `Task.score` returns.
    title : str
        What it is, for people.
    unit : str
        Its unit; "" = none.
    kind : {"ratio", "consistency"}
        How runs are put together; see `statistic`.
    share : float
        Its share of the points of a test; those of a task sum to 1.
    floor, worst : float
        What is better than `floor` counts as `floor`; what is worse than `worst`, or not a number,
        as `worst`.

    Raises
    ------
    ValueError
        If the kind is none of these.
    """

    name: str
    title: str
    unit: str = ""
    kind: str = "ratio"
    share: float = 1.0
    floor: float
    worst: float

    def __post_init__(self) -> None:
        check_choice("kind", self.kind, KINDS)

    def statistic(self, values: Sequence[float], reference: Sequence[float]) -> float:
        """Return what the numbers of some runs come to, relative to those of a reference.

        Parameters
        ----------
        values, reference : sequence of float, (M,)
            The numbers of a submission and of the reference, of the same runs in the same order.

        Returns
        -------
        float
            With kind ``"ratio"`` the geometric mean of value over reference: 1 is as good, 2 twice
            as bad. With ``"consistency"`` that of the values alone, which should be 1.

        Notes
        -----
        A geometric mean, since a single run in which a robot is lost, of which there are some with
        any method, outweighs in a mean of squares all others together.
        """
        # statistic = exp(mean over runs of log(value / reference))
        logs = self._logs(values)
        if self.kind == "ratio":
            logs = logs - self._logs(reference)
        return math.exp(float(np.mean(logs)))

    def _logs(self, values: Sequence[float]) -> Floats:
        numbers = np.asarray(values, float)
        logs: Floats = np.log(
            np.clip(np.where(np.isnan(numbers), self.worst, numbers), self.floor, self.worst)
        )
        return logs
