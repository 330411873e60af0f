"""The estimator doctor: what is wrong with a student's estimator, and where."""

from robsim.doctor.parameter_estimators import check_parameter_estimator
from robsim.doctor.report import Checkup, Finding
from robsim.doctor.state_estimators import check_estimator
from robsim.doctor.students_line import StudentsLine

__all__ = ["Checkup", "Finding", "StudentsLine", "check_estimator", "check_parameter_estimator"]
