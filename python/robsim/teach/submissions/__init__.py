"""Submissions: read without running them, sent to a worker, loaded there."""

from robsim.teach.submissions.files import SubmissionFiles
from robsim.teach.submissions.loading import load_slots, loaded_slots
from robsim.teach.submissions.reading import read_submission
from robsim.teach.submissions.rules import Rules

__all__ = ["Rules", "SubmissionFiles", "load_slots", "loaded_slots", "read_submission"]
