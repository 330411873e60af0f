"""Results as JUnit's XML, which servers for continuous integration show."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from xml.etree import ElementTree

from robsim.assignments._points import number
from robsim.assignments._reports import words
from robsim.assignments._results import (
    ERROR,
    NOT_RUN,
    PASSED,
    SubmissionResult,
    TestResult,
)
from robsim.grading._texts import clean_text

# What XML 1.0 cannot have, not even escaped.
_FORBIDDEN = re.compile("[^\t\n\r\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
_KINDS = {ERROR: "error", NOT_RUN: "skipped", PASSED: None}
_MOST_TEXT = 20_000  # characters


def junit_xml(results: Sequence[SubmissionResult]) -> bytes:
    """Return results as JUnit's XML: a suite for each submission, with its tests.

    A test without all points has failed. Its message says the points; a suite has them as
    properties.
    """
    suites = [_suite(result) for result in results]
    root = ElementTree.Element("testsuites", _counts(test for r in results for test in r.tests))
    root.set("name", _text(results[0].title) if results else "")
    root.set("time", f"{sum(result.seconds for result in results):.3f}")
    root.extend(suites)
    ElementTree.indent(root)
    content: bytes = ElementTree.tostring(root, encoding="utf-8", xml_declaration=True)
    return content + b"\n"


def _suite(result: SubmissionResult) -> ElementTree.Element:
    suite = ElementTree.Element("testsuite", _counts(result.tests))
    suite.set("name", _text(result.student))
    suite.set("skipped", str(sum(test.status == NOT_RUN for test in result.tests)))
    suite.set("time", f"{result.seconds:.3f}")
    properties = ElementTree.SubElement(suite, "properties")
    facts = {
        "points": number(result.points),
        "most": number(result.most),
        "isolation": words.isolation_text(result),
    }
    for name, value in facts.items():
        ElementTree.SubElement(properties, "property", name=name, value=_text(value))
    suite.extend(_case(result, test) for test in result.tests)
    return suite


def _counts(tests: Iterable[TestResult]) -> dict[str, str]:
    kinds = [_KINDS.get(test.status, "failure") for test in tests]
    return {
        "tests": str(len(kinds)),
        "failures": str(kinds.count("failure")),
        "errors": str(kinds.count("error")),
    }


def _case(result: SubmissionResult, test: TestResult) -> ElementTree.Element:
    case = ElementTree.Element(
        "testcase",
        name=_text(words.heading(test)),
        classname=_text(f"{result.assignment}.{result.student}"),
        time=f"{test.seconds:.3f}",
    )
    kind = _KINDS.get(test.status, "failure")
    if kind is not None:
        message = ": ".join(filter(None, (words.result_text(test), test.sentence)))
        found = ElementTree.SubElement(case, kind, message=_text(message), type=_text(test.status))
        found.text = _text(_details(test))
    if test.output:
        ElementTree.SubElement(case, "system-out").text = _text(test.output)
    return case


def _details(test: TestResult) -> str:
    lines = [words.blame(test)]
    if words.has_numbers(test):
        lines += [f"{score.title}: {words.score_text(score)}" for score in test.scores]
    lines += [words.caption_text(test), test.finding, *words.failed_texts(test)]
    return "\n".join(filter(None, lines))


def _text(text: str) -> str:
    return _FORBIDDEN.sub("\N{REPLACEMENT CHARACTER}", clean_text(text, _MOST_TEXT))
