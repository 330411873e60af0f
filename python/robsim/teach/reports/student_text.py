"""A student's page as lines of text, and the students' part of a result."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from typing import Any

from robsim.teach.reports import words
from robsim.teach.results import ERROR, SubmissionResult, TestResult, of_most
from robsim.teach.texts import clean_line, clean_text

_WIDTH = 88
_MOST_LINES, _LONGEST = 20, 200  # of the printed output


def student_text(result: SubmissionResult) -> str:
    """Return the whole result as text. For students, pass `for_student` of it."""
    points = of_most(result.points, result.most)
    lines = [clean_line(result.title), f"{clean_line(words.who(result))}: {points}"]
    if not result.is_done:
        lines.append("Not all tests have been run yet.")
    lines += _wrapped(words.not_graded(result), "", "")
    for note in words.notes(result):
        lines += _wrapped(note, "Note: ", "      ")
    for test in result.tests:
        lines += ["", *_test(result, test)]
    isolation = words.isolation_text(result)
    lines += ["", *_wrapped(f"Isolation: {isolation}" if isolation else "", "", "  ")]
    lines += _wrapped(f"Graded with {words.versions_text(result)}", "", "  ")
    return "\n".join(lines) + "\n"


def _test(result: SubmissionResult, test: TestResult) -> Iterator[str]:
    word, sign = words.status(test)
    points = words.result_text(test)
    kind = "" if test.public else ", hidden"
    yield clean_line(f"{sign} {words.test_title(test)}: {word}, {points}{kind}")
    for text in (words.sentence(result, test), words.blame(test)):
        yield from _wrapped(text, "  ", "  ")
    for score in test.scores if words.has_numbers(test) else ():
        yield from _wrapped(words.score_line(score, test.most), "  - ", "    ")
    yield from _wrapped(words.caption_text(test), "  ", "  ")
    for head, body in words.boxes(test):
        yield f"  {head}:"
        for text in body if isinstance(body, list) else ():
            yield from _wrapped(text, "  - ", "    ")
        if isinstance(body, str):
            text = clean_text(_cut(body) if head == words.OUTPUT else body)
            yield from (f"  | {line}".rstrip() for line in text.split("\n"))
    if test.public and not test.by_hand:
        yield f"  {words.REPEAT}:"
        yield clean_line(f"    {words.repeat_command(test)}")


def _cut(text: str) -> str:
    lines = text.split("\n")
    left = len(lines) - _MOST_LINES
    cut = [line if len(line) <= _LONGEST else f"{line[:_LONGEST]} ..." for line in lines]
    more = [f"... and {left} lines more"] if left > 0 else []
    return "\n".join(cut[:_MOST_LINES] + more)


def _wrapped(text: str, start: str, indent: str) -> list[str]:
    indents: dict[str, Any] = {"initial_indent": start, "subsequent_indent": indent}
    return textwrap.wrap(clean_text(text), _WIDTH, **indents, break_on_hyphens=False)


def for_student(result: SubmissionResult) -> SubmissionResult:
    """Return the students' part of a result: of hidden tests only title, points and sentence.

    Isolation and command of the grading are useful only for the teacher.
    """
    tests = tuple(t if t.public else _hidden(t) for t in result.tests)
    return replace(result, tests=tests, isolation="", command="")


#: The attributes of a hidden test that students see.
_THEIRS = ("name", "title", "number", "points", "most", "provisional", "status", "sentence")


def _hidden(test: TestResult) -> TestResult:
    whose = test.whose if test.status == ERROR else None
    theirs = {name: getattr(test, name) for name in _THEIRS}
    return TestResult(**theirs, public=False, whose=whose)


def pseudonymous(
    results: Iterable[SubmissionResult], pseudonym: Callable[[str], str]
) -> list[SubmissionResult]:
    """Return results by pseudonyms, without any text or file that may contain a name."""
    return [
        replace(
            result,
            student=pseudonym(result.student),
            members=tuple(map(pseudonym, result.members)),
            tests=tuple(map(_without_texts, result.tests)),
            notes=(),
            submission_digest="",
            by_hand=replace(result.by_hand, comment=""),
            command="",
        )
        for result in results
    ]


def _without_texts(test: TestResult) -> TestResult:
    failed = tuple(replace(run, reason="", file=None, line=None) for run in test.failed)
    texts: dict[str, Any] = dict.fromkeys(("sentence", "caption", "finding", "output"), "")
    return replace(test, failed=failed, picture=None, **texts)
