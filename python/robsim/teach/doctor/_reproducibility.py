"""Checks that an estimator depends only on its own past steps: no shared state, no future data."""

from __future__ import annotations

import numpy as np

from robsim.base.check_report import Problem
from robsim.base.checks import Floats
from robsim.teach.doctor._errors import problem_of
from robsim.teach.doctor._situations import Situation
from robsim.teach.doctor._trial import EstimatorUnderTest, Trial

# Relative; the same sums may round differently where arrays lie differently in memory.
_TOLERANCE = 1e-6
_TOGETHER = 60  # steps


def first_difference(one: Floats, other: Floats) -> int | None:
    """Return the first step at which two histories of outputs differ; None = they do not."""
    steps = min(len(one), len(other))
    if steps == 0 or one.shape[1] != other.shape[1]:
        return None if steps == 0 else 0
    is_close = np.isclose(
        one[:steps], other[:steps], rtol=_TOLERANCE, atol=_TOLERANCE, equal_nan=True
    )
    differs = ~is_close.all(axis=1)
    return int(differs.argmax()) if differs.any() else None


def replay_problem(estimator: EstimatorUnderTest, alone: Trial) -> Problem | None:
    """Return whether a fresh estimator gives other results in the first half of the same run.

    The cause may be memory of the earlier run, data of future steps, or random numbers.

    Parameters
    ----------
    estimator : EstimatorUnderTest
        The estimator.
    alone : Trial
        The trial of a first fresh estimator.
    """
    again = estimator.try_in(alone.situation.first(len(alone.situation.u) // 2))
    step = _difference(again, alone)
    return None if step is None else _cause_of_difference(estimator, alone, again, step)


def together_problem(
    estimator: EstimatorUnderTest, alone: Trial, other: Situation
) -> Problem | None:
    """Return whether two estimators that run at the same time influence each other.

    Parameters
    ----------
    estimator : EstimatorUnderTest
        The estimator.
    alone : Trial
        The trial of a fresh estimator.
    other : Situation
        The situation of a second estimator that runs at the same time.
    """
    together = estimator.try_together(alone.situation.first(_TOGETHER), other)
    step = _difference(together, alone)
    if step is None:
        return None
    if isinstance(together.error, TimeoutError):
        return problem_of(estimator, together)
    return Problem(
        kind="shared memory",
        sentence=f"two {estimator.slot.noun}s from make() influence each other, as with a global "
        "variable or a list in the class: keep all state in self, set in __init__, or in variables "
        "of make",
        situation="two robots at the same time",
        k=step,
        line=estimator.line,
    )


def _difference(trial: Trial, alone: Trial) -> int | None:
    """Return the first step whose output differs from that of the first run, or fails."""
    step = first_difference(trial.outputs, alone.outputs)
    return trial.failed_at if step is None and trial.error else step


def _cause_of_difference(
    estimator: EstimatorUnderTest, alone: Trial, again: Trial, step: int
) -> Problem:
    if again.error is not None:
        return problem_of(estimator, again)
    whole = estimator.try_in(alone.situation)
    if _difference(whole, alone) is None:
        kind, sentence = (
            "depends on future",
            "its result depends on what comes later: the first half of a run alone gives another "
            "result than within the whole run",
        )
    elif _changes_less(alone.outputs, again.outputs, estimator.try_in(again.situation).outputs):
        kind, sentence = (
            "remembers earlier run",
            "a fresh one from make() remembers the run before: set all state in __init__ (or "
            "inside make), not in a global variable, the class or a default argument",
        )
    else:
        kind, sentence = (
            "not reproducible",
            "the same steps give another result each time: use random numbers with a fixed seed, "
            "np.random.default_rng(1), and step.t for the time",
        )
    return Problem(
        kind=kind, sentence=sentence, situation=again.situation.name, k=step, line=estimator.line
    )


def _changes_less(first: Floats, second: Floats, third: Floats) -> bool:
    """Return whether the third run differs less from the second than the second from the first."""
    if len(third) != len(second):
        return False
    before = np.nanmax(abs(second - first[: len(second)]))
    return bool(np.nanmax(abs(third - second)) < 0.2 * before)
