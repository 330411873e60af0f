"""Results for Gradescope: its ``results.json``, by its specification."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from os import PathLike
from typing import Any

from robsim.base.checks import check_choice
from robsim.base.files import as_path, write_whole
from robsim.teach.reports import words
from robsim.teach.reports.pages import data_uri, rendered
from robsim.teach.reports.student_text import for_student
from robsim.teach.results import ERROR, NOT_RUN, PASSED, SubmissionResult, TestResult, of_most
from robsim.teach.texts import clean_line, clean_text

#: When Gradescope can show hidden tests. A test that is never shown would hide the total forever.
VISIBILITIES = ("after_published", "after_due_date", "visible")
#: Maximum size of a picture, and of all of them, in the file (bytes).
MOST_PICTURE, MOST_PICTURES = 200 * 2**10, 2 * 2**20


def gradescope(
    result: SubmissionResult,
    *,
    pictures: Mapping[str, bytes] | None = None,
    hidden: str = "after_published",
    leaderboard: str = "",
) -> dict[str, Any]:
    """Return a result as the content of Gradescope's ``results.json``.

    Pictures are PNG files by test; small ones of public tests are shown. `hidden`, one of
    `VISIBILITIES`, is when points and sentences of hidden tests are shown. Until then Gradescope
    shows no total. `leaderboard`, see `Assignment`, names a score of a public test. If no run
    failed, all students see the score, relative to the reference. Source:
    https://gradescope-autograders.readthedocs.io/en/latest/specs/
    """
    check_choice("hidden", hidden, VISIBILITIES)
    theirs = for_student(result)
    shown = _shown(theirs, pictures or {})
    tests = [_test(test, shown.get(test.name), hidden) for test in theirs.tests]
    if said := words.by_hand(theirs):  # which reveals the points of hidden tests
        when = "visible" if all(test.public for test in theirs.tests) else hidden
        text = {"output": clean_text("\n".join(said)), "output_format": "text"}
        tests.append({"name": "By hand", **text, "visibility": when})
    ranked = [*_leaderboard(result, leaderboard)]
    return {
        "score": theirs.points,
        "execution_time": round(theirs.seconds, 3),
        "output": _output(theirs),
        # Gradescope's default is HTML.
        "output_format": "text",
        "test_output_format": "html",
        "test_name_format": "text",
        "visibility": "visible",
        "stdout_visibility": "hidden",
        "extra_data": {
            "robsim": dict(theirs.versions),
            "assignment": theirs.assignment,
            "isolation": clean_line(words.isolation_text(result), 1000),
            "submission_digest": theirs.submission_digest,
            "assignment_digest": theirs.assignment_digest,
        },
        "tests": tests,
        **({"leaderboard": ranked} if ranked else {}),
    }


def _leaderboard(result: SubmissionResult, wanted: str) -> Iterator[dict[str, Any]]:
    for test in result.tests:
        for score in test.scores if test.public and not test.failed else ():
            value = score.statistic
            if score.low is not None and 0 < value < 1:  # there 1 is right, not 0
                value = 1 / value
            if f"{test.name}.{score.name}" == wanted and math.isfinite(value):
                name = f"{clean_line(score.title)}, relative to the reference"
                yield {"name": name, "value": value, "order": "asc"}


def write_gradescope(
    path: str | PathLike[str],
    result: SubmissionResult,
    *,
    pictures: Mapping[str, bytes] | None = None,
    hidden: str = "after_published",
    leaderboard: str = "",
) -> None:
    """Write `gradescope` to a file atomically; raise OSError if writing fails."""
    content = gradescope(result, pictures=pictures, hidden=hidden, leaderboard=leaderboard)
    text = json.dumps(content, indent=1, allow_nan=False)
    write_whole(as_path(path), f"{text}\n".encode("ascii"))


def _shown(result: SubmissionResult, pictures: Mapping[str, bytes]) -> dict[str, str]:
    """Return the addresses of the pictures that fit, by test."""
    shown: dict[str, str] = {}
    left = MOST_PICTURES
    for test in result.tests:
        if test.picture is not None and test.name in pictures:
            address = data_uri(pictures[test.name])
            if len(address) <= min(MOST_PICTURE, left):
                shown[test.name] = address
                left -= len(address)
    return shown


def _output(result: SubmissionResult) -> str:
    tests = [test for test in result.tests if not test.by_hand]
    public = [test for test in tests if test.public]
    shown = replace(result, tests=tuple(public))
    points = of_most(shown.points_of_tests, shown.most)
    lines = [f"Public tests: {points}."] if public else []
    if sum(test.most for test in tests) > shown.most:
        lines.append("There are hidden tests, too.")
    if not result.is_done:
        lines.append("Not all tests have been run.")
    lines += map(clean_text, dict.fromkeys(test.sentence for test in words.waiting(result)))
    lines += map(clean_text, [*result.notes, *words.provisional(result)])
    if isolation := words.isolation_text(result):
        lines.append(f"Isolation: {clean_line(isolation, 1000)}")
    return "\n".join(lines)


def _test(test: TestResult, picture: str | None, hidden: str) -> dict[str, Any]:
    status = f"{words.status(test)[0]}: {words.result_text(test)}"
    texts = (status, test.sentence, words.blame(test))
    content: dict[str, Any] = {
        "name": clean_line(test.title),
        "name_format": "text",
        "output": rendered("gradescope.html", test=test, texts=texts, picture=picture),
        "output_format": "html",
        "visibility": "visible" if test.public else hidden,
        "tags": ["public" if test.public else "hidden"],
        "extra_data": {"test": test.name, "result": test.status},
    }
    if test.number:
        content["number"] = clean_line(test.number)
    if test.status not in (ERROR, NOT_RUN):  # no points to win or lose
        content |= {"status": "passed" if test.status == PASSED else "failed"}
        content |= {"score": test.points, "max_score": float(test.most)}
    return content
