"""Grading: submissions that run in a process of their own, and whose fault it is if they fail."""

from robsim._base.public import present as _present
from robsim.grading._errors import AssignmentError, GraderError, GradingError, SubmissionError
from robsim.grading._isolation import (
    IsolationError,
    IsolationReport,
    Limits,
    check_isolation,
)
from robsim.grading._keys import Key
from robsim.grading._submission import Submission
from robsim.grading._texts import clean_text, fenced

__all__ = [
    "AssignmentError",
    "GraderError",
    "GradingError",
    "IsolationError",
    "IsolationReport",
    "Key",
    "Limits",
    "Submission",
    "SubmissionError",
    "check_isolation",
    "clean_text",
    "fenced",
]

_present(globals())
