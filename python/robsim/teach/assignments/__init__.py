"""Assignments: submissions of students, graded by tasks and tests, with reports."""

from robsim.teach.assignments.assignment import Assignment, FileTests, LateRule, TaskTest
from robsim.teach.assignments.assignment_file import load_assignment
from robsim.teach.assignments.calibration import calibrate_assignment
from robsim.teach.assignments.checking import check_assignment
from robsim.teach.assignments.class_result import ClassResult
from robsim.teach.assignments.classes.class_run import grade_class, grade_submission, regrade_class
from robsim.teach.assignments.making import new_assignment
from robsim.teach.assignments.marking.playing import PlayedRun, play_run
from robsim.teach.assignments.packing.gradescope import pack_gradescope
from robsim.teach.assignments.packing.students import pack_feedback, pack_students
from robsim.teach.results import ByHand, FailedRun, ScoreResult, SubmissionResult, TestResult

__all__ = [
    "Assignment",
    "ByHand",
    "ClassResult",
    "FailedRun",
    "FileTests",
    "LateRule",
    "PlayedRun",
    "ScoreResult",
    "SubmissionResult",
    "TaskTest",
    "TestResult",
    "calibrate_assignment",
    "check_assignment",
    "grade_class",
    "grade_submission",
    "load_assignment",
    "new_assignment",
    "pack_feedback",
    "pack_gradescope",
    "pack_students",
    "play_run",
    "regrade_class",
]
