"""The process that runs a file of a teacher's tests.

``python -m robsim.teach.assignments._own_tests.child`` reads its job from a line of JSON: the
folder of the assignment, the number of the file, the submission, the student, the file for the
results.
"""

from __future__ import annotations

import json
import math
import os
import sys
from collections.abc import Generator
from dataclasses import asdict
from typing import Any, TextIO

import pytest

from robsim.teach.assignments._own_tests.listing import OwnTest
from robsim.teach.assignments.assignment import RULES
from robsim.teach.assignments.assignment_file import load_assignment
from robsim.teach.assignments.marking.references import key_for, student_for
from robsim.teach.errors import AssignmentError, SubmissionError
from robsim.teach.grading.keys import Key
from robsim.teach.grading.pytest_plugin import Grading, printed_in
from robsim.teach.results import ERROR, FAILED, NOT_RUN, PASSED
from robsim.teach.texts import clean_text

_MARKER = (
    "points(number, success='', failure=''): the points of a test, and sentences for the student"
)
_MOST = 1000  # characters of an error
_EXPECTED = "points needs a number, such as @pytest.mark.points(2)"


class Points:
    """A run of pytest in which tests have points.

    The plugin writes a line of JSON for each test that it finds, and for each finished test.
    Without a key it only lists the tests. The marker ``robsim_submission`` of a test changes the
    options, which `robsim.teach.Submission` documents.
    """

    def __init__(
        self, out: TextIO, *, public: bool, key: Key | None, options: dict[str, Any]
    ) -> None:
        self._out, self._public = out, public
        self._key, self._options = key, options
        self._tests: dict[str, OwnTest] = {}

    def pytest_configure(self, config: pytest.Config) -> None:
        """Register the marker; pass the rules of all tests to the grader."""
        config.addinivalue_line("markers", _MARKER)
        for plugin in config.pluginmanager.get_plugins():
            if isinstance(plugin, Grading):
                plugin.grade_by(self._key, self._options)

    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        self._tests = {item.nodeid: _own_test(item, self._public) for item in items}
        for test in self._tests.values():
            self._say("test", asdict(test))

    def pytest_collectreport(self, report: pytest.CollectReport) -> None:
        if report.failed:
            self._say("broken", {"text": clean_text(report.longreprtext.strip()[-_MOST:])})

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_makereport(
        self, item: pytest.Item, call: pytest.CallInfo[None]
    ) -> Generator[None, pytest.TestReport, pytest.TestReport]:
        report = yield
        test = self._tests[item.nodeid]
        error = None if call.excinfo is None else call.excinfo.value
        if report.when == "call" or (report.when == "setup" and not report.passed):
            output = clean_text(printed_in(item, error))
            self._say("result", {"output": output, **_told(test, report, error)})
        elif report.failed:  # in the teardown
            self._say("result", {"name": test.name, **_failed_by_others(test, error)})
        return report

    def _say(self, kind: str, data: dict[str, Any]) -> None:
        print(json.dumps({"kind": kind, **data}), file=self._out, flush=True)


def _own_test(item: pytest.Item, public: bool) -> OwnTest:
    marker = item.get_closest_marker("points")
    given = {} if marker is None else marker.kwargs
    args = (0,) if marker is None else marker.args
    if len(args) != 1 or not _is_count(args[0]):
        raise pytest.UsageError(f"{item.name}: {_EXPECTED}")
    if wrong := [name for name in given if name not in ("success", "failure")]:
        raise pytest.UsageError(f"{item.name}: points has no option {wrong[0]!r}: {_MARKER}")
    doc = getattr(getattr(item, "function", None), "__doc__", None) or ""
    lines = doc.strip().splitlines() or [item.name.removeprefix("test_").replace("_", " ")]
    return OwnTest(
        name=item.name,
        title=clean_text(lines[0].strip().rstrip("."), 200),
        points=float(args[0]),
        public=public,
        success=str(given.get("success", "")),
        failure=str(given.get("failure", "")),
    )


def _is_count(value: object) -> bool:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return False
    return math.isfinite(value) and value >= 0


def _told(test: OwnTest, report: pytest.TestReport, error: BaseException | None) -> dict[str, Any]:
    told: dict[str, Any] = {"name": test.name, "seconds": report.duration}
    if report.passed:
        return told | {"status": PASSED, "sentence": test.success, "points": test.points}
    if report.skipped:
        return told | {"status": NOT_RUN, "sentence": "It was skipped."}
    # Whether the submission or the test has failed.
    if isinstance(error, (AssertionError, SubmissionError, pytest.fail.Exception)):
        return told | {"status": FAILED, "sentence": _sentence(test, error), "whose": "submission"}
    return told | _failed_by_others(test, error)


def _failed_by_others(test: OwnTest, error: BaseException | None) -> dict[str, Any]:
    whose = getattr(error, "whose", AssignmentError.whose)
    said = f"{type(error).__name__}: {error}"
    return {"status": ERROR, "sentence": clean_text(f"{test.name}: {said}", 400), "whose": whose}


def _sentence(test: OwnTest, error: BaseException | None) -> str:
    said = test.failure or "It has failed."
    if not test.public:  # a test's or an error's message may reveal the test
        return said
    if isinstance(error, SubmissionError):
        said = str(error).rstrip(".")
        return clean_text(f"{test.failure} It failed: {said}." if test.failure else said, 400)
    return test.failure or clean_text(str(error).partition("\nassert ")[0].strip() or said, 400)


def main() -> int:
    request: dict[str, Any] = json.loads(sys.stdin.readline())
    assignment = load_assignment(request["folder"], isolation=request["isolation"])
    test = assignment.files[request["file"]]
    path = request["submission"]
    arguments = [f"--rootdir={assignment.folder}", "-c", os.devnull, "-p", "no:cacheprovider"]
    arguments += ["-q", "--strict-markers", "--no-header", "--disable-warnings"]
    options: dict[str, Any] = {}
    key = None
    if path is None:
        arguments.append("--collect-only")
    else:
        arguments += [f"--robsim-submission={path}", f"--robsim-isolation={assignment.isolation}"]
        key = key_for(assignment, public=test.public)
        student = student_for(assignment, request["student"], public=test.public)
        options = {name: getattr(assignment, name) for name in (*RULES, "limits")}
        options |= {"frames": assignment._frames, "given": assignment.files_of_all}
        options["student"] = student
    with open(request["out"], "w", encoding="utf-8") as out:
        plugin = Points(out, public=test.public, key=key, options=options)
        return pytest.main([*arguments, str(test.path)], plugins=[plugin])


if __name__ == "__main__":
    raise SystemExit(main())
