"""The words of reports on tests, scores and runs."""

from __future__ import annotations

import math
import os
import re
import shlex
import statistics
from collections.abc import Iterator, Sequence
from pathlib import Path

from robsim.base.report import percent
from robsim.teach.reports.similarity import Comparison
from robsim.teach.results import (
    ERROR,
    FAILED,
    NOT_RUN,
    PARTIAL,
    PASSED,
    FailedRun,
    ScoreResult,
    SubmissionResult,
    TestResult,
    number,
    of_most,
)

#: The name of a status, and a sign for readers who do not see its colour.
STATUS = {
    PASSED: ("passed", "✓"),
    PARTIAL: ("partly", "◐"),
    FAILED: ("failed", "✗"),
    ERROR: ("not graded", "!"),
    NOT_RUN: ("not run", "-"),
}


def status(test: TestResult) -> tuple[str, str]:
    """Return the word for the status of a test, and its sign."""
    if test.by_hand:
        return ("not given yet", "-") if test.status == NOT_RUN else ("by hand", "✎")
    return STATUS[test.status]


#: The names of platforms' downloads. After `student` comes the student's own name for the
#: file, which may look like another student's: the first match counts.
OF_MOODLE, OF_CANVAS, OF_BLACKBOARD = (
    re.compile(pattern, re.DOTALL)
    for pattern in (
        r"(?P<student>(?P<name>.+?)_(?P<number>\d+)_assignsubmission_(file|onlinetext))"
        r"(_(?P<file>.+)?)?",
        r"(?P<student>(?P<name>[^_]+)_(LATE_)?(?P<number>\d+))"
        r"(_\d+_(?P<file>.+?)(-\d+)?(?P<ending>\.\w+))?",
        r".+?_(?P<student>[^_]+)_attempt_(?P<attempt>\d{4}(-\d\d){5})(_(?P<file>.+))?",
    )
)

FINDING = "Finding of robsim check"
OUTPUT = "The submission printed"
REPEAT = "Command to repeat it, in the folder of the assignment"

PROVISIONAL = "The limits are provisional: points may change when the exact ones are known."

HINT = (
    "A hint, not a proof: short programs for the same exercise resemble each other. Names, "
    "numbers, comments, spaces and the order of functions are not compared, and given text does "
    "not count. Read both programs before you talk to a student."
)


def left_out(found: Comparison) -> str:
    mostly = ", ".join(map(person, found.mostly_common)) or "no student"
    lines = f"{found.common_lines} lines were left out of pairs, because many have them"
    return f"{lines}. Most of the program is such text for {mostly}."


def alike(names: Sequence[str]) -> str:
    """Return the names of a group; of several solutions only the first, with their number."""
    solutions = [name for name in names if "solution " in name and "/" in name]
    shown = [person(name) for name in names if name not in solutions[1:]]
    more = len(solutions) - 1
    return ", ".join(shown) + (f" and {more} more solution{'s' * (more > 1)}" if more > 0 else "")


def person(student: str) -> str:
    match = OF_MOODLE.fullmatch(student)
    return match["name"] if match else student


def who(result: SubmissionResult) -> str:
    """Return the name of a student, or of a group with its members."""
    members = ", ".join(map(person, result.members))
    return person(result.student) + (f" ({members})" if members else "")


def test_title(test: TestResult) -> str:
    """Return number and title of a test."""
    title = test.title[:1].upper() + test.title[1:]
    return f"{test.number} {title}" if test.number else title


def notes(result: SubmissionResult) -> list[str]:
    """Return the notes on the submission as a whole."""
    start = "The submission is unreadable, so nothing of it ran. " if result.is_unread else ""
    own = (f"{start}{note}" for note in result.notes)
    return [*by_hand(result), *own, *provisional(result)]


def provisional(result: SubmissionResult) -> list[str]:
    return [PROVISIONAL] if any(test.provisional for test in result.tests) else []


def by_hand(result: SubmissionResult) -> list[str]:
    """Return the reasons why the points differ from the tests' points, one sentence each."""
    hand, told = result.by_hand, []
    if hand.points is not None:
        of_tests = number(result.points_of_tests)
        told.append(f"By hand: {number(hand.points)} points instead of {of_tests} of the tests.")
    if hand.late_days:
        days = f"{number(hand.late_days)} day{'' if hand.late_days == 1 else 's'} late"
        told.append(f"{days}: {percent(1 - hand.kept, 0)} of the points are lost.")
    return [*told, f"Comment: {hand.comment}"] if hand.comment else told


def sentence(result: SubmissionResult, test: TestResult) -> str:
    """Return the sentence on a test, unless `notes` has it for all tests."""
    return "" if result.is_unread else test.sentence


def waiting(result: SubmissionResult) -> list[TestResult]:
    """Return the tests that have not run yet."""
    tests = (test for test in result.tests if not test.by_hand)
    return [test for test in tests if test.status == NOT_RUN]


