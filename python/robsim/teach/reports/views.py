"""What is left out of results: for students, and where nobody's name is to be seen."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace

from robsim.teach.assignments.results import ERROR, SubmissionResult, TestResult


def for_student(result: SubmissionResult) -> SubmissionResult:
    """Return what students may see: of hidden tests nothing but title, points and sentence.

    What has shut the submission in is of use to the teacher alone.
    """
    tests = tuple(t if t.public else _hidden(t) for t in result.tests)
    return result.replace(tests=tests, isolation="")


def _hidden(test: TestResult) -> TestResult:
    return TestResult(
        name=test.name,
        title=test.title,
        number=test.number,
        public=False,
        points=test.points,
        most=test.most,
        status=test.status,
        sentence=test.sentence,
        whose=test.whose if test.status == ERROR else None,
    )


def pseudonymous(
    results: Iterable[SubmissionResult], pseudonym: Callable[[str], str]
) -> list[SubmissionResult]:
    """Return results by pseudonyms, without any text or file in which a name may stand.

    Parameters
    ----------
    results : iterable of SubmissionResult
        The results.
    pseudonym : callable
        What gives a name for a student, such as ``key.pseudonym``.
    """
    return [
        result.replace(
            student=pseudonym(result.student),
            tests=tuple(map(_without_texts, result.tests)),
            notes=(),
            submission_digest="",
        )
        for result in results
    ]


def _without_texts(test: TestResult) -> TestResult:
    return replace(
        test,
        failed=tuple(replace(run, reason="", file=None, line=None) for run in test.failed),
        picture=None,
        sentence="",
        caption="",
        finding="",
        output="",
    )
