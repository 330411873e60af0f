"""The grading of a submission by pytest; loaded by `pytest_robsim`."""

from __future__ import annotations

import os
import sys
from collections.abc import Generator, Mapping, Sequence
from glob import glob
from importlib.machinery import PathFinder
from pathlib import Path
from typing import Any

import pluggy
import pytest

from robsim.base.spelling import check_names
from robsim.base.text import one_line
from robsim.teach.errors import AssignmentError, GraderError, GradingError, SubmissionError
from robsim.teach.grading.keys import Key
from robsim.teach.grading.submission import Submission
from robsim.teach.isolation import IsolationError, IsolationReport, check_isolation

_OPTION = "--robsim-submission"
_OPTIONS = ("slots", "functions", "imports", "masked", "frames", "limits")  # of the marker
_NOT_STRICT, _NO_WORKER = 3, 2  # exit statuses, the same as in ``robsim grade``
_WHOSE = "robsim_whose"  # of a report
# A fault of the submission is a failed test, a fault of others an error.
_FAILED, _ERROR = ("failed", "F", "FAILED"), ("error", "E", "ERROR")
_NOT_THEIRS = (
    Path(__file__).parents[2],  # robsim
    Path(__file__).parents[3] / "pytest_robsim",
    Path(pytest.__file__).parents[1] / "_pytest",
    Path(pluggy.__file__).parent,
)


class Grading:
    """A run of pytest that grades a submission; pytest.UsageError names a wrong option."""

    def __init__(self, config: pytest.Config) -> None:
        options = config.known_args_namespace
        if _OPTION in config.invocation_params.args:
            raise pytest.UsageError(
                f"write {_OPTION}={one_line(options.robsim_submission)}, with '=': after a space, "
                "pytest also treats the path as a path of tests, and uses a pytest.ini in it"
            )
        self._path = Path(os.path.abspath(options.robsim_submission))
        if not os.path.lexists(self._path):
            raise pytest.UsageError(f"{_OPTION}: {one_line(self._path)} is missing")
        _keep_apart(self._path, options.file_or_dir or _default_tests(config))
        try:
            self._key = None if options.robsim_key is None else Key.load(options.robsim_key)
        except AssignmentError as error:
            raise pytest.UsageError(f"--robsim-key: {error}") from None
        slots = options.robsim_slots
        self._slots = None if slots is None else [slot.strip() for slot in slots.split(",")]
        self._isolation = options.robsim_isolation
        self._report: IsolationReport | None = None
        self._given: dict[str, Any] = {}

    def grade_by(self, key: Key | None, options: Mapping[str, Any]) -> None:
        """Use a key and options of `Submission` for all tests; their markers change the options."""
        self._key, self._given = key, dict(options)

    def submission_for(self, item: pytest.Item) -> Submission:
        """Return the submission under the rules of a test."""
        rules = dict(self._given)
        if self._slots is not None:
            rules["slots"] = self._slots
        for marker in reversed([*item.iter_markers("robsim_submission")]):  # the nearest last
            if marker.args:
                raise AssignmentError('robsim_submission: give options by name: slots="control"')
            check_names("robsim_submission has no option", marker.kwargs, _OPTIONS, AssignmentError)
            rules |= marker.kwargs
        if not rules.keys() & {"slots", "functions"}:
            raise AssignmentError(
                "the slots of the submission are missing. In the tests, set pytestmark = "
                'pytest.mark.robsim_submission(slots="control"), or use --robsim-slots control'
            )
        try:
            return Submission(
                self._path,
                isolation=self._isolation,
                key=self._key,
                test=f"{item.path.stem}::{item.nodeid.partition('::')[2]}",
                **rules,
            )
        except (TypeError, ValueError) as error:
            raise AssignmentError(f"robsim_submission: {error}") from None

    def pytest_sessionstart(self, session: pytest.Session) -> None:
        """Exit at once if no submission can run, or if strict isolation is unavailable."""
        if hasattr(session.config, "workerinput"):  # a process of xdist: its parent checks
            return
        try:
            self._report = check_isolation(isolation=self._isolation)
        except IsolationError as error:
            pytest.exit(str(error), returncode=_NOT_STRICT)
        except GraderError as error:
            pytest.exit(f"no submission can be run: {error}", returncode=_NO_WORKER)
        if self._isolation == "strict" and not self._report.strict:
            pytest.exit(str(self._report), returncode=_NOT_STRICT)

    def pytest_report_header(self) -> list[str]:
        """Return the submission and its isolation."""
        if self._report is None:
            return []
        lines = [f"submission: {one_line(self._path)}", self._report.isolation_line]
        if through := [name for name, (held, _) in self._report.attempts.items() if not held]:
            lines.append(f"not refused to it: {', '.join(through)}")
        return lines

    def pytest_ignore_collect(self, collection_path: Path) -> bool | None:
        """Ignore the files in the submission, which would run here."""
        return _within(collection_path.resolve(), self._path.resolve()) or None

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_makereport(
        self, item: pytest.Item, call: pytest.CallInfo[None]
    ) -> Generator[None, pytest.TestReport, pytest.TestReport]:
        """Show the cause of an error instead of our own lines."""
        report = yield
        error = call.excinfo.value if call.excinfo is not None else None
        if report.failed and (output := printed_in(item, error)):
            report.sections.append(("printed by the submission", output))
        if call.excinfo is None or not isinstance(error, GradingError):
            return report
        setattr(report, _WHOSE, error.whose)  # xdist takes it along
        if not item.config.getoption("fulltrace"):
            report.longrepr = _in_short(call.excinfo, f"{error.whose}: {error}")
        return report

    @pytest.hookimpl(tryfirst=True)
    def pytest_report_teststatus(
        self, report: pytest.CollectReport | pytest.TestReport
    ) -> tuple[str, str, str] | None:
        """Count faults of a submission as failed, and faults of others as errors."""
        whose = getattr(report, _WHOSE, None)
        if whose is None:
            return None
        return _FAILED if whose == SubmissionError.whose else _ERROR


