"""Submissions: read without being run, sent to a worker, loaded there."""

from robsim.grading._submissions.files import SubmissionFiles
from robsim.grading._submissions.loading import load_slots, loaded_slots
from robsim.grading._submissions.reading import read_submission
from robsim.grading._submissions.rules import Rules

__all__ = ["Rules", "SubmissionFiles", "load_slots", "loaded_slots", "read_submission"]
