"""Assignments: what students hand in, graded by tasks and tests, with reports."""

from robsim._base.public import present as _present
from robsim.assignments._assignment import Assignment, FileTests, TaskTest
from robsim.assignments._calibration import calibrate_assignment
from robsim.assignments._checking.check import check_assignment
from robsim.assignments._class_result import ClassResult
from robsim.assignments._grading.playing import PlayedRun
from robsim.assignments._making.folder import new_assignment
from robsim.assignments._packing.gradescope import pack_gradescope
from robsim.assignments._packing.students import pack_students
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
    "calibrate_assignment",
    "check_assignment",
    "new_assignment",
    "pack_gradescope",
    "pack_students",
]

_present(globals())
