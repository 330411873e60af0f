"""From the numbers of a test to its points, its status and a sentence."""

from __future__ import annotations

import math
from dataclasses import replace

from robsim.teach.assignments.assignment import TaskTest
from robsim.teach.assignments.grading import sentences
from robsim.teach.assignments.results import FAILED, PARTIAL, PASSED, ScoreResult, TestResult
from robsim.teach.errors import AssignmentError
from robsim.teach.tasks.score import Limit, Score

_ALL = 1 - 1e-9


def marked(test: TaskTest, result: TestResult) -> TestResult:
    """Return a result with the points and sentences that follow from its numbers.

    Parameters
    ----------
    test : TaskTest
        The test, with its points and limits.
    result : TestResult
        The numbers of its runs; points and limits that it has do not count.

    Raises
    ------
    AssignmentError
        If a score has no limit.
    """
    numbers = {score.name: score for score in result.scores}
    scores = tuple(_scored(test, score, numbers[score.name]) for score in test.task.scores)
    through = 1 - len(result.failed) / result.runs
    share = through * sum(score.share * score.fraction for score in scores)
    points = test.points if share >= _ALL else test.points * share
    new = replace(
        result,
        title=test.title,
        number=test.number,
        public=test.public,
        points=points,
        most=test.points,
        status=status_of(points, test.points),
        scores=scores,
    )
    return replace(new, sentence=sentences.of(new))


def status_of(points: float, most: float) -> str:
    """Return what so many points of so many are called."""
    if points >= most:
        return PASSED
    return PARTIAL if points > 0 else FAILED


def limit_of(test: TaskTest, score: Score) -> Limit:
    """Return the limit of a score; raise AssignmentError if there is none."""
    if score.name not in test.limits:
        raise AssignmentError(
            f"the test {test.name} has no limit for {score.name}: calibrate its limits first: "
            "robsim assignment calibrate",
            file="limits.json",
        )
    return test.limits[score.name]


def _scored(test: TaskTest, score: Score, numbers: ScoreResult) -> ScoreResult:
    limit = limit_of(test, score)
    came_through = len(numbers.values) > 0
    statistic = score.statistic(numbers.values, numbers.reference) if came_through else math.nan
    return replace(
        numbers,
        title=score.title,
        unit=score.unit,
        statistic=statistic,
        limit=limit.full,
        zero=limit.zero,
        low=limit.low,
        low_zero=limit.low_zero,
        fraction=limit.fraction(statistic) if came_through else 0.0,
        share=score.share,
    )


def runs_by_badness(test: TaskTest, result: TestResult) -> list[int]:
    """Return the numbers of the runs that came through, the worst one in what lost most last."""
    scores = dict(zip(result.scores, test.task.scores, strict=True))
    lost = max(result.scores, key=lambda score: (1 - score.fraction) * score.share)

    def badness(values: tuple[int, float, float]) -> float:
        _, value, reference = values
        one = scores[lost].statistic((value,), (reference,))
        return abs(math.log(one)) if lost.low is not None else one

    failed = {run.run for run in result.failed}
    runs = [run for run in range(result.runs) if run not in failed]
    return [
        one[0] for one in sorted(zip(runs, lost.values, lost.reference, strict=True), key=badness)
    ]
