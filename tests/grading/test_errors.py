"""Whose fault it is, also beyond a process."""

import pickle

import pytest

from robsim.grading._errors import AssignmentError, GraderError, GradingError, SubmissionError


@pytest.mark.parametrize(
    ("kind", "whose"),
    [(SubmissionError, "submission"), (AssignmentError, "assignment"), (GraderError, "grader")],
)
def test_an_error_says_whose_fault_it_is_and_where(kind, whose):
    error = kind("control.py is a link", slot="control", step=3, file="control.py", line=4)
    again = pickle.loads(pickle.dumps(error))
    for each in (error, again):
        assert isinstance(each, GradingError)
        assert type(each) is kind
        assert each.whose == whose
        assert each.message == str(each) == "control.py is a link"
        assert (each.slot, each.step, each.file, each.line) == ("control", 3, "control.py", 4)
