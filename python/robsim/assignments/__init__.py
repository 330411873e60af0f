"""Assignments: what students hand in, graded by tasks and tests, with reports."""

from robsim._base.public import present as _present
from robsim.assignments._assignment import Assignment, FileTests, TaskTest
from robsim.assignments._class_result import ClassResult
from robsim.assignments._grading.playing import PlayedRun
from robsim.assignments._results import FailedRun, ScoreResult, SubmissionResult, TestResult

__all__ = [
    "Assignment",
    "ClassResult",
    "FailedRun",
    "FileTests",
    "PlayedRun",
    "ScoreResult",
    "SubmissionResult",
    "TaskTest",
    "TestResult",
]

_present(globals())
