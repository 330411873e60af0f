"""What students are told of a test by a task, in a sentence or two."""

from __future__ import annotations

from collections.abc import Sequence

from robsim.teach.assignments.results import FailedRun, ScoreResult
from robsim.teach.errors import EXIT, TIMEOUT
from robsim.teach.texts import clean_line

_MOST_REASON = 300  # characters

#: How a run was ended, in words that tell nothing of it.
_HOW = {TIMEOUT: "took too long", EXIT: "ended its process"}


def of(
    failed: Sequence[FailedRun],
    scores: Sequence[ScoreResult],
    *,
    runs: int,
    public: bool,
    is_passed: bool,
) -> str:
    """Return what to say of a test: of one that is not public no number of its runs."""
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
        return f"No run came through. Run {first.run}: {reason}."
    return f"{len(failed)} of {runs} runs ended early. Run {first.run}: {reason}."


def _of_scores(
    scores: Sequence[ScoreResult], through: int, *, public: bool, is_passed: bool
) -> str:
    if all(score.fraction >= 1 for score in scores):
        if is_passed:
            return "All is as good as it must be."
        return "The others were as good as they must be."
    lost = [score for score in scores if score.fraction < 1]
    lost.sort(key=lambda score: (1 - score.fraction) * score.share, reverse=True)
    if public:
        return _told(lost[0], through)
    told: dict[str, list[str]] = {}
    for score in lost:
        told.setdefault(_direction(score), []).append(f"the {score.title}")
    return " ".join(_are(titles, direction) for direction, titles in told.items())


def _are(titles: list[str], direction: str) -> str:
    *others, last = titles
    text = f"{', '.join(others)} and {last} are" if others else f"{last} is"
    return f"{text[0].upper()}{text[1:]} {direction}."


def _direction(score: ScoreResult) -> str:
    return "too small" if score.low is not None and score.statistic < score.low else "too large"


def _told(score: ScoreResult, runs: int) -> str:
    over = f"in the geometric mean of {runs} runs" if runs > 1 else "in the only run"
    if score.low is not None:
        return (
            f"The {score.title} is {_direction(score)}: {score.statistic:.3g} {over}, where 1 is "
            f"right and {score.low:.3g} to {score.limit:.3g} has all points."
        )
    return (
        f"The {score.title} is too large: {score.statistic:.3g} times that of the reference "
        f"{over}, where up to {score.limit:.3g} times has all points and {score.zero:.3g} times "
        "none."
    )