def blame(test: TestResult) -> str:
    """Return a sentence if the submission did not cause a failure."""
    if test.status != ERROR or (whose := test.whose or "grader") == "submission":
        return ""
    return f"The {whose} failed here, not your submission: tell your teacher."


def result_text(test: TestResult) -> str:
    return "no points" if test.status == ERROR else of_most(test.points, test.most)


def score_text(score: ScoreResult) -> str:
    return f"{_came_to(score)} ({_limits(score)})"


def score_line(score: ScoreResult, most: float) -> str:
    line = f"{score.title}: {score_text(score)}: {points_text(score, most)}"
    return f"{line}. {needed(score)}".removesuffix(". ")


def needed(score: ScoreResult) -> str:
    """Return the condition for all points; "" = met, or all runs failed."""
    if not (math.isfinite(score.statistic) and score.statistic > 0):
        return ""
    if score.is_met:
        met = "It is within its limits: the score that multiplies it loses the points."
        return met if score.fraction < 1 else ""
    if score.low is not None and score.statistic < score.low:
        return f"All points need {_ratio(score.low / score.statistic)} times as much."
    if all(map(math.isnan, score.values)):
        return "All points need runs with a value."
    part = score.limit / score.statistic
    own = _typical(score.values)
    if not score.share:
        right = _right(statistics.fmean(score.values)) if score.values else math.nan
        if not 0 < right <= 1:
            return ""
        return f"All points need {percent(right / part)} right ones, instead of {percent(right)}."
    less = f"All points need {percent(1 - part, 0)} less"
    reference = score.statistic * _typical(score.reference)
    if not score.unit or score.low is not None or not math.isclose(own, reference, rel_tol=1e-3):
        return f"{less}."
    means = f"{own * part:.3g} {score.unit}, instead of {own:.3g} {score.unit}"
    return f"{less}: {means} in the geometric mean of the runs."


def _typical(values: Sequence[float]) -> float:
    """Return the geometric mean; NaN if a value has no logarithm."""
    is_known = values and all(0 < value < math.inf for value in values)
    return statistics.geometric_mean(values) if is_known else math.nan


def _right(lost: float) -> float:
    """Return the share of right ones from the percentage of lost ones."""
    return max(1 - lost / 100, 1e-3)


_NO_VALUE = "no value"


def worst_of(score: ScoreResult, runs: Sequence[tuple[float, int, str]]) -> str:
    """Return a sentence on the worst of several runs in a score; "" = there is only one."""
    if without := sum(map(math.isnan, score.values)):
        return f"{without} of {len(score.values)} runs have no value, and count as the worst."
    return f"Run {runs[-1][1]} is the worst in this score, with {runs[-1][2]}." if runs[1:] else ""


def runs_of(score: ScoreResult, test: TestResult) -> list[tuple[float, int, str]]:
    """Return the completed runs: place on the axis of the statistic, number, value.

    The worst run is the last.
    """
    failed = {run.run for run in test.failed}
    through = [run for run in range(test.runs) if run not in failed]
    runs = []
    for run, value, reference in zip(through, score.values, score.reference, strict=False):
        place, said = value, f"{value:.3g} {score.unit}".rstrip()
        if not math.isfinite(value):
            place, said = math.inf, _NO_VALUE
        elif not score.share:
            place = _right(reference) / _right(value)
        elif score.low is None:
            place = value / reference if reference else math.nan
            said += f", {_ratio(place)} times the reference"
        if not math.isnan(place):
            runs.append((place, run, said))
    return sorted(runs, key=lambda run: _excess(score, run[0]))


def _excess(score: ScoreResult, statistic: float) -> float:
    """Return a statistic relative to the limit of all points: above 1 it loses points."""
    too_small = 0.0
    if score.low is not None:
        too_small = score.low / statistic if statistic > 0 else math.inf
    return max(statistic / score.limit, too_small)


_NEAR = 1.1
JUST_BELOW = (
    f"Just below the limit (≈): a test loses points, no score is more than {percent(_NEAR - 1, 0)} "
    "beyond its limit, and no run failed."
)


def is_near(test: TestResult) -> bool:
    """Return whether a test is just below the limit of all points."""
    lost = [_excess(score, score.statistic) for score in test.scores if not score.is_met]
    return bool(lost) and not test.failed and all(excess <= _NEAR for excess in lost)


def points_text(score: ScoreResult, most: float) -> str:
    if not score.share:
        return f"multiplies the others by {percent(score.fraction, 0)}"
    full = most * score.share
    return f"{percent(score.fraction, 0)} of {number(full)} {'point' if full == 1 else 'points'}"


