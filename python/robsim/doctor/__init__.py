"""The estimator doctor: checks that say what is wrong with an estimator, and in which line."""

from robsim._base.check_report import CheckReport, Problem
from robsim._base.public import present as _present
from robsim._base.source_line import SourceLine
from robsim.doctor._parameter_estimators import check_parameter_estimator
from robsim.doctor._state_estimators import check_estimator

__all__ = [
    "CheckReport",
    "Problem",
    "SourceLine",
    "check_estimator",
    "check_parameter_estimator",
]

_present(globals())
