import pytest


@pytest.fixture
def patient_grader(monkeypatch):
    """Let the grader wait until it knows how a worker ended, and for what it still prints."""
    monkeypatch.setattr("robsim.teach.grading._worker._DYING", 300.0)
    monkeypatch.setattr("robsim.teach.grading._worker._ENDING", 300.0)