def printed_in(item: pytest.Item, error: BaseException | None) -> str:
    """Return the output of the submission in the last run of a test, or before its error."""
    fixtures = getattr(item, "funcargs", {})
    source = error if isinstance(error, SubmissionError) else fixtures.get("submission")
    return getattr(source, "output", "")


def _default_tests(config: pytest.Config) -> Sequence[str]:
    """Return the default paths of pytest's tests."""
    here = config.invocation_params.dir
    if here != config.rootpath:  # testpaths of a parent folder's pytest.ini do not count
        return [os.curdir]
    found = [path for pattern in config.getini("testpaths") for path in sorted(glob(pattern))]
    return found or [os.curdir]


def _keep_apart(path: Path, tests: Sequence[str]) -> None:
    """Raise pytest.UsageError if pytest would run files of a submission."""
    submission = path.resolve()
    if submission.is_dir() and _within(Path.cwd().resolve(), submission):
        raise pytest.UsageError(
            "this is the folder of the submission, where Python looks for modules: "
            "run pytest in another folder"
        )
    for test in tests:
        place = Path(test.partition("::")[0]).resolve()
        if _within(submission, place) or _within(place, submission):
            raise pytest.UsageError(
                f"{one_line(place)} and the submission {one_line(path)} overlap: pytest "
                "would run the submission's conftest.py and test_*.py. Name your own test files: "
                "python -m pytest --robsim-submission=PATH TESTS.py"
            )
        if submission.parent in (place.parent, Path.cwd().resolve()) and _is_module(submission):
            raise pytest.UsageError(
                f"{one_line(path)} has the name of a module in Python's search path for "
                "modules: put the submission into a folder of submissions"
            )


def _is_module(submission: Path) -> bool:
    """Whether Python finds another module of that name, which the submission would replace."""
    name, places = submission.stem, [*map(Path, sys.path)]
    if name in sys.modules or name in sys.stdlib_module_names:
        return True
    others = [str(place) for place in places if place.resolve() != submission.parent]
    found = PathFinder.find_spec(name, others)
    return found is not None and found.loader is not None


def _within(inner: Path, outer: Path) -> bool:
    return inner == outer or outer in inner.parents


def _in_short(excinfo: pytest.ExceptionInfo[BaseException], sentence: str) -> Any:
    """Return the short form of an error: the lines of the tests, and a sentence."""
    if not _lines_of_tests(excinfo):
        shown = excinfo.getrepr(style="value", chain=False)
    else:
        # The cause matters if it is the teacher's.
        chain = isinstance(excinfo.value, AssignmentError)
        shown = excinfo.getrepr(style="short", chain=chain, tbfilter=_lines_of_tests)
    if shown.reprcrash is not None:  # for a summary and JUnit
        shown.reprcrash.message = sentence
    return shown


def _lines_of_tests(excinfo: pytest.ExceptionInfo[BaseException]) -> Any:
    theirs = [
        entry
        for entry in excinfo.traceback
        if not any(folder in Path(entry.path).parents for folder in _NOT_THEIRS)
    ]
    return type(excinfo.traceback)(theirs)
