"""The points, status and sentence of a test from its numbers."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from robsim.teach.assignments.assignment import TaskTest
from robsim.teach.assignments.limits_file import FILE
from robsim.teach.errors import EXIT, TIMEOUT, AssignmentError
from robsim.teach.results import FAILED, PARTIAL, PASSED, FailedRun, ScoreResult, TestResult
from robsim.teach.tasks.score import Score, ScoreLimit, share_of_points
from robsim.teach.texts import clean_line

_ALL = 1 - 1e-9


#: The numbers of the completed runs, by score.
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

    `numbers` and `reference` belong to the same runs, without failed ones.
    """
    scores = [
        _scored(test, score, tuple(numbers[score.name]), tuple(reference[score.name]))
        for score in test.task.scores
    ]
    parts = share_of_points(test.task.scores, [score.fraction for score in scores])
    scores = [replace(one, fraction=part) for one, part in zip(scores, parts, strict=True)]
    runs = test.task.runs
    share = (1 - len(failed) / runs) * sum(score.share * score.fraction for score in scores)
    points = test.points if share >= _ALL else test.points * share
    status = PASSED if points >= test.points else PARTIAL if points > 0 else FAILED
    return Mark(
        runs=runs,
        failed=tuple(failed),
        scores=tuple(scores),
        points=points,
        status=status,
        sentence=_sentence(
            failed, scores, runs=runs, public=test.public, is_passed=status == PASSED
        ),
    )


def marked_anew(test: TaskTest, result: TestResult) -> TestResult:
    numbers = {score.name: score.values for score in result.scores}
    reference = {score.name: score.reference for score in result.scores}
    mark = mark_of(test, result.failed, numbers, reference)
    return replace(result, **labels_of(test), **vars(mark))


def labels_of(test: TaskTest) -> dict[str, Any]:
    """Return the attributes that a result has from its test, except the name."""
    names = ("title", "number", "public", "provisional")
    return {"most": test.points} | {name: getattr(test, name) for name in names}