def _came_to(score: ScoreResult) -> str:
    if math.isnan(score.statistic):
        return "all runs failed"
    if score.low is not None:
        return f"{_ratio(score.statistic)}, where 1 is right"
    if not score.share:
        return f"the reference has {_ratio(score.statistic)} times as many right ones"
    return f"{_ratio(score.statistic)} times the reference"


def _limits(score: ScoreResult) -> str:
    if score.low is None or score.low_zero is None:
        return f"all points up to {_ratio(score.limit)}, no points from {_ratio(score.zero)} on"
    return (
        f"all points from {_ratio(score.low)} to {_ratio(score.limit)}, no points below "
        f"{_ratio(score.low_zero)} and above {_ratio(score.zero)}"
    )


def _ratio(value: float) -> str:
    return f"{value:.3g}" if value < 1000 else f"{value:.0f}"


def failed_texts(test: TestResult) -> list[str]:
    alike: dict[str, list[int]] = {}
    for run in test.failed:
        alike.setdefault(_reason(run), []).append(run.run)
    return [
        f"run{'' if len(numbers) == 1 else 's'} {', '.join(map(str, numbers))}: {reason}"
        for reason, numbers in alike.items()
    ]


def _reason(run: FailedRun) -> str:
    """Return the reason, with its place unless the reason has it already."""
    file = run.file
    if file is not None and run.line is not None:
        file = f"{file}, line {run.line}"
    slot = run.slot
    if slot is not None and run.step is not None:
        step = f"at step {run.step}"
        slot = "" if slot in run.reason and step in run.reason else f"{slot} {step}"
    parts = [part for part in (slot, file) if part and part not in run.reason]
    return ": ".join(filter(None, (", ".join(parts), run.reason))) or "it failed"


def caption_text(test: TestResult) -> str:
    if test.picture is None and test.failed:
        if test.worst is None:
            return "No picture: no run began."
        return f"No picture: run {test.worst} failed in its first step."
    if test.worst is None:
        return test.caption
    which = "the worst"
    for score in sorted(test.scores, key=lambda one: one.share):
        for _, worst, said in runs_of(score, test)[-1:]:
            if worst == test.worst and said != _NO_VALUE and not score.is_met:
                which = f"the worst in {score.title}"
    if test.worst in {run.run for run in test.failed}:
        which = "until it failed"
    return f"Run {test.worst}, {which}. {test.caption}".rstrip()


def has_numbers(test: TestResult) -> bool:
    return any(not math.isnan(score.statistic) for score in test.scores)


def boxes(test: TestResult) -> Iterator[tuple[str, str | list[str]]]:
    """Yield help for finding a mistake: a heading, and a text or a list below it."""
    if test.finding:
        yield FINDING, test.finding
    if test.failed:
        failed = f"{len(test.failed)} of {test.runs} runs failed"
        yield f"{failed}: each loses its part of the points", failed_texts(test)
    if output := test.output.rstrip():
        yield OUTPUT, output


def repeat_command(test: TestResult) -> str:
    return f"robsim grade . mine --public --only {shlex.quote(test.name)}"


def play_command(result: SubmissionResult, test: TestResult) -> str:
    command = result.command or f"robsim grade {shlex.quote(result.assignment)} SUBMISSION"
    run = "" if test.worst is None else f" --run {test.worst}"
    return f"{command} --play {shlex.quote(test.name)}{run}"


def grade_command(assignment: Path, submission: str, out: Path, student: str) -> str:
    """Return the command that grades a submission, with paths from here, or absolute ones."""
    here, places = Path.cwd(), [Path(os.path.abspath(one)) for one in (assignment, submission, out)]
    given, handed, folder = (
        str(place.relative_to(here) if place.is_relative_to(here) else place) for place in places
    )
    return shlex.join(["robsim", "grade", given, handed, "--student", student, "--out", folder])


def isolation_text(result: SubmissionResult) -> str:
    return result.isolation.removeprefix("isolation: ")


def not_graded(result: SubmissionResult) -> str:
    """Return a sentence on points that no student could win or lose; "" = no such points."""
    points = sum(test.most for test in result.tests if test.status == ERROR)
    if not points:
        return ""
    share = f"{number(points)} of these {number(result.most)} points"
    return f"Grading failed for {share}, without a fault of the submission."


def versions_text(result: SubmissionResult) -> str:
    return ", ".join(f"{name} {version}" for name, version in result.versions.items())


def facts(result: SubmissionResult) -> dict[str, str]:
    return {
        "Isolation": isolation_text(result),
        "Graded with": versions_text(result),
        "Handed in": _digest(result.submission_digest),
        "Assignment": f"{result.assignment} {_digest(result.assignment_digest)}".strip(),
        "Took": f"{result.seconds:.1f} s" if result.seconds else "",
    }


def _digest(digest: str) -> str:
    return f"SHA-256 {digest[:16]}" if digest else ""
