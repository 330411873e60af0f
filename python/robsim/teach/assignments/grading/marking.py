"""From the numbers of a test to its points, its status and a sentence."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from robsim.teach.assignments.assignment import TaskTest
from robsim.teach.assignments.grading import sentences
from robsim.teach.assignments.results import (
    FAILED,
    PARTIAL,
    PASSED,
    FailedRun,
    ScoreResult,
    TestResult,
)
from robsim.teach.errors import AssignmentError
from robsim.teach.tasks.score import Score, ScoreLimit

_ALL = 1 - 1e-9


#: The numbers of the runs that came through, by score.
Numbers = Mapping[str, Sequence[float]]


@dataclass(frozen=True, kw_only=True)
class Mark:
    """The mark of a test's runs by its limits and points; attributes as of `TestResult`."""

    runs: int
    failed: tuple[FailedRun, ...]
    scores: tuple[ScoreResult, ...]
    points: float
    status: str
    sentence: str


def mark_of(
    test: TaskTest, failed: Sequence[FailedRun], numbers: Numbers, reference: Numbers
) -> Mark:
    """Return the mark of a test; raise AssignmentError if a score has no limit.

    Parameters
    ----------
    test : TaskTest
        The test, with its points and limits.
    failed : sequence of FailedRun
        The runs that did not come through.
    numbers, reference : mapping of str to sequence of float
        By score: the numbers of the other runs, and the reference's numbers in the same runs.
    """
    scores = tuple(
        _scored(test, score, tuple(numbers[score.name]), tuple(reference[score.name]))
        for score in test.task.scores
    )
    runs = test.task.runs
    share = (1 - len(failed) / runs) * sum(score.share * score.fraction for score in scores)
    points = test.points if share >= _ALL else test.points * share
    status = status_of(points, test.points)
    return Mark(
        runs=runs,
        failed=tuple(failed),
        scores=scores,
        points=points,
        status=status,
        sentence=sentences.of(
            failed, scores, runs=runs, public=test.public, is_passed=status == PASSED
        ),
    )


def marked_anew(test: TaskTest, result: TestResult) -> TestResult:
    """Return a result with the points and sentences recomputed for the test."""
    numbers = {score.name: score.values for score in result.scores}
    reference = {score.name: score.reference for score in result.scores}
    mark = mark_of(test, result.failed, numbers, reference)
    return replace(result, **labels_of(test), **vars(mark))


def labels_of(test: TaskTest) -> dict[str, Any]:
    """Return the attributes that a result has from its test, except the name."""
    labels = {"title": test.title, "number": test.number, "public": test.public}
    return labels | {"most": test.points}


def status_of(points: float, most: float) -> str:
    """Return what so many points of so many are called."""
    if points >= most:
        return PASSED
    return PARTIAL if points > 0 else FAILED


def limit_of(test: TaskTest, score: Score) -> ScoreLimit:
    """Return the limit of a score; raise AssignmentError if there is none."""
    if score.name not in test.limits:
        raise AssignmentError(
            f"the test {test.name} has no limit for {score.name}: calibrate its limits first: "
            "robsim assignment calibrate",
            file="limits.json",
        )
    return test.limits[score.name]


def _scored(
    test: TaskTest, score: Score, values: tuple[float, ...], reference: tuple[float, ...]
) -> ScoreResult:
    limit = limit_of(test, score)
    statistic = score.statistic(values, reference) if values else math.nan
    return ScoreResult(
        name=score.name,
        title=score.title,
        unit=score.unit,
        values=values,
        reference=reference,
        statistic=statistic,
        limit=limit.full,
        zero=limit.zero,
        low=limit.low,
        low_zero=limit.low_zero,
        fraction=limit.fraction(statistic) if values else 0.0,
        share=score.share,
    )


def runs_by_badness(test: TaskTest, mark: Mark) -> list[int]:
    """Return the numbers of the runs that came through, the worst one in what lost most last."""
    scores = dict(zip(mark.scores, test.task.scores, strict=True))
    lost = max(mark.scores, key=lambda score: (1 - score.fraction) * score.share)

    def badness(values: tuple[int, float, float]) -> float:
        _, value, reference = values
        one = scores[lost].statistic((value,), (reference,))
        return abs(math.log(one)) if lost.low is not None else one

    failed = {run.run for run in mark.failed}
    runs = [run for run in range(mark.runs) if run not in failed]
    return [
        one[0] for one in sorted(zip(runs, lost.values, lost.reference, strict=True), key=badness)
    ]


def run_to_show(mark: Mark | TestResult, through: list[int]) -> int | None:
    """Return the run to show: the worst, or the first that failed where these cost more."""
    of_failed = len(mark.failed) / mark.runs
    of_scores = (1 - of_failed) * sum((1 - one.fraction) * one.share for one in mark.scores)
    if mark.failed and of_failed >= of_scores:
        begun = [run for run in mark.failed if run.step is not None]
        # One with steps before that, which can be drawn.
        return next((run.run for run in sorted(begun, key=lambda run: not run.step)), None)
    return through[-1] if through else None
