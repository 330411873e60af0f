"""Grading: runs of submissions in separate processes, and the cause of each failure."""

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
