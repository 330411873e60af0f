"""What reports say of tests, scores and runs, in words."""

from __future__ import annotations

import math
import shlex

from robsim._base.report import percent
from robsim.assignments._reports.points import most_in_all, number, of_most, points_of
from robsim.assignments._results import (
    ERROR,
    FAILED,
    NOT_RUN,
    PARTIAL,
    PASSED,
    FailedRun,
    ScoreResult,
    SubmissionResult,
    TestResult,
)

#: What a status is called, and a sign for it, since not everybody sees its colour.
STATUS = {
    PASSED: ("passed", "✓"),
    PARTIAL: ("partly", "◐"),
    FAILED: ("failed", "✗"),
    ERROR: ("not graded", "!"),
    NOT_RUN: ("not run", "-"),
}

_WHOSE = {
    "submission": "",
    "assignment": "The assignment failed here, not your submission: tell your teacher.",
    "grader": "The grader failed here, not your submission: tell your teacher.",
}

HINT = (
    "A hint, and no proof: short programs for the same exercise resemble each other. Names, "
    "numbers, comments and spaces are not compared; what was given to all, or stands in many "
    "programs, does not count. Read both before you talk to anybody."
)


def heading(test: TestResult) -> str:
    """Return number and title of a test."""
    return f"{test.number} {test.title}" if test.number else test.title


def blame(test: TestResult) -> str:
    """Return what is to be said where it was not the submission that failed."""
    if test.status != ERROR:
        return ""
    return _WHOSE.get(test.whose or "grader", "")


def result_text(test: TestResult) -> str:
    """Return the points of a test, where there are any."""
    return "no points" if test.status == ERROR else of_most(points_of(test), test.most)


def score_text(score: ScoreResult) -> str:
    """Return what a score came to, up to where it has all points, and from where on none."""
    return f"{_came_to(score)} ({_limits(score)})"


def points_text(score: ScoreResult, most: float) -> str:
    """Return what a score gives of the points of its test."""
    full = most * score.share
    return f"{percent(score.fraction, 0)} of {number(full)} {'point' if full == 1 else 'points'}"


def _came_to(score: ScoreResult) -> str:
    if math.isnan(score.statistic):
        return "no run came through"
    if score.low is not None:
        return f"{_ratio(score.statistic)}, where 1 is right"
    return f"{_ratio(score.statistic)} times that of the reference"


def _limits(score: ScoreResult) -> str:
    if score.low is None or score.low_zero is None:
        return f"all points up to {_ratio(score.limit)}, none from {_ratio(score.zero)} on"
    return (
        f"all points from {_ratio(score.low)} to {_ratio(score.limit)}, none below "
        f"{_ratio(score.low_zero)} and above {_ratio(score.zero)}"
    )


def _ratio(value: float) -> str:
    return f"{value:.3g}" if value < 1000 else f"{value:.0f}"


def failed_text(run: FailedRun) -> str:
    """Return which run failed, where, and what came."""
    place = [] if run.slot is None else [run.slot]
    place += [] if run.step is None else [f"at step {run.step}"]
    file = "" if run.file is None else run.file
    file += "" if run.file is None or run.line is None else f", line {run.line}"
    where = " ".join(place) + (f" ({file})" if file else "")
    start = f"run {run.run}, {where}" if where else f"run {run.run}"
    return f"{start}: {run.reason}" if run.reason else start


def failed_head(test: TestResult) -> str:
    """Return how many runs failed, and what that costs."""
    return f"{len(test.failed)} of {test.runs} runs did not come through; each takes its part"


def repeat_command(result: SubmissionResult, test: TestResult) -> str:
    """Return the command with which a student repeats a public test."""
    names = map(shlex.quote, (result.assignment, test.name))
    return "robsim grade {} mine/ --public --only {}".format(*names)


def play_command(result: SubmissionResult, test: TestResult) -> str:
    """Return the command with which a teacher does a run of a test again."""
    names = map(shlex.quote, (result.assignment, f"submissions/{result.student}", test.name))
    run = "" if test.worst is None else f" --run {test.worst}"
    return "robsim grade {} {} --play {}".format(*names) + run


def isolation_text(result: SubmissionResult) -> str:
    """Return what has shut a submission in."""
    return result.isolation.removeprefix("isolation: ")


def not_graded(result: SubmissionResult) -> str:
    """Return what is to be said of points that nobody could win or lose; "" = there are none."""
    points = sum(test.most for test in result.tests if test.status == ERROR)
    if not points:
        return ""
    share = f"{number(points)} of these {number(most_in_all(result))} points"
    return f"{share} could not be graded, by no fault of the submission."


def versions_text(result: SubmissionResult) -> str:
    """Return the versions of what graded."""
    return ", ".join(f"{name} {version}" for name, version in result.versions.items())
