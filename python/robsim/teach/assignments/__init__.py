"""Assignments: what students hand in, graded by tasks and tests, with reports."""

from robsim.base.doors import present as _present
from robsim.teach.assignments.assignment import Assignment, FileTests, TaskTest
from robsim.teach.assignments.calibration import calibrate_assignment
from robsim.teach.assignments.checking import check_assignment
from robsim.teach.assignments.class_result import ClassResult
from robsim.teach.assignments.grading.playing import PlayedRun
from robsim.teach.assignments.making import new_assignment
from robsim.teach.assignments.packing.gradescope import pack_gradescope
from robsim.teach.assignments.packing.students import pack_students
from robsim.teach.assignments.results import FailedRun, ScoreResult, SubmissionResult, TestResult

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
