"""Grading: submissions that run in a process of their own, and whose fault it is if they fail."""

from robsim.teach.errors import AssignmentError, GraderError, GradingError, SubmissionError
from robsim.teach.grading.keys import Key
from robsim.teach.grading.submission import Submission
from robsim.teach.isolation import IsolationError, IsolationReport, WorkerLimits, check_isolation
from robsim.teach.texts import clean_text, fenced

__all__ = [
    "AssignmentError",
    "GraderError",
    "GradingError",
    "IsolationError",
    "IsolationReport",
    "Key",
    "Submission",
    "SubmissionError",
    "WorkerLimits",
    "check_isolation",
    "clean_text",
    "fenced",
]