def limit_of(test: TaskTest, score: Score) -> ScoreLimit:
    """Return the limit of a score; raise AssignmentError if it is missing, or of another task."""
    if test.stale:
        raise AssignmentError(f"the limits of the test {test.name}: {test.stale}", file=FILE)
    if score.name not in test.limits:
        raise AssignmentError(
            f"the test {test.name} has no limit for {score.name}: calibrate first with "
            "robsim assignment calibrate",
            file=FILE,
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
    """Return the numbers of the completed runs, the worst run of the costliest score last.

    Of runs that are equal in this score, the next costly one decides.
    """
    scores = [*zip(mark.scores, test.task.scores, strict=True)]
    scores.sort(key=lambda pair: -_loss(pair[0]))

    def badness(place: int) -> list[float]:
        found = []
        for score, kind in scores:
            value, reference = score.values[place], score.reference[place]
            one = kind.statistic((value,), (reference,))
            one = abs(math.log(one)) if score.low is not None else one
            found.append(math.inf if math.isnan(value) else one)
        return found

    failed = {run.run for run in mark.failed}
    runs = [run for run in range(mark.runs) if run not in failed]
    return [runs[place] for place in sorted(range(len(runs)), key=badness)]


def run_to_show(mark: Mark | TestResult, through: list[int]) -> int | None:
    """Return the run to show: the worst, or the first failed run if failures cost more."""
    of_failed = len(mark.failed) / mark.runs
    of_scores = (1 - of_failed) * sum((1 - one.fraction) * one.share for one in mark.scores)
    if mark.failed and of_failed >= of_scores:
        begun = [run for run in mark.failed if run.step is not None]
        # A failed run with steps, which can be drawn.
        return next((run.run for run in sorted(begun, key=lambda run: not run.step)), None)
    return through[-1] if through else None


_MOST_REASON = 300  # characters

#: The end of a run, in words that reveal nothing about the run.
_HOW = {TIMEOUT: "took too long", EXIT: "ended its process"}


def _sentence(
    failed: Sequence[FailedRun],
    scores: Sequence[ScoreResult],
    *,
    runs: int,
    public: bool,
    is_passed: bool,
) -> str:
    """Return the sentence on a test, without numbers of hidden runs."""
    parts = []
    if failed:
        parts.append(_of_failed(failed, runs, public=public))
    if len(failed) < runs:
        parts.append(_of_scores(scores, runs - len(failed), public=public, is_passed=is_passed))
    return " ".join(parts)


def _of_failed(failed: Sequence[FailedRun], runs: int, *, public: bool) -> str:
    first = failed[0]
    if not public:  # an error's text may reveal the hidden run
        by = first.slot if first.slot is not None else "the submission"
        which = "All" if len(failed) == runs else "Some"
        return f"{which} runs ended early: {by} {_HOW.get(first.cause, 'failed')}."
    reason = clean_line(first.reason.rstrip("."), _MOST_REASON)
    if len(failed) == runs:
        return f"All runs failed. Run {first.run}: {reason}."
    return f"{len(failed)} of {runs} runs ended early. Run {first.run}: {reason}."


def _of_scores(
    scores: Sequence[ScoreResult], through: int, *, public: bool, is_passed: bool
) -> str:
    lost = [replace(score, title=_subject(score)) for score in scores if not score.is_met]
    lost.sort(key=_loss, reverse=True)
    if not lost:
        if is_passed:
            return "All scores are as good as required."
        return "The other scores were as good as required."
    if public:
        return _missing(lost, through) or _told(lost[0], through)
    told: dict[str, list[str]] = {}
    for score in lost:
        told.setdefault(_direction(score), []).append(f"the {score.title}")
    return " ".join(_are(titles, direction) for direction, titles in told.items())


def _loss(score: ScoreResult) -> float:
    """Return the points that a score loses; 0 = all points."""
    return 0.0 if score.is_met else (1 - score.fraction) * (score.share or 1.0)


def _are(titles: list[str], direction: str) -> str:
    *others, last = titles
    text = f"{', '.join(others).replace(',,', ',')} and {last} are" if others else f"{last} is"
    return f"{text[0].upper()}{text[1:]} {direction}."


def _subject(score: ScoreResult) -> str:
    """Return the subject of a sentence on a score; a title of a share names the counted things."""
    title = f"share of {score.title}" if score.unit == "%" else score.title
    return f"{title}," if ", " in title else title


def _direction(score: ScoreResult) -> str:
    return "too small" if score.low is not None and score.statistic < score.low else "too large"


def _missing(lost: Sequence[ScoreResult], runs: int) -> str:
    """Return sentences on the costliest score where runs have no number; "" = all have one."""
    missing = sum(map(math.isnan, lost[0].values))
    if not missing:
        return ""
    told = f"{missing} of {runs} runs have no {lost[0].title}, and count as the worst."
    for score in lost[1:]:
        if not any(map(math.isnan, score.values)):
            ends = dict.fromkeys(f"{end(score.values):.3g}" for end in (min, max))
            return f"{told} The {score.title} is {' to '.join(ends)} {score.unit}".rstrip() + "."
    return told


def _told(score: ScoreResult, runs: int) -> str:
    over = f"in the geometric mean of {runs} runs" if runs > 1 else "in the only run"
    if score.low is not None:
        return (
            f"The {score.title} is {_direction(score)}: {score.statistic:.3g} {over}. 1 is "
            f"right, and {score.low:.3g} to {score.limit:.3g} gives all points."
        )
    came_to = f"{score.statistic:.3g} times the reference {over}"
    if not score.share:
        came_to = f"the reference has {score.statistic:.3g} times as many right ones"
    return (
        f"The {score.title} is too large: {came_to}. Up to {score.limit:.3g} times gives all "
        f"points, {score.zero:.3g} times or more gives no points."
    )
